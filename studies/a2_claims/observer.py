"""The ledger's lines on Theorem 1 and on the disturbance observer (24)."""

import numpy as np

from studies.a2_claims import arm, replay
from studies.a2_claims.checks import Checked, identity_finding, judges, refutation, row
from studies.a2_claims.searches import ASSUMPTION_4, CONSTANT_D, REACH, SEED, I, beside_rest
from workbench.claims.claim_ledger import Finding
from workbench.observers.luenberger import THEOREM_1
from workbench.proofs.interval import guarantee
from workbench.proofs.rest_points import growing_modes

TORQUES, SPEEDS = (100.0, 1000.0, 10000.0), (1.0, 10.0, 100.0)  # N m, rad/s
ASTRAY = ((3.1, 1.2), (-0.2, -2.9))  # q(0) [rad], qd(0) [rad/s]: of one decimal, and its neighbours go the same way
NEAR, DRAWN, EVENLY = (0.005, 0.05), 200, 2000  # rad and rad/s; starts near it, starts anywhere


@judges(
    "(15)", "The mismatch of (14) has |Delta| <= rho (|x1~| + |x2~|) with one rho for all states and torques.", "(15)"
)
def lipschitz() -> Finding:
    sizes = [replay.mismatch((0, 1), (torque, 0)) for torque in TORQUES]
    ratios = [replay.speed_ratio(speed) for speed in SPEEDS]
    slopes = np.diff(sizes) / np.diff(TORQUES)
    return refutation(
        bool((slopes > 0).all()) and np.allclose(slopes, slopes[0], rtol=1e-3),  # gravity is left, 1 % of 1000 N m
        f"Delta is affine in tau, with the factor M^-1(q) - M^-1(q_hat): with |x1~| = 1 rad, x2~ = 0 it is "
        f"{row(sizes, 5)} rad/s^2 for tau_1 = {row(TORQUES, 5)} N m. It is quadratic in the velocities: with "
        f"tau = 0, x1~ = 0 and qd_hat = 0, Delta = -M^-1 C(q, x2~) x2~, and |Delta| / |x2~| is {row(ratios, 5)} 1/s "
        f"for |x2~| = {row(SPEEDS, 5)} rad/s.",
        "[mismatch((0, 1), (torque, 0)) for torque in (100, 1000, 10000)], "
        "[speed_ratio(speed) for speed in (1, 10, 100)]",
    )


@judges(
    "(22)",
    "V1 = x1~^T P1 x1~ / 2 + x2~^T P2 x2~ / 2 has V1' <= -alpha V1 for some P1, P2, L1, L2.",
    "(17), (22)",
    lipschitz.claim,
)
def lyapunov() -> Finding:
    exact, rates = identity_finding("(22)"), replay.v1_rate((0, 1), (1, 1))
    if exact.kind != "proved":
        return exact
    return refutation(
        max(rates) > 0,
        "Beside the arm at rest with x1~ = 0, M x2~' = C(q, x2~) x2~, which is even in x2~ (proved by normal form). So "
        "V1' = x2~^T P2 x2~' is odd: at x2~ or at -x2~ it is not negative, whatever P1, P2, L1 and L2 are. With P2 = I "
        f"it is {row(rates)} rad^2/s^3 at x2~ = (1, 1) and (-1, -1) rad/s, q = (0, 1) rad.",
        "v1_rate((0, 1), (1, 1))",
    )


def any_gains() -> Finding:
    """Theorem 1 for the plainest positive definite gains."""
    growing = growing_modes(beside_rest(I, I, "up"))
    return refutation(
        bool(growing),
        "The theorem asks for 'positive definite matrices'. With L1 = L2 = I, beside the arm at rest upright without "
        f"torque, exactly {growing} of the 4 modes of the error grow (Routh's array in rational arithmetic). Its proof "
        "asks for large ones: see the gains of section 5, and ten and a hundred times these.",
        'growing_modes(beside_rest(I, I, "up"))',
    )


@judges(
    "Theorem 1, gains of section 5",
    "With L1 = 30 I, L2 = 50 I the errors of (10) tend to zero from every initial estimate.",
    "Theorem 1, section 5",
    arm.definite.claim,
    lyapunov.claim,
)
def paper_gains() -> Finding:
    point, ten, hundred = points = [replay.false_rest(times) for times in (1, 10, 100)]
    if any(point.radius is None for point in points) or not point.attracts:
        return Finding("not checkable", "a rest point with an error was computed, and could not be proved")
    return refutation(
        all(np.linalg.norm(point.x[:2]) > 4 * point.radius for point in points),
        f"Beside the hanging arm at rest, (10) rests at q_hat = {row(point.x[:2], 6)} rad, "
        f"qd_hat = {row(point.x[2:], 6)} rad/s: a rest point within {2 * point.radius:.0e} of the "
        f"computed one is proved to exist ({guarantee()}), with an error of {np.linalg.norm(point.x[:2]):.3f} rad for "
        "ever. All estimates near it stay and tend to it (proved). Large gains do not help: at 10 and 100 times "
        f"these, (10) rests at q_hat = {row(ten.x[:2], 6)} and {row(hundred.x[:2], 6)} rad (proved as well); "
        "of still larger ones nothing is proved here.",
        "false_rest(), false_rest(10), false_rest(100)",
    )


@judges(
    "Theorem 1, swinging arm",
    "With L1 = 30 I, L2 = 50 I, beside the arm without torque from |q_i(0)| <= pi, |qd_i(0)| <= 3 rad/s, |q - q_hat| "
    "stays below 5 rad from 1.5 s on.",
    "Theorem 1, as read here",
    arm.bounded_start.claim,
    arm.definite.claim,
)
def swinging() -> Finding:
    size, error = replay.astray(*ASTRAY)
    rng, start = np.random.default_rng(SEED), np.ravel(ASTRAY)
    shares = [replay.share_astray(start + rng.uniform(-r, r, (DRAWN, 4))) for r in NEAR]
    low, high = np.array([REACH[name] for name in ("plant.q", "plant.q", "plant.qd", "plant.qd")]).T
    rare = replay.share_astray(rng.uniform(low, high, (EVENLY, 4)))
    return refutation(
        size - error > 5,
        f"From q(0) = {row(ASTRAY[0])} rad, qd(0) = {row(ASTRAY[1])} rad/s, exactly these digits, |q - q_hat| is "
        f"{size:.2f} rad after 2 s, by variable steps with an error below {error:.0e} rad; no torque, and q_hat(0) = "
        f"qd_hat(0) = 0 as in section 5. Of {DRAWN} starts within {NEAR[0]:g} rad and rad/s of "
        f"it {100 * shares[0]:.0f} % part by more than 5 rad too, of as many within {NEAR[1]:g} {100 * shares[1]:.0f} "
        f"%. Such starts are rare: of {EVENLY:,} drawn evenly over all that the claim allows, {rare * EVENLY:.0f} do.",
        f"astray({ASTRAY[0]}, {ASTRAY[1]})",
    )


@judges(
    "Theorem 1, small errors at rest",
    "With L1 = 30 I, L2 = 50 I small errors of (10) decay beside the arm at rest, hanging or upright.",
    "Theorem 1, section 5",
)
def small_errors() -> Finding:
    counts = {zero: growing_modes(beside_rest(30 * I, 50 * I, zero)) for zero in ("down", "up")}
    if set(counts.values()) != {0}:
        return Finding("not checkable", f"Routh's array says {counts}")
    return Finding(
        "proved",
        "Routh's array of the error's four modes has no change of sign, in rational arithmetic, hanging and upright: "
        "all modes decay, so errors that are small enough do so too, exponentially.",
    )


@judges("(24)", "D_hat, the integral of eta, tends to D.", "(24)", ASSUMPTION_4)
def integral_of_eta() -> Finding:
    closed, run = replay.drift()
    return refutation(
        np.allclose(closed, run, rtol=1e-6) and bool((np.abs(run) > 2 * np.abs(CONSTANT_D)).all()),
        f"eta tends to D, so for a constant D the rate of D_hat tends to D, not to 0. For D = {row(CONSTANT_D)} "
        f"N m, D_hat is {row(run, 6)} after 10 s, where the closed form D (t - (1 - exp(-l t)) / l) gives "
        f"{row(closed, 6)}; its unit is N m s.",
        "drift()",
        kept=replay.kept_by_drift(),
    )


CHECKS = (
    *(lipschitz, lyapunov, Checked(THEOREM_1, any_gains)),
    *(paper_gains, swinging, small_errors, integral_of_eta),
)

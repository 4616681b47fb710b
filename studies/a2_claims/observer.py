"""The ledger's lines on Theorem 1 and on the disturbance observer (24)."""

import numpy as np

import workbench as wb
from studies.a2_claims import arm, replay
from studies.a2_claims.checks import CheckedClaim, identity, identity_ruling, judges, refutation, row, unbroken_claim
from studies.a2_claims.searches import ASSUMPTION_4, CONSTANT_D, REACH, SEED, I, beside_rest
from studies.paper.card import CARD
from studies.paper.laws import ARM

TORQUES, SPEEDS = (100.0, 1000.0, 10000.0), (1.0, 10.0, 100.0)  # N m, rad/s
REGION = wb.arms.observer_gains.Region(
    np.array([5.0, 5.0]), np.array([30.0, 30.0])
)  # rad/s, N m, at any position, as in a4
ASTRAY = ((3.1, 1.2), (-0.2, -2.9))  # q(0) [rad], qd(0) [rad/s]: of one decimal, and its neighbours go the same way
NEAR, RANDOM_STARTS, EVEN_STARTS = (0.005, 0.05), 200, 2000  # rad and rad/s; starts near it, starts anywhere


mean_rate = identity("(12)", "x1~' = x2~ - L1 x1~.", "(12)")
error_rate = identity("(13)", "x2~' is the difference of (9) and (10).", "(13)")
mismatch_rate = identity("(16)", "x2~' = -L2 x1~ + Delta.", "(14), (16)")
product_rule = identity("(18)", "V1' = x1~^T P1 x1~' + x2~^T P2 x2~', with P1 and P2 symmetric.", "(17), (18)")
expanded_rate = identity("(20)", "V1' of (18) with the rates of (19).", "(18)-(20)")


@judges(
    "(15)",
    "Where the right-hand side is Lipschitz continuous, some rho has |Delta| <= rho (|x1~| + |x2~|).",
    "(14), (15)",
)
def lipschitz() -> wb.proofs.Ruling:
    found = wb.arms.observer_gains.lipschitz(wb.arms.observer_gains.Mismatch.of(wb.arms.Dynamics.of(ARM)), REGION)
    position, velocity = found.position.upper, found.velocity.upper
    if not (np.isfinite(position) and np.isfinite(velocity)):
        return wb.proofs.Ruling("not checkable", "no bound of the derivatives was proved")
    return wb.proofs.Ruling(
        "proved",
        "The inequality is what Lipschitz continuity means. The condition holds on each bounded set of velocities and "
        f"torques. For |qd_i| <= {REGION.speed[0]:g} rad/s, |tau_i| <= {REGION.torque[0]:g} N m at any position, the "
        f"derivatives of the acceleration are at most {position:.0f} 1/s^2 and {velocity:.1f} 1/s, by intervals.",
    )


@judges(
    "(15), everywhere",
    "One rho serves all velocities and torques at once.",
    "(15), with 'globally' of Theorem 1",
)
def lipschitz_everywhere() -> wb.proofs.Ruling:
    sizes = [replay.mismatch((0, 1), (torque, 0)) for torque in TORQUES]
    ratios = [replay.speed_ratio(speed) for speed in SPEEDS]
    slopes = np.diff(sizes) / np.diff(TORQUES)
    if not ((slopes > 0).all() and np.allclose(slopes, slopes[0], rtol=1e-3)):  # gravity is left, 1 % of 1000 N m
        return unbroken_claim()
    return wb.proofs.Ruling(
        "does not hold under",
        f"Delta is affine in tau, with the factor M^-1(q) - M^-1(q_hat): with |x1~| = 1 rad, x2~ = 0 it is "
        f"{row(sizes, 5)} rad/s^2 for tau_1 = {row(TORQUES, 5)} N m. It is quadratic in the velocities: with "
        f"tau = 0, x1~ = 0 and qd_hat = 0, Delta = -M^-1 C(q, x2~) x2~, and |Delta| / |x2~| is {row(ratios, 5)} 1/s "
        f"for |x2~| = {row(SPEEDS, 5)} rad/s.",
        "[mismatch((0, 1), (torque, 0)) for torque in (100, 1000, 10000)], "
        "[speed_ratio(speed) for speed in (1, 10, 100)]",
        under="all velocities and torques at once",
    )


@judges("(21)", "V1' is at most the sum of four terms with the constants lambda1, lambda2, c1 and c2.", "(20), (21)")
def four_terms() -> wb.proofs.Ruling:
    return wb.proofs.Ruling(
        "not checkable as published",
        "Where (15) holds, (21) is true for c1 and c2 that are large enough, whatever lambda1 and lambda2 are. "
        "It does not follow with lambda2 > 0 from (20), whose term x2~^T P2 L2 x1~ has either sign.",
        unstated_numbers="the four constants",
    )


@judges(
    "(22)",
    "With some P1, P2 and gains L1, L2 that are large enough, V1' <= -alpha V1 for some alpha > 0.",
    "(17), (22)",
    lipschitz.claim,
)
def lyapunov() -> wb.proofs.Ruling:
    exact, rates = identity_ruling("(22)"), replay.v1_rate((0, 1), (1, 1))
    if exact.kind != "proved":
        return exact
    return refutation(
        max(rates) > 0,
        "Beside the arm at rest with x1~ = 0, M x2~' = C(q, x2~) x2~, which is even in x2~ (proved by normal form). So "
        "V1' = x2~^T P2 x2~' is odd: at x2~ or at -x2~ it is not negative, whatever P1, P2, L1 and L2 are, and however "
        "small x2~ is. With P2 = I, "
        f"V1' is {row(rates)} rad^2/s^3 at x2~ = (1, 1) and (-1, -1) rad/s, q = (0, 1) rad.",
        "v1_rate((0, 1), (1, 1))",
    )


def any_gains() -> wb.proofs.Ruling:
    """Theorem 1 for the plainest positive definite gains."""
    growing = wb.proofs.growing_modes(beside_rest(I, I, "up"))
    return refutation(
        bool(growing),
        "The theorem needs 'positive definite matrices'. With L1 = L2 = I, beside the arm at rest upright without "
        f"torque, exactly {growing} of the 4 modes of the error grow (Routh's array in rational arithmetic). The proof "
        "of the theorem needs large gains: the next row has those of section 5, and ten and a hundred times these.",
        'growing_modes(beside_rest(I, I, "up"))',
    )


@judges(
    "Theorem 1, gains of section 5",
    "With L1 = 30 I, L2 = 50 I the errors of (10) tend to zero from every initial estimate.",
    "Theorem 1, section 5",
    arm.definite.claim,
    lyapunov.claim,
)
def paper_gains() -> wb.proofs.Ruling:
    point, ten, hundred = points = [replay.false_rest(times) for times in (1, 10, 100)]
    radii = [one.radius for one in points if one.radius is not None]
    if len(radii) < len(points) or not point.attracts:
        return wb.proofs.Ruling("not checkable", "an equilibrium with an error was computed, and could not be proved")
    return refutation(
        all(np.linalg.norm(one.x[:2]) > 4 * radius for one, radius in zip(points, radii, strict=True)),
        f"Beside the hanging arm at rest, (10) has an equilibrium at q_hat = {row(point.x[:2], 6)} rad, "
        f"qd_hat = {row(point.x[2:], 6)} rad/s, with an error of {np.linalg.norm(point.x[:2]):.3f} rad for ever. An "
        f"equilibrium within {2 * radii[0]:.0e} of the computed one is proved to exist ({wb.proofs.guarantee()}). All "
        "estimates near it stay near it and tend to it (proved). Large gains do not help: with 10 and 100 times these "
        f"gains, (10) has an equilibrium at q_hat = {row(ten.x[:2], 6)} and {row(hundred.x[:2], 6)} rad (proved as "
        "well). For still larger gains nothing is proved here.",
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
def swinging_arm() -> wb.proofs.Ruling:
    size, error = replay.astray(*ASTRAY)
    rng, start = np.random.default_rng(SEED), np.ravel(ASTRAY)
    shares = [replay.share_astray(start + rng.uniform(-r, r, (RANDOM_STARTS, 4))) for r in NEAR]
    low, high = np.array([REACH[name] for name in ("plant.q", "plant.q", "plant.qd", "plant.qd")]).T
    rare = replay.share_astray(rng.uniform(low, high, (EVEN_STARTS, 4)))
    if size - error <= 5:
        return unbroken_claim()
    return wb.proofs.Ruling(
        "does not hold under",
        f"From q(0) = {row(ASTRAY[0])} rad, qd(0) = {row(ASTRAY[1])} rad/s, exactly these digits, |q - q_hat| is "
        f"{size:.2f} rad after 2 s, by variable steps with an error below {error:.0e} rad. There is no torque, and "
        f"q_hat(0) = qd_hat(0) = 0 as in section 5. Of {RANDOM_STARTS} starts within {NEAR[0]:g} rad and rad/s of this "
        f"start, {100 * shares[0]:.0f} % also lead to an error of more than 5 rad; of as many within {NEAR[1]:g}, "
        f"{100 * shares[1]:.0f} %. Such starts are rare: of {EVEN_STARTS:,} drawn evenly over all starts that the "
        f"claim allows, {rare * EVEN_STARTS:.0f} lead to such an error.",
        f"astray({ASTRAY[0]}, {ASTRAY[1]})",
        under="a bound of 5 rad from 1.5 s on, which the theorem does not name",
    )


@judges(
    "Theorem 1, small errors at rest",
    "With L1 = 30 I, L2 = 50 I small errors of (10) decay beside the arm at rest, hanging or upright.",
    "Theorem 1, section 5",
)
def small_errors() -> wb.proofs.Ruling:
    counts = {zero: wb.proofs.growing_modes(beside_rest(30 * I, 50 * I, zero)) for zero in ("down", "up")}
    if set(counts.values()) != {0}:
        return wb.proofs.Ruling("not checkable", f"Routh's array says {counts}")
    return wb.proofs.Ruling(
        "proved",
        "Routh's array of the error's four modes has no change of sign, in rational arithmetic, hanging and upright: "
        "all modes decay, so errors that are small enough decay exponentially.",
    )


@judges("(24)", "D_hat, the integral of eta, tends to D exponentially fast.", "(24)", ASSUMPTION_4)
def integral_of_eta() -> wb.proofs.Ruling:
    closed, run = replay.drift()
    amplitude, frequency = (np.array(CARD[f"FS: disturbance {part}"]) for part in ("amplitude", "frequency"))
    lag = amplitude * frequency / np.hypot(frequency, CARD["l"])  # of |eta - D|, for a sine
    return refutation(
        np.allclose(closed, run, rtol=1e-6) and bool((np.abs(run) > 2 * np.abs(CONSTANT_D)).all()),
        f"eta tends to D, so for a constant D the rate of D_hat tends to D, not to 0. For D = {row(CONSTANT_D)} "
        f"N m, D_hat is {row(run, 6)} after 10 s, where the closed form D (t - (1 - exp(-l t)) / l) gives "
        f"{row(closed, 6)}; the unit of D_hat is N m s. With eta in place of its integral the claim is true for a "
        f"constant D. For the sines of the first scenario and l = {CARD['l']:g} 1/s, |D - eta| keeps reaching "
        f"{row(lag, 2)} N m.",
        "drift()",
        kept_hypotheses=replay.kept_by_drift(),
    )


CHECKS = (
    *(mean_rate, error_rate, lipschitz, lipschitz_everywhere, mismatch_rate, product_rule, expanded_rate, four_terms),
    *(lyapunov, CheckedClaim(wb.arms.observers.THEOREM_1, any_gains)),
    *(paper_gains, swinging_arm, small_errors, integral_of_eta),
)

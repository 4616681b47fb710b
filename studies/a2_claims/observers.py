"""The ledger's lines on Theorem 1 and on the disturbance observer (24)."""

from collections.abc import Sequence

import numpy as np

from studies.a2_claims import statements as paper
from studies.a2_claims.checks import Check, identity, listed
from studies.a2_claims.loops import CONSTANT_D, I, beside_rest
from studies.a2_claims.replay import (
    astray,
    drift,
    false_rest,
    kept_by_drift,
    mismatch,
    share_astray,
    speed_ratio,
    v1_rate,
)
from studies.a2_claims.searches import REACH, SEED
from workbench.claims.verdicts import Finding
from workbench.core import Claim
from workbench.observers.luenberger import THEOREM_1
from workbench.proofs.interval import guarantee
from workbench.proofs.rest_points import RestPoint, growing_modes

PAPER_GAINS = (30 * I, 50 * I)  # section 5
TORQUES, SPEEDS = (100.0, 1000.0, 10000.0), (1.0, 10.0, 100.0)  # N m, rad/s
ASTRAY = ((3.1, 1.2), (-0.2, -2.9))  # q(0) [rad], qd(0) [rad/s]: of one decimal, and its neighbours go the same way
NEAR, DRAWN, EVENLY = (0.005, 0.05), 200, 2000  # rad and rad/s; starts near it, starts anywhere


def lipschitz() -> Finding:
    """(15): Delta grows with the torque while the errors stay as they are."""
    sizes = [mismatch((0, 1), (torque, 0)) for torque in TORQUES]
    slopes = np.diff(sizes) / np.diff(TORQUES)
    if not (slopes > 0).all() or not np.allclose(slopes, slopes[0], rtol=1e-3):  # gravity is left, 1 % of 1000 N m
        return Finding("not refuted", f"Delta does not grow with the torque: {listed(sizes)} rad/s^2", samples=3)
    ratios = [speed_ratio(speed) for speed in SPEEDS]
    return Finding(
        "refuted",
        f"Delta is affine in tau, with the factor M^-1(q) - M^-1(q_hat): with |x1~| = 1 rad, x2~ = 0 it is "
        f"{listed(sizes, 5)} rad/s^2 for tau_1 = {listed(TORQUES, 5)} N m. It is quadratic in the velocities: with "
        f"tau = 0, x1~ = 0 and qd_hat = 0, Delta = -M^-1 C(q, x2~) x2~, and |Delta| / |x2~| is {listed(ratios, 5)} 1/s "
        f"for |x2~| = {listed(SPEEDS, 5)} rad/s. The 'smoothness (Lipschitz continuity)' that (15) assumes "
        "is there where torques and velocities are both bounded, with a rho that grows with these bounds.",
        "[mismatch((0, 1), (torque, 0)) for torque in (100, 1000, 10000)], "
        "[speed_ratio(speed) for speed in (1, 10, 100)]",
    )


def lyapunov() -> Finding:
    """(22): V1' is odd in x2~ where x1~ = 0 beside the arm at rest."""
    found = identity("(22)")()
    if found.kind != "proved":
        return found
    rates = v1_rate((0, 1), (1, 1))
    if max(rates) <= 0:
        return Finding("not refuted", f"V1' is {listed(rates)} rad^2/s^3 at x2~ and -x2~", samples=2)
    return Finding(
        "refuted",
        "Beside the arm at rest with x1~ = 0, M x2~' = C(q, x2~) x2~, which is even in x2~ (proved by normal form). So "
        "V1' = x2~^T P2 x2~' is odd: at x2~ or at -x2~ it is not negative, whatever P1, P2, L1 and L2 are. With P2 = I "
        f"it is {listed(rates)} rad^2/s^3 at x2~ = (1, 1) and (-1, -1) rad/s, q = (0, 1) rad.",
        "v1_rate((0, 1), (1, 1))",
    )


def any_gains() -> Finding:
    """Theorem 1 for the plainest positive definite gains."""
    growing = growing_modes(beside_rest(I, I, "up"))
    if not growing:
        return Finding("not refuted", "no mode grows with L1 = L2 = I beside the upright arm", samples=1)
    return Finding(
        "refuted",
        "The theorem asks for 'positive definite matrices', its proof for 'Choosing L1, L2 sufficiently large'. As the "
        f"theorem reads: with L1 = L2 = I, beside the arm at rest upright without torque, exactly {growing} of the 4 "
        "modes of the error grow (Routh's array in rational arithmetic): zero error is not even stable. As its "
        "proof reads: see the gains of section 5, and ten and a hundred times these.",
        'growing_modes(beside_rest(I, I, "up"))',
    )


def paper_gains() -> Finding:
    """Theorem 1 for the gains of section 5: a rest point with an error that is not zero."""
    point, far = false_rest(), [false_rest(times) for times in (10, 100)]
    if point.radius is None:
        return Finding("not checkable", "a rest point with an error was computed, and could not be proved")
    if np.linalg.norm(point.x[:2]) <= 4 * point.radius:
        return Finding("not refuted", "the rest point that was found has no error", samples=1)
    basin = " All estimates near it stay and tend to it (proved)." if point.attracts else ""
    return Finding(
        "refuted",
        f"Beside the hanging arm at rest, (10) rests at q_hat = {listed(point.x[:2], 6)} rad, "
        f"qd_hat = {listed(point.x[2:], 6)} rad/s: a rest point within {2 * point.radius:.0e} of the "
        f"computed one is proved to exist ({guarantee()}), with an error of {np.linalg.norm(point.x[:2]):.3f} rad for "
        f"ever.{basin}{_still_there(far)}",
        "false_rest(), false_rest(10), false_rest(100)",
    )


def _still_there(points: Sequence[RestPoint]) -> str:
    """Where the false rest lies at ten and a hundred times the gains, if it is proved there."""
    if any(point.radius is None or np.linalg.norm(point.x[:2]) <= 4 * point.radius for point in points):
        return ""
    places = " and ".join(listed(point.x[:2], 6) for point in points)
    return (
        f" Large gains do not help: at 10 and 100 times these, (10) rests at q_hat = {places} rad (proved as well); of "
        "still larger ones nothing is proved here."
    )


def small_errors() -> Finding:
    """What is true of it: errors beside the arm at rest, linearised, exactly."""
    counts = {zero: growing_modes(beside_rest(*PAPER_GAINS, zero)) for zero in ("down", "up")}
    if set(counts.values()) != {0}:
        return Finding("not checkable", f"Routh's array says {counts}")
    return Finding(
        "proved",
        "Routh's array of the error's four modes has no change of sign, in rational arithmetic, hanging and upright: "
        "all modes decay, so errors that are small enough do so too, exponentially.",
    )


def swinging() -> Finding:
    """The free arm from one start, and from its neighbours."""
    size, error = astray(*ASTRAY)
    if size - error <= 5:
        return Finding("not refuted", f"|q - q_hat| is {size:.3g} rad after 2 s", samples=1)
    rng, start = np.random.default_rng(SEED), np.ravel(ASTRAY)
    shares = [share_astray(start + rng.uniform(-r, r, (DRAWN, 4))) for r in NEAR]
    low, high = np.array([REACH[name] for name in ("plant.q", "plant.q", "plant.qd", "plant.qd")]).T
    rare = share_astray(rng.uniform(low, high, (EVENLY, 4)))
    return Finding(
        "refuted",
        f"From q(0) = {listed(ASTRAY[0])} rad, qd(0) = {listed(ASTRAY[1])} rad/s, exactly these digits, |q - q_hat| is "
        f"{size:.2f} rad after 2 s, by variable steps with an error below {error:.0e} rad; no torque, and q_hat(0) = "
        f"qd_hat(0) = 0 as in section 5. Of {DRAWN} starts within {NEAR[0]:g} rad and rad/s of "
        f"it {100 * shares[0]:.0f} % part by more than 5 rad too, of as many within {NEAR[1]:g} {100 * shares[1]:.0f} "
        f"%. Such starts are rare: of {EVENLY:,} drawn evenly over all that the claim allows, {rare * EVENLY:.0f} do.",
        f"astray({ASTRAY[0]}, {ASTRAY[1]})",
    )


def integral_of_eta() -> Finding:
    """(24) for a constant D, which Assumption 4 allows."""
    closed, run = drift()
    if not np.allclose(closed, run, rtol=1e-6) or (np.abs(run) < 2 * np.abs(CONSTANT_D)).any():
        return Finding("not refuted", f"D_hat is {listed(run)} after 10 s, not far beyond D", samples=1)
    return Finding(
        "refuted",
        f"eta tends to D, so for a constant D the rate of D_hat tends to D, not to 0. For D = (0.5, 0.4) N m, D_hat is "
        f"{listed(run, 6)} after 10 s, where the closed form D (t - (1 - exp(-l t)) / l) gives {listed(closed, 6)}; "
        "its unit is N m s.",
        "drift()",
        kept=kept_by_drift(),
    )


SWINGING = Claim(
    "Theorem 1, swinging arm",
    "With L1 = 30 I, L2 = 50 I, beside the arm without torque from |q_i(0)| <= pi, |qd_i(0)| <= 3 rad/s, |q - q_hat| "
    "stays below 5 rad from 1.5 s on.",
    "Theorem 1, as read here",
    (paper.ASSUMPTION_1, paper.ASSUMPTION_2),
)
CHECKS: tuple[tuple[Claim, Check], ...] = (
    (paper.LIPSCHITZ, lipschitz),
    (paper.LYAPUNOV, lyapunov),
    (THEOREM_1, any_gains),
    (paper.PAPER_GAINS, paper_gains),
    (SWINGING, swinging),
    (paper.NEAR_ZERO, small_errors),
    (paper.DISTURBANCE_OBSERVER, integral_of_eta),
)

"""The gains that a4 compares, and the audit of each."""

from dataclasses import dataclass

import numpy as np

import workbench as wb
from studies.paper.card import CARD
from studies.paper.laws import ARM

I, REST = np.eye(2), np.zeros(2)
DYNAMICS = wb.arms.Dynamics.of(ARM)
MISMATCH = wb.arms.observer_gains.Mismatch.of(DYNAMICS)
REGION = wb.arms.observer_gains.Region(np.array([5.0, 5.0]), np.array([30.0, 30.0]))  # rad/s, N m, at any position
INNER = 0.8  # of the speeds are the arm's own, the rest is room for the error of its estimate
SURFACE = float(min(CARD["Lambda"]))  # 1/s, as fast as which the estimate should at least be
SMALL, WHOLE = 0.1, 1.0  # shares of the region
MODEST = 0.1  # 1/s, the rate that is asked of the paper's gains, as they keep no more
BOX = f"|qd_i| ≤ {REGION.speed[0]:g} rad/s, |tau_i| ≤ {REGION.torque[0]:g} N m, any position"
SCENARIOS = ("first scenario", "first scenario, from y(0)", "second scenario")
PAPER, DOUBLE_POLE, LMI = "paper", "double pole", "LMI"  # chosen: of those with a proof in the whole region
POLES = (22.0, 26.0, 30.0, 35.0, 40.0, 50.0, 60.0)  # 1/s, of the curve beside the gains
HOW = {
    PAPER: "section 5",
    DOUBLE_POLE: f"the least double pole that is proved to decay at {SURFACE:g} 1/s in the whole region",
    "high gain": "a1 = 3, a2 = 2, epsilon = 25 ms: poles at -40 and -80 1/s",
    "Kalman": wb.document.superscript_powers(
        "beside the hanging arm; noise of 1e-4 rad^2 s, unknown accelerations of 1000 rad^2/s^3"
    ),
    LMI: f"the least bound of noise with {SURFACE:g} 1/s in the whole region, all by one LMI",
}
STYLES = {name: i for i, name in enumerate(HOW)}
CLOUD = 300  # states of the cloud of poles
CLEAR = 1.0  # s after a jump that the late error leaves out: six time constants of the surface
LATE, WITH_JUMPS = "late error", "late error with jumps"
TABLE_METRICS = (LATE, "RMS qd_error", "peak torque")
# The columns of the audits, each with its unit, its digits and its definition.
COLUMNS = (
    ("growing modes", "%", 3, "share of 20,000 states, spread over the region, at which a frozen mode grows"),
    ("slowest mode", "1/s", 3, "decay of the slowest frozen mode at these states; negative if a mode grows"),
    ("slowest on the path", "1/s", 3, "the same decay along the desired motion of the first scenario"),
    (
        "proved share",
        "%",
        2,
        f"part of the region's speeds and torques in which a decay is proved: {MODEST:g} 1/s with "
        f"the paper's gains, {SURFACE:g} 1/s with all others",
    ),
    (
        "admitted error",
        "mrad",
        2,
        "largest first error |q - q_hat| for which this proof holds, with qd_hat = qd and an "
        f"arm within {100 * INNER:g} % of the speeds of the proved share",
    ),
    (
        "tolerated mismatch",
        "",
        3,
        "largest rho for which one quadratic form proves a decay for all |Delta| ≤ rho |x~|, in rad and rad/s",
    ),
    (
        "noise",
        "s^(-3/2)",
        3,
        "H2 norm from the noise of the positions to qd_hat, where the model adds nothing; white "
        "noise of density S gives sqrt(S) times it",
    ),
    ("peak", "1/s", 3, "largest |qd - qd_hat| for a first error of 1 rad, where the model adds nothing"),
    ("bound of the peak", "1/s", 3, "the same, proved in the region of the certificate"),
)


@dataclass(frozen=True, eq=False)
class Candidate:
    """Gains L1 and L2, and all that is seen and proved of them.

    Seen at `states` of the region: the share of them where a mode is `growing_share`, the decay of the `slowest` mode
    in 1/s, and real and imaginary part of some poles, `cloud` (2, M) in 1/s; `path` is the decay of the slowest mode at
    `instants` of the desired motion. Proved in a `share` of the region, of a `speed` and a `torque`: errors in rad that
    are `admitted_radius`, and a `bound` of the peak in 1/s; None where nothing is proved, for the reason `why`.
    """

    L1: wb.Array
    L2: wb.Array
    states: int
    growing_share: float
    slowest: float
    cloud: wb.Array
    instants: int
    path: float
    share: float | None
    speed: float | None
    torque: float | None
    admitted_radius: float | None
    bound: float | None
    tolerated_mismatch: float
    noise: float
    peaking: float
    why: str


def design(name: str) -> tuple[wb.arms.observer_gains.Gains, wb.arms.observer_gains.RateCertificate | None]:
    """The gains of a name of HOW, with their certificate in the whole region if they come with one."""
    if name in (DOUBLE_POLE, LMI):
        search = wb.arms.observer_gains.by_lmi if name == LMI else wb.arms.observer_gains.least_double_pole
        one = search(DYNAMICS, REGION, SURFACE)
        return one.gains, one
    if name == PAPER:
        return wb.arms.observer_gains.Gains(CARD["L1"], CARD["L2"]), None
    if name == "high gain":
        return wb.arms.observer_gains.high_gain(2, 3.0, 2.0, 0.025), None
    return wb.arms.observer_gains.kalman(DYNAMICS, REST, REST, REST, 1e3 * I, 1e-4 * I), None


def candidate(name: str) -> Candidate:
    """The gains of a name of HOW: of the paper's a modest rate is asked, of the others that of the surface."""
    mine, certificate = design(name)
    rate = MODEST if name == PAPER else SURFACE
    one = wb.arms.observer_gains.audit(DYNAMICS, mine, REGION, INNER, rate, certificate)
    seen, along, region = one.frozen_poles, frozen_poles(mine), one.certificate.region if one.certificate else None
    cloud = seen.poles[:CLOUD].ravel()
    return Candidate(
        L1=mine.L1,
        L2=mine.L2,
        states=len(seen.rates),
        growing_share=seen.unstable,
        slowest=seen.slowest,
        cloud=np.array([cloud.real, cloud.imag]),
        instants=len(along.rates),
        path=along.slowest,
        share=one.share,
        speed=float(region.speed[0]) if region else None,
        torque=float(region.torque[0]) if region else None,
        admitted_radius=one.admitted_errors.position if one.admitted_errors else None,
        bound=one.admitted_errors.peaking if one.admitted_errors else None,
        tolerated_mismatch=one.tolerated_mismatch,
        noise=one.noise.velocity,
        peaking=one.peaking,
        why=one.why,
    )


def frozen_poles(gains: wb.arms.observer_gains.Gains) -> wb.arms.observer_gains.FrozenPoles:
    """The frozen poles along the desired motion of the first scenario."""
    t = np.linspace(0, 2 * np.pi, 601)
    a, w = (np.array(CARD[f"FS: reference {name}"]) for name in ("amplitude", "frequency"))
    q, qd, qdd = a * np.sin(np.outer(t, w)), a * w * np.cos(np.outer(t, w)), -a * w**2 * np.sin(np.outer(t, w))
    tau = np.array([DYNAMICS.torque(*state) for state in zip(q, qd, qdd, strict=True)])
    return wb.arms.observer_gains.frozen_poles_along(MISMATCH, gains, REGION, q, qd, tau)


def lipschitz(share: float) -> wb.arms.observer_gains.Lipschitz:
    """The Lipschitz constants over a share of the region."""
    return wb.arms.observer_gains.lipschitz(MISMATCH, REGION.scale(share))


def trade_off(poles: tuple[float, ...]) -> wb.Array:
    """The slowest frozen rate seen in the region, and the noise of the velocity, of each double pole: (2, N)."""
    placed = [wb.arms.observer_gains.high_gain(2, 2.0, 1.0, 1 / p) for p in poles]
    slowest = [wb.arms.observer_gains.frozen_poles_over(MISMATCH, mine, REGION, 4000).slowest for mine in placed]
    return np.array([slowest, [wb.arms.observer_gains.noise(mine).velocity for mine in placed]])


WORKS = (
    wb.Work("gains", candidate, tuple(HOW), seconds=2.5),
    wb.Work("lipschitz", lipschitz, (SMALL, WHOLE), seconds=0.8),
    wb.Work("trade_off", trade_off, (POLES,), seconds=0.1),
)


def candidates(results: wb.Results) -> dict[str, Candidate]:
    """The candidates by name, in the order of HOW."""
    return dict(zip(HOW, results.work("gains"), strict=True))

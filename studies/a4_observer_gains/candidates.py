"""The gains that a4 compares, the audit of each, once, and their pictures and tables."""

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
PAPER, CHOSEN, LMI = "paper", "double pole", "LMI"  # chosen: of those with a proof in the whole region
POLES = (22.0, 26.0, 30.0, 35.0, 40.0, 50.0, 60.0)  # 1/s, of the curve beside the gains
HOW = {
    PAPER: "section 5",
    CHOSEN: f"the least double pole that is proved to decay at {SURFACE:g} 1/s in the whole region",
    "high gain": "a1 = 3, a2 = 2, epsilon = 25 ms: poles at -40 and -80 1/s",
    "Kalman": wb.document.raised(
        "beside the hanging arm; noise of 1e-4 rad^2 s, unknown accelerations of 1000 rad^2/s^3"
    ),
    LMI: f"the least bound of noise with {SURFACE:g} 1/s in the whole region, all by one LMI",
}
STYLES = {name: i for i, name in enumerate(HOW)}
CLOUD = 300  # states of the cloud of poles
CLEAR = 1.0  # s after a jump that the late error leaves out: six time constants of the surface
LATE, WITH_JUMPS = "late error", "late error with jumps"
SHOWN = (LATE, "RMS qd_error", "peak torque")
# The columns of the audits, each with its unit, its digits and its definition.
COLUMNS = (
    ("growing modes", "%", 3, "states of the region, of 20,000 spread over it, at which a frozen mode grows"),
    ("slowest mode", "1/s", 3, "decay of the slowest frozen mode at these states; negative where a mode grows"),
    ("slowest on the path", "1/s", 3, "the same along the desired motion of the first scenario"),
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
        "largest first error |q - q_hat| for which that proof holds, with qd_hat = qd and an "
        f"arm within {100 * INNER:g} % of the speeds of that share",
    ),
    (
        "borne mismatch",
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

    Seen at `states` of the region: the share of them where a mode is `growing`, the decay of the `slowest` mode in 1/s,
    and real and imaginary part of some poles, `cloud` (2, M) in 1/s; `path` is the decay of the slowest mode at
    `instants` of the desired motion. Proved in a `share` of the region, of a `speed` and a `torque`: errors in rad that
    are `admitted`, and a `bound` of the peak in 1/s; None where nothing is proved, for the reason `why`.
    """

    L1: wb.Array
    L2: wb.Array
    states: int
    growing: float
    slowest: float
    cloud: wb.Array
    instants: int
    path: float
    share: float | None
    speed: float | None
    torque: float | None
    admitted: float | None
    bound: float | None
    tolerated: float
    noise: float
    peaking: float
    why: str


def design(name: str) -> tuple[wb.arms.observer_gains.Gains, wb.arms.observer_gains.RateCertificate | None]:
    """The gains of a name of HOW, with their certificate in the whole region if they come with one."""
    if name in (CHOSEN, LMI):
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
    seen, along, region = one.frozen, followed(mine), one.certificate.region if one.certificate else None
    cloud = seen.poles[:CLOUD].ravel()
    return Candidate(
        L1=mine.L1,
        L2=mine.L2,
        states=len(seen.rates),
        growing=seen.unstable,
        slowest=seen.slowest,
        cloud=np.array([cloud.real, cloud.imag]),
        instants=len(along.rates),
        path=along.slowest,
        share=one.share,
        speed=float(region.speed[0]) if region else None,
        torque=float(region.torque[0]) if region else None,
        admitted=one.reach.position if one.reach else None,
        bound=one.reach.peaking if one.reach else None,
        tolerated=one.tolerated,
        noise=one.noise.velocity,
        peaking=one.peaking,
        why=one.why,
    )


def followed(gains: wb.arms.observer_gains.Gains) -> wb.arms.observer_gains.Frozen:
    """The frozen poles along the desired motion of the first scenario."""
    t = np.linspace(0, 2 * np.pi, 601)
    a, w = (np.array(CARD[f"FS: reference {name}"]) for name in ("amplitude", "frequency"))
    q, qd, qdd = a * np.sin(np.outer(t, w)), a * w * np.cos(np.outer(t, w)), -a * w**2 * np.sin(np.outer(t, w))
    tau = np.array([DYNAMICS.torque(*state) for state in zip(q, qd, qdd, strict=True)])
    return wb.arms.observer_gains.along(MISMATCH, gains, REGION, q, qd, tau)


def lipschitz(share: float) -> wb.arms.observer_gains.Lipschitz:
    """The Lipschitz constants over a share of the region."""
    return wb.arms.observer_gains.lipschitz(MISMATCH, REGION.scaled(share))


def trade_off(poles: tuple[float, ...]) -> wb.Array:
    """The slowest frozen rate seen in the region, and the noise of the velocity, of each double pole: (2, N)."""
    placed = [wb.arms.observer_gains.high_gain(2, 2.0, 1.0, 1 / p) for p in poles]
    slowest = [wb.arms.observer_gains.over(MISMATCH, mine, REGION, 4000).slowest for mine in placed]
    return np.array([slowest, [wb.arms.observer_gains.noise(mine).velocity for mine in placed]])


WORKS = (
    wb.Work("gains", candidate, tuple(HOW), seconds=2.5),
    wb.Work("lipschitz", lipschitz, (SMALL, WHOLE), seconds=0.8),
    wb.Work("trade_off", trade_off, (POLES,), seconds=0.1),
)


def candidates(results: wb.Results) -> dict[str, Candidate]:
    """The candidates by name, in the order of HOW."""
    return dict(zip(HOW, results.work("gains"), strict=True))


def poles(results: wb.Results) -> wb.document.Figure:
    """The frozen poles of the paper's gains and of the chosen ones, at states of the region."""
    panels = []
    for name in (PAPER, CHOSEN):
        real, imaginary = candidates(results)[name].cloud
        marks = wb.document.Series(name, real, imaginary, STYLES[name], look="marks")
        panels.append(
            wb.document.Panel("imaginary part [1/s]", (marks,), xlabel="real part [1/s]", vlines=(0.0,), title=name)
        )
    caption = (
        f"Poles of the error with state and torque frozen, at {CLOUD} states of the region. Right of the line at zero "
        "a mode grows."
    )
    return wb.document.Figure("poles", caption, tuple(panels), columns=2)


def noise_and_rate(results: wb.Results) -> wb.document.Figure:
    """Noise against the slowest mode."""
    ((slowest, noise),) = results.work("trade_off")
    line = wb.document.Series("double poles", slowest, noise, "reference")
    marks = [
        wb.document.Series(name, np.array([one.slowest]), np.array([one.noise]), STYLES[name], look="marks")
        for name, one in candidates(results).items()
    ]
    caption = (
        "Noise in the velocity estimate, as an H2 norm, against the slowest frozen mode seen in the region. The grey "
        "curve: double poles at -22 to -60 1/s. The vertical lines: 0, left of which a mode grows, and "
        f"{SURFACE:g} 1/s, the rate of the surface."
    )
    panel = wb.document.Panel(
        "noise gain [s^(-3/2)]", (*marks, line), xlabel="slowest frozen mode [1/s]", yscale="log", vlines=(0.0, SURFACE)
    )
    return wb.document.Figure("noise_and_rate", caption, (panel,))


def errors(results: wb.Results) -> wb.document.Figure:
    """The estimation errors of joint 2 over time, position and velocity, early and late."""
    outcomes = results.scenario(SCENARIOS[0])
    signals = (("q_error", "q_2", " [rad]"), ("qd_error", "qd_2", " [rad/s]"))
    panels = tuple(
        wb.document.Panel(
            ("error of ", wb.notation.symbol(letter), unit),
            tuple(wb.pictures.curve(one, signal, 1, window, one.case.law, one.case.style) for one in outcomes),
            xlim=(window.start, window.end),
        )
        for signal, letter, unit in signals
        for window in (wb.pictures.Window(0.0, 1.0), wb.pictures.Window(5.0, 10.0))
    )
    caption = f"Estimation errors of joint 2, {SCENARIOS[0]}: in the first second, and from 5 s on."
    return wb.document.Figure("estimation_errors", caption, panels, columns=2)


def promise_section() -> wb.Section:
    """The inequality that is proved, and the road to its proof."""
    text = (
        "With the error x~ = (q - q_hat, qd - qd_hat), (12) and (16) are linear in it: by the mean value theorem the "
        "mismatch (14) is a mean of Jacobians of the acceleration between estimate and state, times the error. If "
        "one P satisfies P A + A' P + 2 alpha P < 0 for the error's matrix A at every state and torque of a region, "
        "V = x~' P x~ falls at least as exp(-2 alpha t) as long as arm and estimate stay in it. Errors within an "
        f"ellipsoid of V that keeps the estimate there are admitted. The region here: {BOX}, for arm and estimate; the "
        f"arm itself keeps {100 * INNER:g} % of these speeds, and the rest is room for the error. A solver only "
        "proposes P. Its definiteness is decided by leading minors in rational arithmetic, the inequality by "
        "intervals: the Jacobian is a polynomial in speeds and torques, which lies in the hull of its coefficients in "
        f"Bernstein's basis, and positions are halved until each box holds ({wb.proofs.guarantee()})."
    )
    return wb.Section("What a promise is, and how it is proved", (wb.Paragraph(text),))


def gains_section(results: wb.Results) -> wb.Section:
    """The gains, and all that is seen and proved of each."""
    text = (
        "The admitted errors are small in all cases: high gains peak, and a peak takes the estimate out of the region. "
        "The bound is sufficient, not sharp. For gains of 1, 10 and 100 times those of the paper, a2 proves that each "
        "has a false rest point: more gain alone does not make the promise global. The LMI minimises the bound of "
        "noise that its one P gives, not the noise itself."
    )
    table = wb.document.Table(
        "gains",
        "The paper's gains and four others.",
        (
            wb.document.Column("gains"),
            wb.document.Column("how"),
            wb.document.Column(wb.notation.symbol("L1"), "1/s"),
            wb.document.Column(wb.notation.symbol("L2"), "1/s^2"),
        ),
        tuple(
            (name, HOW[name], wb.provenance.written(one.L1), wb.provenance.written(one.L2))
            for name, one in candidates(results).items()
        ),
    )
    return wb.Section(
        "What the gains promise, and what they cost",
        (table, audits_table(results), definitions_table(), wb.Paragraph(text)),
    )


def audits_table(results: wb.Results) -> wb.document.Table:
    """The frozen modes, the proof and the price of each."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for name, one in candidates(results).items():
        seen = 100 * one.growing, one.slowest, one.path
        proved = (100 * one.share, 1e3 * one.admitted) if one.share and one.admitted else (None, None)
        rows.append((name, *seen, *proved, one.tolerated, one.noise, one.peaking, one.bound))
    columns = (
        wb.document.Column("gains"),
        *(wb.document.Column(head, unit, digits=digits) for head, unit, digits, _ in COLUMNS),
    )
    caption = "Frozen modes, proved decay and price of the paper's gains and four others."
    return wb.document.Table("audits", caption, columns, tuple(rows))


def definitions_table() -> wb.document.Table:
    """The definition of each column of the audits."""
    rows = tuple((head, wb.document.raised(definition)) for head, *_, definition in COLUMNS)
    return wb.document.Table(
        "definitions",
        "The columns of the table above.",
        (wb.document.Column("column"), wb.document.Column("definition")),
        rows,
    )


def tracking_section(results: wb.Results) -> wb.Section:
    """The repaired law with each observer."""
    text = (
        "The repaired law of a1 runs for 10 s with each observer in the loop. The estimate starts at zero, as in "
        "section 5, or at the measured positions, q_hat(0) = y(0). All these loops leave the region at first, and in "
        "the second scenario after each jump: the proof holds for the rest. The law has D_hat, filtered from the true "
        "disturbance as in (24). The reference of the second scenario jumps by 0.8 and 0.4 rad every 2 s, which no law "
        f"follows at once. So the late error leaves out the first {CLEAR:g} s after each jump; '{WITH_JUMPS}' has them."
    )
    tables = []
    for place, scenario in enumerate(SCENARIOS, 1):
        for joint in (0, 1):
            name, caption = f"tracking_{place}_q{joint + 1}", f"Joint {joint + 1} with each observer, {scenario}."
            shown = SHOWN if scenario != SCENARIOS[-1] else (*SHOWN, WITH_JUMPS)
            tables.append(wb.side_by_side(name, caption, results.scenario(scenario), shown, joint))
    return wb.Section("The tracking that they give", (wb.Paragraph(text), errors(results), *tables))

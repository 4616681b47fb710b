"""What a4 says, section by section."""

import numpy as np

from studies.a4_observer_gains.candidates import (
    DOUBLE,
    HOW,
    INNER,
    LMI,
    REGION,
    audits,
    constants,
    followed,
    gains,
)
from studies.a4_observer_gains.figures import along_the_path, errors, noise_and_rate, poles
from studies.a4_observer_gains.findings import BOX, SCENARIOS
from workbench.notation.formula import Formula, Number, Product, Relation, Sum, Symbol, symbol
from workbench.proofs.interval import guarantee
from workbench.study.document.document import (
    Cell,
    Column,
    Diverged,
    Equation,
    Measured,
    Paragraph,
    Reference,
    Section,
    Table,
)
from workbench.study.study import Outcome, Results
from workbench.validation.refusals import Array

SHOWN = ("late error", "RMS qd_error", "peak torque")


def promise_section() -> Section:
    """What is asked, as equations."""
    P, A, rate = Symbol("P"), Symbol("A"), Symbol("alpha")
    error, V = Symbol("x", accent="tilde"), Symbol("V")
    two = Number(2)
    lyapunov: tuple[Formula, ...] = (
        Relation(V, "=", Product((Symbol("x", accent="tilde", mark="T"), P, error))),
        Relation(Sum((Product((P, A)), Product((Symbol("A", mark="T"), P)), Product((two, rate, P)))), "<", Number(0)),
    )
    return Section(
        "What a promise is, and how it is proved",
        (
            Paragraph(
                (
                    "With ",
                    symbol("x_tilde"),
                    " = (q - q_hat, qd - qd_hat), (12) and (16) are linear in the error: by the mean value theorem the "
                    "mismatch (14) is a mean of Jacobians of the acceleration between estimate and state, times the "
                    "error. If one P satisfies the inequality below for the error's matrix A at every state and torque "
                    "of a region, it does so for these means, and V falls at least as exp(-2 alpha t) as long as arm "
                    "and estimate stay in the region. Errors within an ellipsoid of V that keeps the estimate there "
                    "are admitted.",
                )
            ),
            Equation(lyapunov, name="promise", note="for A at all states of the region"),
            Paragraph(
                "A solver only proposes P. Its definiteness is decided by leading minors in rational arithmetic. The "
                "inequality is proved by intervals: the Jacobian is a polynomial in speeds and torques, which lies in "
                "the hull of its coefficients in Bernstein's basis, and positions are halved until each box holds "
                f"({guarantee()}). What fails is refused. The region here: {BOX}, for arm and estimate; the arm itself "
                f"keeps {100 * INNER:g} % of these speeds, and the rest is room for the error."
            ),
        ),
    )


def gains_section() -> Section:
    """Where the gains come from."""
    rows = tuple((name, HOW[name], _entries(g.L1), _entries(g.L2)) for name, g in gains().items())
    columns = (Column("gains"), Column("how"), Column(symbol("L1"), "1/s"), Column(symbol("L2"), "1/s^2"))
    note = "One number stands for so many times I; else rows are set apart by semicolons."
    return Section("The gains", (Table("gains", "The paper's gains and four others.", columns, rows, (note,)),))


def _entries(L: Array) -> str:
    if np.array_equal(L, L[0, 0] * np.eye(len(L))):
        return f"{L[0, 0]:.4g}"
    return "; ".join(", ".join(f"{value:.1f}" for value in row) for row in L)


def stability_section() -> Section:
    """Frozen poles, constants, certificates."""
    rows = tuple(_promise(name) for name in HOW)
    columns = (
        Column("gains"),
        Column("frozen, growing", "%", digits=3),
        Column("slowest, seen", "1/s", digits=3),
        Column("along the path", "1/s", digits=3),
        Column("proved rate", "1/s"),
        Column("in a share", "%", digits=2),
        Column("admitted |q~(0)|", "mrad", digits=2),
        Column("boxes"),
    )
    notes = (
        "frozen, slowest: at 20,000 states spread over the region, seen and not proved, negative where a mode grows. "
        "share: of the region's speeds and torques. admitted: with qd~(0) = 0, for an arm within "
        f"{100 * INNER:g} % of the speeds of that share. boxes: of positions, in the proof.",
    )
    table = Table("certificates", "What is seen and what is proved of each.", columns, rows, notes)
    text = (
        "The admitted errors are small in all cases: high gains peak, and a peak takes the estimate out of the region. "
        "The bound is sufficient, not sharp. Of gains of 1, 10 and 100 times the paper's, a2 proves that each has a "
        "false rest point: more gain alone does not make the promise global."
    )
    return Section("What the gains promise", (table, Paragraph(text), poles(), along_the_path(), _constants()))


def _promise(name: str) -> tuple[Cell, ...]:
    found, seen = audits()[name], audits()[name].frozen
    row: tuple[Cell, ...] = (name, 100 * seen.unstable, seen.slowest, followed()[name].slowest)
    if found.certificate is None or found.share is None or found.reach is None:
        return (*row, None, None, None, None)
    return (*row, found.certificate.rate, 100 * found.share, 1e3 * found.reach.position, found.certificate.boxes)


def _constants() -> Table:
    rows = tuple(
        (
            100 * share,
            REGION.speed[0] * share,
            REGION.torque[0] * share,
            rho.position.seen,
            rho.position.proved,
            rho.velocity.seen,
            rho.velocity.proved,
        )
        for share, rho in constants().items()
    )
    columns = (
        Column("share", "%"),
        Column("speed", "rad/s"),
        Column("torque", "N m"),
        Column("|df/dq| reaches", "1/s^2", digits=4),
        Column("proved at most", "1/s^2", digits=4),
        Column("|df/dqd| reaches", "1/s", digits=4),
        Column("proved at most", "1/s", digits=4),
    )
    caption = "Lipschitz constants of the mismatch (14) over shares of the region, for (15)."
    return Table("mismatch", caption, columns, rows)


def price_section() -> Section:
    """Noise, peaking, tolerated mismatch."""
    found = audits()
    rows = tuple(
        (name, a.tolerated, a.noise.position, a.noise.velocity, a.peaking, a.reach.peaking if a.reach else None)
        for name, a in found.items()
    )
    columns = (
        Column("gains"),
        Column("mismatch borne", digits=3),
        Column("noise to q_hat", "s^(-1/2)", digits=3),
        Column("noise to qd_hat", "s^(-3/2)", digits=3),
        Column("peak of |qd~|", "1/s", digits=3),
        Column("proved at most", "1/s", digits=3),
    )
    notes = (
        "mismatch borne: the largest rho such that one quadratic form proves a decay for all |Delta| ≤ rho |x~|, in "
        "rad and rad/s. noise: H2 norms where the model adds nothing; white noise of density S gives sqrt(S) times "
        "these. peak: of |qd~| a rad of first error, where the model adds nothing; proved: in the region of the "
        "certificate.",
    )
    table = Table("price", "What the gains cost.", columns, rows, notes)
    text = (
        "A faster estimate is a noisier one, with the power 3/2 of the rate in the velocity: ",
        Reference("noise_and_rate"),
        f" shows the exchange. The LMI minimises the bound of noise that its one P gives, not the noise itself: its "
        f"gains have {found[LMI].noise.velocity:.0f} in the velocity, the double pole with the same proved rate "
        f"{found[DOUBLE].noise.velocity:.0f}.",
    )
    return Section("What they cost", (table, Paragraph(text), noise_and_rate()))


def tracking_section(results: Results) -> Section:
    """The repaired law with each observer."""
    text = (
        "The repaired law of a1 with each observer in the loop, 10 s: as in section 5, with q_hat(0) = 0, and from the "
        "measured positions, q_hat(0) = y(0). All these loops leave the region at first, and in the second scenario "
        "after each jump: the proof is of the rest. There the late error is that after the jumps of the reference."
    )
    tables = (_tracked(results, i) for i in range(len(SCENARIOS)))
    return Section("The tracking that they give", (Paragraph(text), *tables, errors(results, SCENARIOS[0])))


def _tracked(results: Results, place: int) -> Table:
    outcomes = results.scenario(SCENARIOS[place])
    units = {name: score.metric.unit for name, score in outcomes[0].measurement.scores.items()}
    columns = (
        Column("gains"),
        *(Column(f"{metric}, q{j}", units[metric], "right") for metric in SHOWN for j in (1, 2)),
    )
    notes = (
        "late error: the largest |q - q_d| from 5 s on. RMS qd_error: of qd - qd_hat. The law is given D_hat, filtered "
        "from the true disturbance as in (24); observer (10) leaves it out.",
    )
    caption = f"The repaired law with each observer, {SCENARIOS[place]}."
    return Table(f"tracking_{place + 1}", caption, columns, tuple(map(_row, outcomes)), () if place else notes)


def _row(outcome: Outcome) -> tuple[Cell, ...]:
    if outcome.diverged_at is not None:
        return (outcome.case.law, *(Diverged(outcome.diverged_at),) * (2 * len(SHOWN)))
    scores = (outcome.score(metric, j) for metric in SHOWN for j in (0, 1))
    return (outcome.case.law, *(Measured(value, error) for value, error in scores))

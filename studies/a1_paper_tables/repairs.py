"""The proposed law as printed in each reading, and repaired: one slip put back at a time, or two repaired alone."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from studies.paper.card import CARD
from studies.paper.comparison import GAINS, SCENARIOS
from studies.paper.laws import ARM, PRINTED_ARM, paper_observer, proposed_as_printed
from workbench.controllers.aosmc_rgs import SHAPES
from workbench.loop import ClosedLoop
from workbench.notation.formula import symbol
from workbench.study.document.document import (
    Cell,
    Column,
    Diverged,
    Figure,
    Itemize,
    Measured,
    Paragraph,
    Section,
    Table,
)
from workbench.study.pictures.traces import Window, components
from workbench.study.study import Outcome, Results

CHANGES = {
    "none": "none: all four slips repaired",
    "(3)": "slip (3): C[1,2] without velocity, in model and observer",
    "(24)": "slip (24): D_hat is the integral of eta",
    "(28)": "slip (28): qd_d and qdd_d in place of the reference velocity",
    "(33)": "slip (33): the minus sign",
    "D_hat in (10)": "one repair more: the observer (10) is given D_hat, an oracle",
}
REPAIRS = (
    "(3): C[1,2] as derived (a0), for which M' - 2C is skew-symmetric.",
    "(24): D_hat = eta, which follows D. It must know D, so it is an oracle, and marked as one.",
    "(28): the reference velocity qd_r = qd_d - Lambda e in place of qd_d, without which the term Lambda e_2 of (30) "
    "stays uncancelled.",
    "(33): a plus, so that the gain grows with the error, in the reading outer. The fitted Q and R need it; with a "
    "smaller Q the law can track without it.",
    "Not repaired: observer (10) without D and its convergence (Theorem 1); (34) run forward, which does not minimise "
    "(32); the lost 1/phi in A of (31), for which (34) has no consistent unit; the finite time of (42).",
)
LATE = 5.0  # s, from when on an error counts as late
SHORT = 10.0  # s, the horizon at which changes and readings are compared with one another
FAR = 10.0  # rad, beyond which a path is lost
LONG = CARD["FS: horizon"]
PLANTS = {"derived arm": ARM, "printed arm": PRINTED_ARM}
SMALL = 0.01  # the lower end of the card's range of Q, in N m/(rad s); R = I as before
SMALL_Q = "FS as printed, small Q"
PAIRS = {f"FS, (3) and (28) repaired, Q = {Q:g} I": Q for Q in (SMALL, 1.0)}  # Q in N m/(rad s); R = I


def with_small_q(shape: str) -> ClosedLoop:
    """The law as printed in the first scenario on the derived arm, with so small a Q that its gain falls slowly."""
    loop = proposed_as_printed("FS", shape)
    return replace(loop, controller=replace(loop.controller, Q=SMALL * np.eye(2)))


def with_two_repairs(shape: str, Q: float) -> ClosedLoop:
    """The printed law in the first scenario with C right in model and observer, and qd_r in (28)."""
    loop = proposed_as_printed("FS", shape)
    law = replace(loop.controller, model=ARM, velocity="reference", Q=Q * np.eye(2))
    return replace(loop, controller=law, observer=replace(loop.observer, state=paper_observer()))


def gain_floor(outcome: Outcome) -> np.ndarray:
    """The smallest eigenvalue of the symmetric part of K over time, (N,), in N m; NaN where the run is gone."""
    K = outcome.measurement.trajectories["controller.K"][0]
    finite = np.isfinite(K).all(axis=(1, 2))
    floor = np.full(len(K), np.nan)
    floor[finite] = np.linalg.eigvalsh((K + K.transpose(0, 2, 1))[finite] / 2)[:, 0]
    return floor


def loses_positivity(outcome: Outcome) -> float | None:
    """The first kept time at which K is no longer positive definite, in s."""
    below = np.flatnonzero(gain_floor(outcome) <= 0)
    return float(outcome.t[below[0]]) if below.size else None


def leaves(outcome: Outcome) -> float | None:
    """The first kept time at which an error is beyond `FAR`, or no number any more, in s."""
    e = outcome.measurement.trajectories["e"][0]
    beyond = np.flatnonzero(~(np.abs(e) <= FAR).all(axis=1))
    return float(outcome.t[beyond[0]]) if beyond.size else None


def when(time: float | None) -> str:
    """A time in s, or never."""
    return "never" if time is None else f"{time:.2f}"


def gain_figure(results: Results) -> Figure:
    """The gain of the law as printed until its run ends."""
    outcome = results["FS as printed, derived arm", "outer"]
    window = Window(0.0, max(0.5, outcome.diverged_at or SHORT), (-40.0, 20.0))
    caption = "The gain of the law as printed (first scenario, reading 'outer', derived arm) until the run ends."
    return components("printed_gain", caption, outcome, GAINS, (symbol("K"), " [N m]"), (window,))


def gain_table(
    name: str, caption: str, heads: tuple[str, ...], runs: Iterable[tuple[tuple[str, ...], Outcome]]
) -> Table:
    """A row a run: the gain's loss and floor, and the errors of either joint."""
    rows: list[tuple[Cell, ...]] = []
    for labels, run in runs:
        gone = run.diverged_at
        floor = float(np.nanmin(gain_floor(run))) if gone is None else None
        scores = (
            Measured(*run.score(metric, j)) if gone is None else Diverged(gone)
            for metric in ("RMSE (43)", "late error")
            for j in (0, 1)
        )
        rows.append((*labels, when(loses_positivity(run)), floor, *scores))
    columns = (
        *map(Column, heads),
        Column("K not positive", "s", "right"),
        Column("least eigenvalue of K", "N m", digits=3),
        *(Column(f"{metric} of q{j}", "rad", "right") for metric in ("RMSE (43)", "late error") for j in (1, 2)),
    )
    return Table(name, caption, columns, tuple(rows))


def printed_section(results: Results) -> Section:
    """As printed, in each reading of (33), on both arms; then with a small Q."""
    rows: list[tuple[Cell, ...]] = []
    for scenario, title in SCENARIOS.items():
        for shape in SHAPES:
            runs = [results[f"{scenario} as printed, {plant}", shape] for plant in PLANTS]
            rows.append((title, shape, *(when(time(run)) for run in runs for time in (loses_positivity, leaves))))
    times = (f"{plant}: {words}" for plant in PLANTS for words in ("K not positive", f"|e| > {FAR:g} rad"))
    about = (
        "Equation (33) multiplies a matrix, a vector and a vector of signs, which has no consistent shape: each "
        "reading gives it one. With its minus sign the gain falls, while (29) asks it to stay positive definite. The "
        "law and its observer believe in (3) as printed; what moves is the derived arm, or an arm that obeys (3) as "
        "printed. K is not positive where its symmetric part has an eigenvalue of zero or below. Q and R are not "
        "stated: Q = R = I is assumed, then a smaller Q."
    )
    table = Table(
        "as_printed",
        "AOSMC-RGS as printed, with (3), (24), (28) and the minus of (33), in each reading of (33), over 10 s: when "
        "the gain is lost, and when the path is.",
        (Column("scenario"), Column("reading of (33)"), *(Column(time, "s", "right") for time in times)),
        tuple(rows),
        tuple(f"{name}: {meaning}." for name, meaning in SHAPES.items()),
    )
    small = gain_table(
        "as_printed_small_q",
        f"The same on the derived arm in the first scenario over {LONG:g} s, with Q = {SMALL:g} I.",
        ("reading of (33)",),
        (((shape,), results[SMALL_Q, shape]) for shape in SHAPES),
    )
    return Section("As printed", (Paragraph(about), table, small))


def repair_section(results: Results) -> Section:
    """One slip put back at a time, then two slips repaired alone."""
    slips = gain_table(
        "slips",
        f"The repaired law with one slip of the print put back, or one repair more: first scenario, over {SHORT:g} s, "
        f"with Q = {CARD['Q'][0, 0]:g} I, R = {CARD['R'][0, 0]:g} I; late is from {LATE:g} s on.",
        ("change",),
        (((words,), results["one change", change]) for change, words in CHANGES.items()),
    )
    pairs = gain_table(
        "two_repairs",
        f"The law with (3) and (28) repaired alone: first scenario, derived arm, over {LONG:g} s, R = I.",
        ("Q", "reading of (33)"),
        (((f"{Q:g} I", shape), results[pair, shape]) for pair, Q in PAIRS.items() for shape in SHAPES),
    )
    return Section("A repair of four slips, and a smaller one that tracks", (Itemize(REPAIRS), slips, pairs))

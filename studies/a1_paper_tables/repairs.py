"""The proposed law as printed in each reading, and repaired: one slip put back at a time, or two repaired alone."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from studies.paper.card import CARD, SCENARIOS
from studies.paper.laws import ARM, PRINTED_ARM, paper_observer, proposed_as_printed, proposed_repaired
from workbench.controllers.aosmc_rgs import SHAPES
from workbench.loop import ClosedLoop
from workbench.notation.formula import symbol
from workbench.observers import PrintedFilter
from workbench.study.document.document import Figure, Itemize, Paragraph, Section
from workbench.study.document.phrases import Cell, Column, Table
from workbench.study.marks import cell
from workbench.study.pictures.traces import Window, components
from workbench.study.study import Outcome, Results

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
SMALL = 0.01  # the lower end of the card's range of Q, in N m/(rad s); R = I as before
AS_PRINTED = {scenario: f"{words} as printed, Q = R = I" for scenario, words in SCENARIOS.items()}
SMALL_Q = f"first scenario as printed, Q = {SMALL:g} I"
ONE_CHANGE = "first scenario, one change"
PAIRS = {f"(3) and (28) repaired, Q = {Q:g} I": Q for Q in (SMALL, 1.0)}  # Q in N m/(rad s); R = I
MENDED = "one repair more: the observer (10) is given D_hat, an oracle"
GAINS = tuple((symbol(f"K_{i}{j}"), "controller.K", 2 * (i - 1) + j - 1) for i in (1, 2) for j in (1, 2))


def changes() -> dict[str, ClosedLoop]:
    """The repaired law in the first scenario with one slip of the print put back, or with one repair more."""
    loop = proposed_repaired("FS")
    state = loop.observer.state

    def law(**fields: Any) -> ClosedLoop:
        return replace(loop, controller=replace(loop.controller, **fields))

    def observer(**parts: Any) -> ClosedLoop:
        return replace(loop, observer=replace(loop.observer, **parts))

    return {
        "none: all four slips repaired": loop,
        "slip (3): C[1,2] without velocity, in model and observer": replace(
            law(model=PRINTED_ARM), observer=replace(loop.observer, state=paper_observer(PRINTED_ARM))
        ),
        "slip (24): D_hat is the integral of eta": observer(disturbance=PrintedFilter(2, CARD["l"])),
        "slip (28): qd_d and qdd_d in place of the reference velocity": law(velocity="printed"),
        "slip (33): the minus sign": law(gain_sign="printed"),
        MENDED: observer(state=replace(state, disturbance="compensated")),
    }


def with_small_q(shape: str) -> ClosedLoop:
    """The law as printed in the first scenario, with so small a Q that its gain falls slowly."""
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


def keeps_gain(outcome: Outcome) -> bool:
    """True if the run ends with K positive definite all along."""
    return outcome.diverged_at is None and bool((gain_floor(outcome) > 0).all())


def times_lost(outcome: Outcome) -> tuple[str, str]:
    """The first kept times in s at which K is not positive definite, and at which an error is beyond `FAR` or gone."""
    e = outcome.measurement.trajectories["e"][0]
    signs = gain_floor(outcome) <= 0, ~(np.abs(e) <= FAR).all(axis=1)
    gain, path = (f"{outcome.t[np.argmax(sign)]:.2f}" if sign.any() else "never" for sign in signs)
    return gain, path


def gain_figure(results: Results) -> Figure:
    """The gain of the law as printed until its run ends."""
    outcome = results[AS_PRINTED["FS"], "outer"]
    window = Window(0.0, max(0.5, outcome.diverged_at or SHORT), (-40.0, 20.0))
    caption = "The gain of the law as printed (first scenario, reading 'outer') until the run ends."
    return components("printed_gain", caption, outcome, GAINS, (symbol("K"), " [N m]"), (window,))


def gain_table(name: str, caption: str, head: str, runs: Sequence[Outcome], notes: Sequence[str] = ()) -> Table:
    """A row a run: the time at which the gain is lost, and the path, and the errors of either joint."""
    rows: list[tuple[Cell, ...]] = []
    several = len({run.case.scenario for run in runs}) > 1
    for run in runs:
        named = f"{run.label}: {run.case.scenario}" if several else run.label  # a table in parts repeats it
        gone, places = run.diverged_at, [(metric, j) for metric in ("RMSE (43)", "late error") for j in (0, 1)]
        floor = float(np.nanmin(gain_floor(run))) if gone is None else None
        scores = (cell(run, *place) for place in places)
        rows.append((named, *times_lost(run), floor, *scores))
    columns = (
        Column(head),
        Column("K not positive", "s", "right"),
        Column(f"|e| > {FAR:g} rad", "s", "right"),
        Column("least eigenvalue of K", "N m", digits=3),
        *(Column(f"{metric} of q{j}", "rad", "right") for metric in ("RMSE (43)", "late error") for j in (1, 2)),
    )
    return Table(name, caption, columns, tuple(rows), tuple(notes))


def printed_section(results: Results) -> Section:
    """The law as printed, in each reading of (33), with two choices of Q."""
    about = (
        "Equation (33) multiplies a matrix, a vector and a vector of signs, which has no consistent shape: each "
        "reading gives it one. With its minus sign the gain falls, while (29) asks it to stay positive definite. The "
        "law and its observer believe in (3) as printed; what moves is the derived arm. K is not positive where its "
        "symmetric part has an eigenvalue of zero or below. Q and R are not stated: Q = R = I is assumed, then a "
        "smaller Q."
    )
    runs = [run for scenario in (*AS_PRINTED.values(), SMALL_Q) for run in results.scenario(scenario)]
    caption = (
        "AOSMC-RGS as printed, with (3), (24), (28) and the minus of (33), in each reading of (33): when the gain is "
        f"lost, and when the path is. Over {SHORT:g} s, with the small Q over {LONG:g} s."
    )
    notes = [f"{name}: {meaning}." for name, meaning in SHAPES.items()]
    return Section("As printed", (Paragraph(about), gain_table("as_printed", caption, "reading of (33)", runs, notes)))


def repair_section(results: Results) -> Section:
    """One slip put back at a time, then two slips repaired alone."""
    slips = (
        f"The repaired law with one slip of the print put back, or one repair more: first scenario, over {SHORT:g} s, "
        f"with Q = {CARD['Q'][0, 0]:g} I, R = {CARD['R'][0, 0]:g} I; late is from {LATE:g} s on."
    )
    pairs = f"The law with (3) and (28) repaired alone: first scenario, over {LONG:g} s, R = I."
    tables = (
        gain_table("slips", slips, "change", results.scenario(ONE_CHANGE)),
        gain_table("two_repairs", pairs, "reading of (33)", [run for pair in PAIRS for run in results.scenario(pair)]),
    )
    return Section("A repair of four slips, and a smaller one that tracks", (Itemize(REPAIRS), *tables))

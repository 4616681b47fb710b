"""The proposed law as printed in each shape of (33), with four repairs, with three, and with two."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

import workbench as wb
from studies.a1_paper_tables.row import OTHER_Q, OTHER_R, multiple, nearest
from studies.paper.card import CARD, PROPOSED_LAW, SCENARIOS
from studies.paper.comparison import LATE
from studies.paper.laws import ARM, PRINTED_ARM, paper_observer, proposed_as_printed, proposed_repaired, state_observer

REPAIRS = (
    "(3): the entry C[1,2] is derived in report a0. With it M' - 2C is skew-symmetric.",
    "(24): D_hat = eta, which follows D. The observer must know D, so it is an oracle, and is marked as one.",
    "(28): the reference velocity, which is the desired velocity minus Lambda e, in place of the desired velocity. "
    "Without it the term Lambda e_2 of (30) remains.",
    "(33): a plus, so that the gain grows with the error. The Q and R that were fitted with four repairs need the "
    "plus; a smaller Q does not.",
    "Four further slips are left as printed. Observer (10) leaves out D. (34) runs forward in time and does not "
    "minimise (32). A of (31) lacks the factor 1/phi. The finite time (42) does not follow (report a2).",
)
SHORT = 10.0  # s, the horizon of runs that are lost before it
LONG = 25.0  # s, the horizon of the law as printed with a small Q
FREE = 45.0  # s, by which each law that tracks has passed the printed row
FAR = 10.0  # rad, beyond which a path is lost
NEAR = np.pi / 10  # rad, a tenth of the error at the start: a late error within it is called tracking
TRACKING = (
    f"The late error is the largest |e_i| from {LATE:g} s on. A law tracks if K stays positive definite and the late "
    f"error of both joints is at most {NEAR:.2f} rad, a tenth of the error at the start."
)
SMALL = 0.01  # the lower end of the card's range of Q, in N m/(rad s); R = I as before
AS_PRINTED = {scenario: f"{words} as printed, Q = I" for scenario, words in SCENARIOS.items()}
SMALL_Q = f"first scenario as printed, Q = {SMALL:g} I"
ONE_CHANGE = "first scenario, one change"
PAIRS = {f"(3) and (28) repaired, Q = {multiple(Q)}": Q for Q in (SMALL, 1.0)}  # Q in N m/(rad s); R = I
WITH_ORACLE = "one more repair: observer (10) is given D_hat, an oracle"
ALL_FOUR = "none: all four slips repaired"
SLIPS = {
    "(3)": "slip (3): C[1,2] without velocity, in model and observer",
    "(24)": "slip (24): D_hat is the integral of eta",
    "(28)": "slip (28): qd_d and qdd_d in place of the reference velocity",
    "(33)": "slip (33): the minus sign",
}
SHOWN = {"qd_d and qdd_d": "the desired velocity and acceleration"}  # of the names of runs, in words
ONE_REPAIR = f"one repair alone, Q = {SMALL:g} I"
WITHOUT_OBSERVER = "first scenario as printed, observer (10) out of the loop"
SMALL_R = 0.1  # N m/(rad s), the least R of the grid
GAINS = tuple((wb.notation.symbol(f"K_{i}{j}"), "controller.K", 2 * (i - 1) + j - 1) for i in (1, 2) for j in (1, 2))


def display_name(name: str) -> str:
    """The name of a run with words in place of its symbols."""
    for symbols, words in SHOWN.items():
        name = name.replace(symbols, words)
    return name


def changes() -> dict[str, wb.ClosedLoop]:
    """The repaired law in the first scenario with one slip of the print put back, or with one repair more."""
    loop = proposed_repaired("FS")
    state = state_observer(loop)

    def law(**fields: Any) -> wb.ClosedLoop:
        return replace(loop, controller=replace(loop.controller, **fields))

    def observer(**parts: Any) -> wb.ClosedLoop:
        return replace(loop, observer=replace(loop.observer, **parts))

    slips = {
        "(3)": replace(law(model=PRINTED_ARM), observer=replace(loop.observer, state=paper_observer(PRINTED_ARM))),
        "(24)": observer(disturbance=wb.arms.observers.PrintedFilter(2, CARD["l"])),
        "(28)": law(velocity="printed"),
        "(33)": law(gain_sign="printed"),
    }
    more = observer(state=replace(state, disturbance="compensated"))
    return {ALL_FOUR: loop} | {SLIPS[slip]: one for slip, one in slips.items()} | {WITH_ORACLE: more}


def with_small_q(shape: str) -> wb.ClosedLoop:
    """The law as printed in the first scenario, with so small a Q that its gain falls slowly."""
    loop = proposed_as_printed("FS", shape)
    return replace(loop, controller=replace(loop.controller, Q=SMALL * np.eye(2)))


def with_one_repair(slip: str, shape: str) -> wb.ClosedLoop:
    """The law as printed in the first scenario with a small Q and one slip repaired."""
    loop = with_small_q(shape)
    if slip == "(24)":
        return replace(loop, observer=replace(loop.observer, disturbance=wb.arms.observers.OracleFilter(2, CARD["l"])))
    if slip == "(28)":
        return replace(loop, controller=replace(loop.controller, velocity="reference"))
    if slip == "(33)":
        return replace(loop, controller=replace(loop.controller, gain_sign="raised"))
    law = replace(loop.controller, model=ARM)
    return replace(loop, controller=law, observer=replace(loop.observer, state=paper_observer()))


def without_observer(shape: str) -> wb.ClosedLoop:
    """The law as printed in the first scenario on measured positions and velocities, with a small Q and R."""
    loop = with_small_q(shape)
    law = replace(loop.controller, R=SMALL_R * np.eye(2))
    return replace(loop, controller=law, observer=replace(loop.observer, state=wb.ArmFullState(2)))


def with_other_pair() -> wb.ClosedLoop:
    """The law with (3) and (33) repaired, (24) and (28) as printed, and Q and R fitted to the printed row."""
    loop = with_one_repair("(3)", "outer")
    law = replace(loop.controller, gain_sign="raised", Q=OTHER_Q * np.eye(2), R=OTHER_R * np.eye(2))
    return replace(loop, controller=law)


def with_two_repairs(shape: str, Q: float) -> wb.ClosedLoop:
    """The printed law in the first scenario with C right in model and observer, and qd_r in (28)."""
    loop = proposed_as_printed("FS", shape)
    law = replace(loop.controller, model=ARM, velocity="reference", Q=Q * np.eye(2))
    return replace(loop, controller=law, observer=replace(loop.observer, state=paper_observer()))


def gain_floor(outcome: wb.study.Outcome) -> np.ndarray:
    """The smallest eigenvalue of the symmetric part of K over time, (N,), in N m; NaN where the run has diverged."""
    K = outcome.measurement.trajectories["controller.K"][0]
    finite = np.isfinite(K).all(axis=(1, 2))
    floor = np.full(len(K), np.nan)
    floor[finite] = np.linalg.eigvalsh((K + K.transpose(0, 2, 1))[finite] / 2)[:, 0]
    return floor


def late(outcome: wb.study.Outcome) -> list[float]:
    """The late error of either joint, in rad; infinite after a run has diverged."""
    if outcome.diverged_at is not None:
        return [np.inf, np.inf]
    return [outcome.score("late error", joint).pair[0] for joint in (0, 1)]


def tracks(outcome: wb.study.Outcome) -> bool:
    """True if K is positive definite throughout and both late errors are at most `NEAR`."""
    return max(late(outcome)) <= NEAR and bool((gain_floor(outcome) > 0).all())


def times_lost(outcome: wb.study.Outcome) -> tuple[str, str]:
    """The first kept times in s at which K is not positive definite, and at which an error is beyond `FAR`."""
    e = outcome.measurement.trajectories["e"][0]
    signs = gain_floor(outcome) <= 0, ~(np.abs(e) <= FAR).all(axis=1)
    gain, path = (f"{outcome.t[np.argmax(sign)]:.2f}" if sign.any() else "never" for sign in signs)
    return gain, path


def gain_figure(results: wb.Results) -> wb.document.Figure:
    """The gain of the law as printed until its run ends."""
    outcome = results[AS_PRINTED["FS"], "outer"]
    window = wb.pictures.Window(0.0, max(0.5, outcome.diverged_at or SHORT), (-40.0, 20.0))
    caption = "Gain of the law as printed, first scenario, shape 'outer', until the run diverges."
    return wb.pictures.components(
        "printed_gain", caption, outcome, GAINS, (wb.notation.symbol("K"), " [N m]"), (window,)
    )


def gain_table(
    name: str, caption: str, head: str, runs: Sequence[wb.study.Outcome], notes: Sequence[str] = ()
) -> wb.document.ReportTable:
    """One row for each run: when the gain and the path are lost, the late errors, and the miss of the printed row."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    several = len({run.case.scenario for run in runs}) > 1
    for run in runs:
        named = (run.label, run.case.scenario.replace(" as printed", "")) if several else (display_name(run.label),)
        floor = float(np.nanmin(gain_floor(run))) if run.diverged_at is None else None
        one = nearest(run)
        of_row = run.case.scenario != AS_PRINTED["SS"] and np.isfinite(one.miss)
        row = (f"{one.horizon:.2f}", wb.document.percent(one.miss).removesuffix(" %")) if of_row else (None, None)
        rows.append((*named, *times_lost(run), floor, *(wb.study.cell(run, "late error", j) for j in (0, 1)), *row))
    columns = (
        wb.document.TableColumn(head),
        *((wb.document.TableColumn("run"),) if several else ()),
        wb.document.TableColumn("K first not positive", "s", "right"),
        wb.document.TableColumn(f"first |e| > {FAR:g} rad", "s", "right"),
        wb.document.TableColumn("least eigenvalue of K", "N m", digits=3),
        *(wb.document.TableColumn(f"late error of q{j}", "rad", "right") for j in (1, 2)),
        wb.document.TableColumn("nearest horizon", "s", "right"),
        wb.document.TableColumn("larger miss", "%", "right"),
    )
    nearest_note = (
        "Nearest horizon: the horizon, from 5 s on, at which the sampled RMSE, (43), of both joints is nearest to "
        f"the printed values of {PROPOSED_LAW}. The last column has the larger of the two relative differences."
    )
    return wb.document.ReportTable(name, caption, columns, tuple(rows), (nearest_note, *notes))


def printed_section(results: wb.Results) -> wb.Section:
    """The law as printed, in each shape of (33), with two choices of Q."""
    about = (
        "Equation (33) multiplies a matrix, a vector and a vector of signs. Their product has no consistent shape, so "
        "each reading gives it one. With the minus of (33) the gain can fall, but (29) needs a positive definite K. "
        "The law and its observer use (3) as printed; the simulated arm is the derived one. K is not positive if its "
        "symmetric part has an eigenvalue of zero or below. The paper states neither Q nor R. First Q = R = I is "
        "assumed, then a smaller Q."
    )
    runs = [run for scenario in (*AS_PRINTED.values(), SMALL_Q) for run in results.scenario(scenario)]
    caption = (
        "AOSMC-RGS as printed, in each shape of (33): (3), (24), (28) and the minus of (33) are as printed. The runs "
        f"take {SHORT:g} s with Q = I and {LONG:g} s with the smaller Q; R = I."
    )
    notes = [f"{name}: {meaning}." for name, meaning in wb.arms.laws.SHAPES.items()]
    table = gain_table("printed_runs", caption, "shape of (33)", runs, notes)
    return wb.Section("The law as printed", (gain_figure(results), wb.Paragraph(about), table))


def repair_section(results: wb.Results) -> wb.Section:
    """One slip put back at a time, then two slips repaired alone."""
    slips = (
        "The law with four repairs, then with one slip of the paper put back or one more repair: first scenario, over "
        f"{FREE:g} s, Q = {CARD['Q'][0, 0]:g} I, R = {CARD['R'][0, 0]:g} I."
    )
    pairs = f"The law with (3) and (28) repaired and nothing else: first scenario, over {FREE:g} s, R = I."
    single = (
        f"The law with one slip repaired, and as printed without observer (10): first scenario, over {LONG:g} s, "
        f"Q = {SMALL:g} I; R = I with a repair and {SMALL_R:g} I without (10)."
    )
    tables = (
        gain_table("one_repair_runs", single, "repaired, shape of (33)", one_change_of_print(results)),
        gain_table("slips", slips, "change", results.scenario(ONE_CHANGE)),
        gain_table(
            "two_repair_runs", pairs, "shape of (33)", [run for pair in PAIRS for run in results.scenario(pair)]
        ),
    )
    return wb.Section("One repair, two and four", (wb.document.Itemize(REPAIRS), *tables))


def one_change_of_print(results: wb.Results) -> list[wb.study.Outcome]:
    """The runs with one slip repaired, then the runs as printed without observer (10)."""
    return [run for name in (ONE_REPAIR, WITHOUT_OBSERVER) for run in results.scenario(name)]

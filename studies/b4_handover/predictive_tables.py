"""The tables of a predictive law on a Cortex-M7, beside TinyMPC on the same states and its published figures."""

from __future__ import annotations

import workbench as wb
from studies.b4_handover.filter_law import filter_table
from studies.b4_handover.predictive_laws import PENALTIES, PERIODS, WORK, PredictiveCount, SolverCount, predictive_keys
from studies.b4_handover.predictive_problems import IDLE, IDLE_SHARE, PUSHED, problems
from studies.b4_handover.thousands import in_thousands

Column = wb.document.TableColumn
PUBLISHED = {  # us an iteration: TinyMPC and OSQP as a safety filter, and TinyMPC as the law of a rocket
    4: (299, 610, 9.9),
    8: (609, 1180, 20.7),
    16: (1363, 2345, 45.0),
    32: (2480, None, 91.3),
    64: (4995, None, 184.3),
}
ROUNDING = 1e-12  # spans
RUNS = "Pushed: a disturbance pushes the inputs to their limits. Idle: no limit acts."
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
SOURCE = "RoboticExplorationLab/mcu-solver-benchmarks, folder Results/TinyMPC CDC benchmarks"


def predictive_section(results: wb.Results) -> wb.Section:
    """Instructions, stack and memory of a predictive law, beside TinyMPC and OSQP."""
    words = (
        "A predictive law with limits on its inputs, in double precision with the sweeps of its design, is replayed "
        f"over {PERIODS} periods on a Cortex-M7 under QEMU (gcc -O2). TinyMPC 0.0.8 and the generated C of OSQP are "
        "compiled by the same compiler with the same options, in double precision too. They solve the same problem "
        "from the same states at their default tolerances of 1e-3, warm started. TinyMPC's report of each solution is "
        f"silenced. Of the penalties {wb.document.join_names([f'{one:g}' for one in PENALTIES])} it gets the one with "
        "which it takes the fewest instructions, whatever its error. Error: the root mean square difference of the "
        "first input from the exact solution, in spans of its limits."
    )
    reasons = dict.fromkeys(reason for one in counts(results).values() for reason in one.reasons)
    absent = (wb.Paragraph(f"Not counted here: {'; '.join(reasons)}."),) if reasons else ()
    solvers = solver_table(results, PUSHED), solver_table(results, IDLE), osqp_table(results), error_table(results)
    tables = (*solvers, memory_table(results), filter_table(results), published_table())
    return wb.Section("A predictive law on a Cortex-M7", (wb.Paragraph(words), *absent, *tables))


def counts(results: wb.Results) -> dict[str, PredictiveCount]:
    """The counts by their keys."""
    return dict(zip(predictive_keys(), results.work(WORK), strict=True))


def solver_table(results: wb.Results, run: str) -> wb.document.ReportTable:
    """The instructions of the law and of TinyMPC in one kind of run, in thousands."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for plant, horizon, one in _rows(results, run):
        ratios: tuple[float | None, float | None] = (None, None)
        if one.law and one.tinympc:
            ratios = one.tinympc.mean / one.law.mean, one.tinympc.most / one.law.most
        rows.append((plant, horizon, *_both(one.law), *_both(one.tinympc), *ratios))
    columns = (
        Column("plant (states, inputs)"),
        Column("stages", align="right"),
        *(
            Column(f"{name} {which}", align="right", digits=3)
            for name in ("law", "TinyMPC", "ratio")
            for which in ("mean", "most")
        ),
    )
    kind = (
        "a disturbance pushes the inputs to their limits"
        if run == PUSHED
        else f"the disturbance is {100 * IDLE_SHARE:g} % of that"
    )
    caption = f"Thousands of instructions of a period on a Cortex-M7, where {kind}."
    notes = ("In the mean of the periods, and at most; to three digits. Ratio: TinyMPC over the law.",)
    return wb.document.ReportTable(f"predictive_{run}", caption, columns, tuple(rows), notes)


def osqp_table(results: wb.Results) -> wb.document.ReportTable:
    """The instructions of OSQP in both kinds of run, in thousands."""
    rows = [
        (plant, horizon, *_both(pushed.osqp), *_both(idle.osqp))
        for (plant, horizon, pushed), (*_, idle) in zip(_rows(results, PUSHED), _rows(results, IDLE), strict=True)
    ]
    columns = (
        Column("plant (states, inputs)"),
        Column("stages", align="right"),
        *(
            Column(f"{run}: {which}", align="right", digits=3)
            for run in ("pushed", "idle")
            for which in ("mean", "most")
        ),
    )
    caption = "Thousands of instructions of a period of OSQP in the same runs."
    return wb.document.ReportTable("predictive_osqp", caption, columns, tuple(rows), (RUNS,))


def _both(count: SolverCount | None) -> tuple[float | int | None, float | int | None]:
    """The mean and the largest count, in thousands."""
    return (in_thousands(count.mean), in_thousands(count.most)) if count else (None, None)


def error_table(results: wb.Results) -> wb.document.ReportTable:
    """The errors of the first moves of the solvers in both kinds of run."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for (plant, horizon, pushed), (*_, idle) in zip(_rows(results, PUSHED), _rows(results, IDLE), strict=True):
        solvers = (count for one in (pushed, idle) for count in (one.law, one.tinympc, one.osqp))
        rows.append((plant, horizon, *(error_in_words(count.error) if count else None for count in solvers)))
    columns = (
        Column("plant (states, inputs)"),
        Column("stages", align="right"),
        *(Column(f"{run}: {name}", align="right") for run in ("pushed", "idle") for name in ("law", "TinyMPC", "OSQP")),
    )
    caption = "Root mean square errors of the first input, in spans of its limits."
    notes = (f"{RUNS} Errors below {ROUNDING:g} are rounding.",)
    return wb.document.ReportTable("predictive_errors", caption, columns, tuple(rows), notes)


def error_in_words(error: float) -> str:
    """An error to one digit with a power of ten, so that all errors of a column are written alike."""
    if error < ROUNDING:
        return "rounding"
    digit, power = f"{error:.0e}".split("e")
    return f"{digit}·10{str(int(power)).translate(RAISED)}"


def memory_table(results: wb.Results) -> wb.document.ReportTable:
    """The share of limits that act, the sweeps and iterations, and the stack and the static memory of the laws."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for plant, horizon, one in _rows(results, PUSHED):
        passes = [count.passes if count else None for count in (one.law, one.tinympc, one.osqp)]
        rows.append((plant, horizon, 100 * one.active, *passes, one.stack, one.room))
    columns = (
        Column("plant (states, inputs)"),
        Column("stages", align="right"),
        Column("inputs at a limit", "%", "right", digits=2),
        Column("sweeps of the law", align="right"),
        Column("iterations of TinyMPC", align="right", digits=3),
        Column("iterations of OSQP", align="right", digits=3),
        Column("stack of the law", "bytes", "right"),
        Column("its state with arrays", "bytes", "right"),
    )
    caption = (
        "Inputs at a limit and passes of a period, in the mean where a disturbance pushes, and the memory of the laws."
    )
    note = "No array of a plan is on the stack."
    return wb.document.ReportTable("predictive_memory", caption, columns, tuple(rows), (note,))


def published_table() -> wb.document.ReportTable:
    """The published times of TinyMPC and OSQP."""
    columns = (
        Column("stages", align="right"),
        Column("safety filter: TinyMPC", "us", "right", digits=4),
        Column("safety filter: OSQP", "us", "right", digits=4),
        Column("rocket: TinyMPC", "us", "right", digits=3),
    )
    notes = (
        f"Times of one iteration, not of a period, in single precision on real boards; {SOURCE}. They are times and "
        "not instructions, and no board is at hand here: the two tables cannot be divided by each other. A dash: out "
        "of memory, or not published.",
        "The rocket with its cone in the tables above has the model, weights, limits and cone of that benchmark, "
        "rocket_landing/gen_rocket.py, but a disturbance in the place of its descent. OSQP poses no cone. The safety "
        "filter of the benchmark follows planned inputs within hard limits on states; the filter above has its model "
        "and limits, but another plan.",
    )
    rows = tuple((stages, *times) for stages, times in PUBLISHED.items())
    return wb.document.ReportTable("predictive_published", "Published times of TinyMPC and OSQP.", columns, rows, notes)


def _rows(results: wb.Results, run: str) -> list[tuple[str, int, PredictiveCount]]:
    """The plants with their sizes, horizons and counts in one kind of run."""
    sizes = {one.name: one.sizes for one in problems()}
    rows = []
    for key, one in counts(results).items():
        name, horizon, own = key.split("|")
        if own == run:
            n, m = sizes[name]
            rows.append((f"{name} ({n}, {m})", int(horizon), one))
    return rows

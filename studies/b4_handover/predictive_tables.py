"""The tables of a predictive law on a Cortex-M7, beside TinyMPC on the same states and its published figures."""

from __future__ import annotations

import workbench as wb
from studies.b4_handover.predictive_laws import PENALTIES, PERIODS, WORK, PredictiveCount, predictive_keys
from studies.b4_handover.predictive_problems import IDLE, IDLE_SHARE, PUSHED, problems

Column = wb.document.TableColumn
PUBLISHED = {  # us an iteration: TinyMPC and OSQP as a safety filter, and TinyMPC as the law of a rocket
    4: (299, 610, 9.9),
    8: (609, 1180, 20.7),
    16: (1363, 2345, 45.0),
    32: (2480, None, 91.3),
    64: (4995, None, 184.3),
}
SOURCE = "RoboticExplorationLab/mcu-solver-benchmarks, folder Results/TinyMPC CDC benchmarks"


def predictive_section(results: wb.Results) -> wb.Section:
    """Instructions, stack and memory of a predictive law, beside TinyMPC."""
    words = (
        "A predictive law with limits on its inputs, in double precision with the sweeps of its design, is replayed "
        f"over {PERIODS} periods on a Cortex-M7 under QEMU (gcc -O2). TinyMPC 0.0.8 is compiled by the same compiler "
        "with the same options, in double precision too. It solves the same problem from the same states, with its "
        "default tolerance of 1e-3 and at most 1000 iterations, warm started, and its report of each solution is "
        f"silenced. Of the penalties {wb.document.join_names([f'{one:g}' for one in PENALTIES])} it gets the one with "
        "which it takes the fewest instructions. Both have the LQR cost behind the last stage, TinyMPC that of the LQR "
        "law with the penalty. Error: the root mean square difference of the first input from the exact solution, in "
        "spans of its limits."
    )
    reasons = dict.fromkeys(one.reason for one in counts(results).values() if one.reason)
    absent = (wb.Paragraph(f"Not counted here: {'; '.join(reasons)}."),) if reasons else ()
    tables = (solver_table(results, PUSHED), solver_table(results, IDLE), memory_table(results), published_table())
    return wb.Section("A predictive law on a Cortex-M7", (wb.Paragraph(words), *absent, *tables))


def counts(results: wb.Results) -> dict[str, PredictiveCount]:
    """The counts by their keys."""
    return dict(zip(predictive_keys(), results.work(WORK), strict=True))


def solver_table(results: wb.Results, run: str) -> wb.document.ReportTable:
    """The instructions of both solvers in one kind of run."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for plant, horizon, one in _rows(results, run):
        law, peer = one.law, one.peer
        own = (law.passes, law.mean, law.most, law.error) if law else (None,) * 4
        other = (peer.passes, peer.mean, peer.most, peer.error) if peer else (None,) * 4
        ratio = peer.mean / law.mean if law and peer else None
        rows.append((plant, horizon, 100 * one.active, *own, *other, ratio))
    columns = (
        Column("plant (states, inputs)"),
        Column("stages", align="right"),
        Column("first inputs at a limit", "%", "right", digits=2),
        *(
            column
            for name, passes in (("law", "sweeps"), ("TinyMPC", "iterations"))
            for column in (
                Column(passes, align="right", digits=3),
                Column(f"{name}: instructions, mean", align="right", digits=4),
                Column("at most", align="right", digits=4),
                Column("error", "spans", "right", digits=2),
            )
        ),
        Column("TinyMPC / law", align="right", digits=3),
    )
    kind = (
        "a disturbance pushes the inputs to their limits"
        if run == PUSHED
        else f"the disturbance is {100 * IDLE_SHARE:g} % of that, and no limit acts"
    )
    caption = f"Instructions of a period on a Cortex-M7, where {kind}."
    return wb.document.ReportTable(f"predictive_{run}", caption, columns, tuple(rows))


def memory_table(results: wb.Results) -> wb.document.ReportTable:
    """The stack and the static memory of the laws."""
    rows = [(plant, horizon, one.stack, one.room) for plant, horizon, one in _rows(results, PUSHED)]
    columns = (
        Column("plant (states, inputs)"),
        Column("stages", align="right"),
        Column("stack of a call", "bytes", "right"),
        Column("state with the arrays of loops", "bytes", "right"),
    )
    caption = "Memory of the laws in double precision: no array of a plan is on the stack."
    return wb.document.ReportTable("predictive_memory", caption, columns, tuple(rows))


def published_table() -> wb.document.ReportTable:
    """The published times of TinyMPC and OSQP."""
    columns = (
        Column("stages", align="right"),
        Column("safety filter: TinyMPC", "us", "right", digits=4),
        Column("safety filter: OSQP", "us", "right", digits=4),
        Column("rocket: TinyMPC", "us", "right", digits=4),
    )
    notes = (
        f"Times of one iteration, not of a period, in single precision on real boards; {SOURCE}. They are times and "
        "not instructions, and no board is at hand here: the two tables cannot be divided by each other. A dash: out "
        "of memory, or not published.",
        "The safety filter follows planned inputs within hard limits on states, and the rocket has a cone of thrust: "
        "this law has neither. The rocket in the tables above has the limits of its inputs alone.",
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

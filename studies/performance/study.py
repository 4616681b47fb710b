"""Speed of the batch engine on this machine, and its error.

Runs in about three minutes on two cores. It measures time: the page is not the same twice.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

from studies.performance.figures import compile_figure, flat_figure, precision_figure, speed_figure
from studies.performance.live_page import live_rows
from studies.performance.measurements import Effort, Row, table_rows
from studies.performance.peers import PEERS
from studies.performance.workload import VARIED, loop
from workbench.study.document.document import Column, Itemize, Paragraph, Section, Strong, Table
from workbench.study.study import Results, Study
from workbench.study.writeup import testbed

EFFORT = Effort()
rows = cache(lambda: (*table_rows(EFFORT), *live_rows(EFFORT)))


def sections(results: Results) -> Sequence[Section]:
    """The pictures, the bars, and the workload."""
    del results
    found, runs = rows(), ", ".join(f"{peer.name} {peer.runs}" for peer in PEERS)
    notes = Itemize(tuple(f"{row.name}: {row.note}." for row in found if row.note))
    speed = (
        "Where a bar of the picture ends at its dash or below, the bar asked for is reached. Every run is a whole one "
        f"of 10 s; so many at least are run by each peer for one rate, beside {EFFORT.runs} of the engine: {runs}. "
        "Each is run as one who knows it would: compiled before, on one thread, the loop inside wherever it can be. "
        "python-control and SciPy call a right-hand side in NumPy's matrices; in scalars it would be some three times "
        "as fast."
    )
    precision = (
        "A solver with a variable step is fast where a coarse answer will do, so it is compared at equal errors only: "
        "each side at the coarsest of its settings, 24 a decade, whose median error is within the one asked for."
    )
    ranges = "; ".join(f"{name} {low:g} to {high:g}" for name, (low, high) in VARIED.items())
    workload = (
        "The loop is that of the AOSMC-RGS paper with its gain law repaired. Ten of its forty parameters differ from "
        f"run to run, each drawn evenly between two multiples of its nominal value: {ranges}."
    )
    return (
        Section("Speed", (speed_figure(found), Paragraph(speed))),
        Section("Speed at equal error", (precision_figure(found, EFFORT), Paragraph(precision))),
        Section("The bars", (bars(found), notes, Paragraph(testbed()))),
        Section("Few runs and many", (flat_figure(EFFORT),)),
        Section("Compile time", (compile_figure(EFFORT),)),
        Section("The workload", (Paragraph(workload),)),
    )


def bars(found: Sequence[Row]) -> Table:
    """Every row with its bar and its verdict."""
    heads = ("runs/s of one core", "measured", "bar", "error of RMSE")
    columns = (Column("against, or what"), *(Column(head, align="right") for head in heads), Column("verdict"))
    verdicts = {True: "reached", False: Strong("MISSED"), None: "not measured"}
    cells = tuple(
        (
            row.name,
            row.runs_per_s and short(row.runs_per_s),
            None if row.value is None else f"{short(row.value)} {row.unit}",
            bar(row),
            row.error and f"{row.error:.1e}",
            verdicts[row.reached],
        )
        for row in found
    )
    caption = "What was asked of the engine, and what was measured; a rate beside a ratio is that of the peer."
    return Table("bars", caption, columns, cells, ("x: how many times as fast the engine is.",))


def bar(row: Row) -> str:
    """The bar with its sign and unit."""
    sign = "\N{LESS-THAN OR EQUAL TO}" if row.at_most else "\N{GREATER-THAN OR EQUAL TO}"
    return f"{sign} {short(row.bar)} {row.unit}"


def short(value: float) -> str:
    """Three digits, or all of a larger whole part."""
    return f"{value:,.0f}" if abs(value) >= 100 else f"{value:.3g}"


def headlines(results: Results) -> Sequence[str]:
    """The range of the ratios, and the bars that were missed."""
    del results
    ratios = [row.value for row in rows() if row.error is not None and row.value is not None]
    missed = [f"{r.name} ({short(r.value)} {r.unit}, bar {bar(r)})" for r in rows() if r.value and r.reached is False]
    return (
        f"The engine is {short(min(ratios))} to {short(max(ratios))} times as fast as its peers.",
        f"MISSED: {'; '.join(missed)}." if missed else "Every bar that was measured is reached.",
    )


study = Study(
    name="p0_performance",
    title="The batch engine: how fast, and at what error",
    question=(
        "How many closed loops a second does the engine run on one core, how much faster is that than what a user "
        "could pick instead, how near is it to the machine's limit, and what is the error of each?"
    ),
    method=(
        "One loop (AOSMC-RGS, 21 states, 40 parameters of which 10 vary, 10 s, RK4 at 1 ms) is run by the engine "
        "and by each peer in turns, in one process. Rates are runs in a second of CPU time of one core, medians; "
        "errors are relative errors of the RMSE against a step of 10 microseconds, medians over runs. The peak is "
        "that of fused multiplications and additions which wait for nothing."
    ),
    sections=sections,
    headlines=headlines,
    fingerprints={"W": loop().fingerprint[:16]},
    measures_time=True,
)

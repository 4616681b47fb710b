"""How fast is the batch engine on this machine, and at what error?

Runs in about three minutes on two cores. It measures time: the page is not the same twice.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np

from studies.performance.effort import Effort
from studies.performance.figures import compile_figure, flat_figure, precision_figure, speed_figure
from studies.performance.peers import PEERS
from studies.performance.row import Row, short
from studies.performance.table import measured
from studies.performance.workload import VARIED, loop
from workbench.study.document.document import Column, Itemize, Paragraph, Section, Strong, Table
from workbench.study.processor import machine
from workbench.study.study import Results, Study

EFFORT = Effort()


@cache
def rows() -> tuple[Row, ...]:
    """The table, measured once."""
    return tuple(measured(EFFORT))


def sections(results: Results) -> Sequence[Section]:
    """What the report says."""
    del results
    return (
        Section("The bars", (Paragraph(where()), bars(rows()), notes(rows()))),
        Section("Speed", (speed_figure(rows()), Paragraph(peers()))),
        Section("Speed at equal error", (precision_figure(rows(), EFFORT), Paragraph(equal_error()))),
        Section("Few runs and many", (flat_figure(EFFORT),)),
        Section("Compile time", (compile_figure(EFFORT),)),
        Section("The workload", (Paragraph(drawn()),)),
    )


def where() -> str:
    """The processor, the versions, and what the page cannot promise."""
    about = dict(machine())
    cpu = about.pop("cpu")
    versions = ", ".join(f"{name} {version}" for name, version in about.items())
    return (
        f"Measured on {cpu} with {versions}. These are times: another run of this study gives other digits, and "
        "another machine other numbers, so this page is not reproduced byte for byte as the other reports are."
    )


def bars(found: Sequence[Row]) -> Table:
    """Every row with its bar and its verdict."""
    columns = (
        Column("against, or what"),
        Column("runs/s of one core", align="right"),
        Column("measured", align="right"),
        Column("bar", align="right"),
        Column("error of RMSE", align="right"),
        Column("verdict"),
    )
    cells = tuple(tuple(cell or None for cell in row.cells()) for row in found)
    marked = tuple((*row[:-1], Strong("MISSED") if row[-1] == "MISSED" else row[-1]) for row in cells)
    caption = "What was asked of the engine, and what was measured; a rate beside a ratio is that of the peer."
    return Table("bars", caption, columns, marked, ("x: how many times as fast the engine is.",))


def notes(found: Sequence[Row]) -> Itemize:
    """How each row was measured, or why it was not."""
    return Itemize(tuple(f"{row.name}: {row.note}." for row in found if row.note))


def peers() -> str:
    """How to read the picture, and how much each peer ran."""
    runs = ", ".join(f"{peer.name} {peer.runs}" for peer in PEERS)
    return (
        "Where a bar of the picture ends at its dash or below, the bar asked for is reached. Every run is a whole one "
        f"of 10 s; so many at least are run by each peer for one rate, beside {EFFORT.runs} of the engine: {runs}. "
        "Each is run as one who knows it would: compiled before, on one thread, the loop inside wherever it can be."
    )


def equal_error() -> str:
    """Why no ratio at unequal errors is claimed against a solver of variable step."""
    return (
        "A solver with a variable step is fast where a coarse answer will do, so it is compared at equal errors only: "
        "each side at the coarsest of its settings, twelve a decade, whose median error is within the one asked for."
    )


def drawn() -> str:
    """The ranges of what varies."""
    ranges = "; ".join(f"{name} {low:g} to {high:g}" for name, (low, high) in VARIED.items())
    return (
        "The loop is that of the AOSMC-RGS paper with its gain law repaired. Ten of its forty parameters differ from "
        f"run to run, each drawn evenly between two multiples of its nominal value: {ranges}."
    )


def headlines(results: Results) -> Sequence[str]:
    """What was missed, and the range of the ratios."""
    del results
    ratios = [row.ratio for row in rows() if row.ratio is not None]
    missed = [f"{row.name} ({row.cells()[2]}, bar {row.cells()[3]})" for row in rows() if row.reached is False]
    return (
        f"The engine is {short(float(np.min(ratios)))} to {short(float(np.max(ratios)))} times as fast as its peers.",
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

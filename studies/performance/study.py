"""Speed of the batch engine on this machine, and its error.

Runs in about five minutes on two cores. It measures time: the page is not the same twice.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import workbench as wb
from studies.paper.workload import SEED, VARIATION_RANGES, loop
from studies.performance.figures import compile_figure, flat_figure, precision_figure, speed_figure
from studies.performance.fit_rate import fit_rows
from studies.performance.frequency_rate import frequency_rows
from studies.performance.live_page import live_rows
from studies.performance.measurements import AT_ERROR, Effort, Row, table_rows
from studies.performance.other_machine import WHERE, count, machines
from studies.performance.peers import IN_MATRICES, PEERS
from studies.performance.pid_rate import pid_rows
from studies.performance.plan_rate import plan_rows
from studies.performance.predictive_rate import predictive_rows
from studies.performance.synthesis_rate import synthesis_rows

EFFORT = Effort()
rows = cache(
    lambda: (
        *table_rows(EFFORT),
        *frequency_rows(EFFORT),
        *pid_rows(EFFORT),
        *synthesis_rows(EFFORT),
        *fit_rows(EFFORT),
        *predictive_rows(EFFORT),
        *plan_rows(EFFORT),
        *live_rows(EFFORT),
    )
)


def sections(results: wb.Results) -> wb.Page:
    """The findings, the pictures, the targets, and the workload."""
    del results
    every = rows()
    return wb.Page(
        answer=answer(every),
        findings=findings(every),
        sections=(
            wb.Section("Speed", (speed_figure(every), wb.Paragraph(speed_words()))),
            wb.Section("Speed at equal error", (precision_figure(every, EFFORT), wb.Paragraph(PRECISION))),
            wb.Section(
                "The targets", (bars(every), notes(every), machines(there(every)), wb.Paragraph(wb.study.testbed()))
            ),
            wb.Section("Few runs and many", (flat_figure(EFFORT),)),
            wb.Section("Compile time", (compile_figure(EFFORT),)),
            wb.Section("The workload", (wb.Paragraph(WORKLOAD), ranges())),
        ),
    )


PRECISION = (
    "A solver with a variable step is fast where a coarse answer is enough. It is therefore compared at equal errors "
    "only. There are 24 settings per decade. Each side runs at the coarsest one whose median error is within the error "
    "asked for."
)
WORKLOAD = (
    "The loop is like AOSMC-RGS of the paper, but it is not the repaired law of a1: its gain is diagonal and leaks, "
    "(28) is as printed in the paper, and the arm has friction. The loop is a load for the engine; its results say "
    "nothing about the law. Ten of the forty parameters differ from run to run. Each is drawn uniformly between two "
    "multiples of its nominal value."
)


def speed_words() -> str:
    """The text below the picture of speeds."""
    runs = "; ".join(f"{peer.name}: {peer.runs}" for peer in PEERS)
    return (
        "Where a bar of the picture ends at its dash or below, the target is reached. Every run lasts 10 s. For one "
        f"rate the engine makes {EFFORT.runs} runs. The least numbers of runs of the peers are: {runs}. Each peer is "
        "compiled before its time is taken, and runs on one thread, with the time loop inside the compiled code where "
        "that is possible. python-control and SciPy are not at their fastest: they call a right-hand side in NumPy's "
        "matrices, as their users write it. A right-hand side in scalars would be about three times as fast."
    )


def ranges() -> wb.document.ReportTable:
    """The parameters that differ from run to run."""
    columns = (
        wb.document.TableColumn("parameter"),
        wb.document.TableColumn("from", align="right"),
        wb.document.TableColumn("to", align="right"),
    )
    rows = tuple((name, low, high) for name, (low, high) in VARIATION_RANGES.items())
    return wb.document.ReportTable(
        "ranges", "The two multiples of the nominal value between which each parameter is drawn.", columns, rows
    )


def notes(every: Sequence[Row]) -> wb.document.ReportTable:
    """The way in which each row was measured, and what else came out of it."""
    rows = tuple((row.name, row.note) for row in every if row.note)
    return wb.document.ReportTable(
        "notes",
        "How each row was measured.",
        (wb.document.TableColumn("against, or what"), wb.document.TableColumn("how")),
        rows,
    )


def there(every: Sequence[Row]) -> list[tuple[Row, str]]:
    """Each row with its figure in words; empty where it was not measured."""
    return [(row, "" if row.value is None else f"{three_digits(row.value)} {row.unit}") for row in every]


def peers_of(every: Sequence[Row]) -> list[Row]:
    """The rows of peers that were measured."""
    return [row for row in every if row.error is not None and row.value is not None]


def answer(every: Sequence[Row]) -> str:
    """The page in one line."""
    ratios = [row.value for row in peers_of(every) if row.value is not None]
    measured = [row for row in every if row.is_reached is not None]
    fast = f"the engine is {span(ratios)} times as fast as its peers" if ratios else ""
    return (
        f"In one run on one machine, {fast or 'no peer was measured'}, and {reached_count(measured)} targets are "
        f"reached. An earlier version reached {count()} on a processor with AVX-512."
    )


def first_of(words: Sequence[str], most: int) -> str:
    """The first few words of a list, and the number of the others."""
    rest = len(words) - most
    return "; ".join([*words[:most], *([f"{rest} more"] if rest > 0 else [])])


def findings(every: Sequence[Row]) -> tuple[wb.Finding, ...]:
    """The speed compared with the peers, and the targets."""
    return (*peer_findings(peers_of(every)), bars_finding([row for row in every if row.is_reached is not None]))


def missed_words(row: Row) -> str:
    """A target that was missed, with the measured number."""
    return f"{row.name} ({three_digits(row.value or 0.0)} {row.unit}, target {bar(row)})"


MACHINE = "One machine, named on this page, and one run of the whole measurement."
NEAR = 0.2  # of its target: a number that another run may put on the other side


def peer_findings(peers: Sequence[Row]) -> tuple[wb.Finding, ...]:
    """The ratio to each peer; none where no peer is installed."""
    if not peers:
        return ()
    ratios = {row.name: float(row.value or 0.0) for row in peers}
    slowest = min(ratios, key=ratios.__getitem__)
    equal = [ratio for name, ratio in ratios.items() if AT_ERROR in name]
    at_error = f" At equal error, the ratio to CVODES is {span(equal)}." if equal else ""
    return (
        wb.Finding(
            name="faster_than_peers",
            statement=f"The engine runs the workload {span(list(ratios.values()))} times as fast as its peers. The "
            f"smallest ratio is that to {slowest}.{at_error}",
            evidence="Engine and peer run in turns in one process, and CPU time is counted. Only CVODES is compared at "
            "equal error; the other peers run at the settings named here, with the errors in the table of targets.",
            statistic="Ratio of the median rates, in runs per second of one core.",
            sample=f"{len(peers)} rows of peers, with at least {EFFORT.repetitions} repetitions for each.",
            information=MACHINE,
            assumptions="The workload, its step, and the settings of the peers.",
            answer="the engine is faster",
            variations=(
                *(wb.Variation(f"{name}", faster(one), f"{three_digits(one)} times") for name, one in ratios.items()),
                *(
                    wb.Variation(
                        f"{name}, if three times as fast in scalars",
                        faster(one / 3),
                        f"{three_digits(one / 3)} times",
                    )
                    for name, one in ratios.items()
                    if name in IN_MATRICES
                ),
            ),
            limitations="another machine, other workloads, several threads, graphics cards",
        ),
    )


def faster(ratio: float) -> str:
    """The faster of the two."""
    return f"the {'engine' if ratio > 1 else 'peer'} is faster"


def span(ratios: Sequence[float]) -> str:
    """The least and the largest ratio."""
    return wb.document.span(ratios, three_digits)


def bars_finding(rows: Sequence[Row]) -> wb.Finding:
    """The targets that are reached and missed, and those so near to the measured number that another run may differ."""
    missed = [row for row in rows if not row.is_reached]
    near = [row for row in rows if abs((row.value or 0.0) / row.bar - 1) < NEAR]
    named = first_of([missed_words(row) for row in missed], 3)
    turning = (
        f" {len(near)} numbers lie within {100 * NEAR:.0f} % of the target: {first_of([row.name for row in near], 3)}."
    )
    return wb.Finding(
        name="bars_reached",
        statement=f"{len(rows) - len(missed)} of {len(rows)} measured targets are reached"
        f"{f', and {len(missed)} are missed: {named}' if missed else ''}.",
        evidence=(
            "The numbers are in ",
            wb.document.CrossReference("bars"),
            f". Times differ from run to run, and more from machine to machine.{turning if near else ''}",
        ),
        statistic="The number of targets that are reached.",
        sample="One run of the page.",
        information=MACHINE,
        assumptions="The targets.",
        answer=reached_count(rows),
        variations=(
            wb.Variation(WHERE, count()),
            *(
                wb.Variation(
                    f"{row.name} on the other side of its target", reached_count(rows, but=row), missed_words(row)
                )
                for row in near
            ),
        ),
        limitations="another machine, other load, and repetitions of the whole measurement",
        is_decided=not near,
    )


def reached_count(rows: Sequence[Row], but: Row | None = None) -> str:
    """The number of targets that are reached, with one row `but` counted on the other side of its target."""
    return f"{sum(bool(row.is_reached) != (row is but) for row in rows)} of {len(rows)}"


def bars(every: Sequence[Row]) -> wb.document.ReportTable:
    """Every row with its target and its verdict."""
    heads = ("runs/s of one core", "measured", "target", "error of RMSE")
    columns = (
        wb.document.TableColumn("against, or what"),
        *(wb.document.TableColumn(head, align="right") for head in heads),
        wb.document.TableColumn("verdict"),
    )
    verdicts: dict[bool | None, wb.document.Phrase] = {
        True: "reached",
        False: wb.document.Strong("MISSED"),
        None: "not measured",
    }
    cells: tuple[tuple[wb.document.Cell, ...], ...] = tuple(
        (
            row.name,
            row.runs_per_s and three_digits(row.runs_per_s),
            None if row.value is None else f"{three_digits(row.value)} {row.unit}",
            bar(row),
            row.error and f"{row.error:.1e}",
            verdicts[row.is_reached],
        )
        for row in every
    )
    caption = "The targets of the engine, and what was measured. In a row with a ratio, the rate is that of the peer."
    return wb.document.ReportTable("bars", caption, columns, cells, ("x: the factor by which the engine is faster.",))


def bar(row: Row) -> str:
    """The target with its sign and unit."""
    sign = "\N{LESS-THAN OR EQUAL TO}" if row.at_most else "\N{GREATER-THAN OR EQUAL TO}"
    return f"{sign} {three_digits(row.bar)} {row.unit}"


def three_digits(value: float) -> str:
    """Three digits, or all of a larger whole part."""
    return f"{value:,.0f}" if abs(value) >= 100 else f"{value:.3g}"


study = wb.Study(
    name="p0_performance",
    title="The batch engine: how fast, and at what error",
    question=(
        "How many closed loops per second does the engine run on one core? How much faster is it than other tools that "
        "a user could pick? How near is it to the machine's limit? And what is the error of each tool?"
    ),
    method=(
        "One loop (like AOSMC-RGS, 21 states, 40 parameters of which 10 vary, 10 s, RK4 at 1 ms) is run by the engine "
        "and by each peer in turns, in one process that is restricted to one core. Rates are in runs per second of CPU "
        "time, each the median of several turns. Errors are relative errors of the RMSE against a run with a step of "
        "10 microseconds, each the median over the runs. The peak of a core is its rate of independent fused "
        "multiplications and additions. All times are of one machine and one run."
    ),
    sections=sections,
    fingerprints={"W": loop().fingerprint[:16]},
    seed=SEED,
    measures_time=True,
)

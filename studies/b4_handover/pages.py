"""The page of b4: the findings, what is handed over, the targets, the margins, the periods, and growing errors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import workbench as wb
from studies.b4_handover.findings import (
    CLOCK,
    HANDED,
    PATHS,
    START_WORDS,
    all_losses,
    amount,
    error_of,
    longest_period,
    loss_finding,
)
from studies.b4_handover.loops import ERROR, NEAR_START, TRANSIENT_SHARE, TV, handover_loops, shown_card
from studies.b4_handover.machine_tables import machines_section
from studies.b4_handover.machines import M4F, differing_laws, fit_of, machine_findings
from studies.b4_handover.margins import BOTH, DRAWS, NEAR, Loss, margins, quiet_periods, scans
from studies.b4_handover.missed_periods import clock_finding, far_off, shared_table
from studies.b4_handover.predictive_tables import predictive_section
from studies.paper.card import PROPOSED_LAW
from studies.paper.quiet_periods import QUIET, ends

KEEPS_RATIO, STANDS_RATIO = wb.evidence.KEEPS_RATIO, wb.evidence.STANDS_RATIO


def sections(results: wb.Results) -> wb.Page:
    """The whole page."""
    return wb.Page(
        answer(results),
        (
            *machine_findings(results),
            longest_period(results),
            loss_finding(results),
            clock_finding(results),
        ),
        (
            wb.Section("Chattering over the period, from two starts", (periods_figure(results),)),
            periods_section(results),
            machines_section(results),
            predictive_section(results),
            losses_section(results),
            margins_section(results),
            handed_section(),
        ),
    )


def answer(results: wb.Results) -> str:
    """The answer of the page in one line."""
    targets = differing_laws(results)
    equal = sum(not laws for laws in targets.values())
    law = next(one for one in handover_loops() if one.name == PROPOSED_LAW)
    near, far = (fit_of(results, law, M4F, start) for start in BOTH)
    bits = f"{len(handover_loops())} laws compute the same bits on {equal} of {len(targets)} targets."
    if not (near and far):
        return bits
    return (
        f"{bits} In double precision, {PROPOSED_LAW} takes {1e3 * far.count / far.clock:.2g} ms on a Cortex-M4F. "
        f"Started on the reference, it allows periods up to {1e3 * near.period:.2g} ms without chattering; at the "
        f"paper's start, {1e3 * far.period:.2g} ms."
    )


def handed_section() -> wb.Section:
    """The laws, their computers, and their fingerprints."""
    rows = []
    for one in handover_loops():
        law = one.digital().law()
        limits = ", ".join(f"±{high:g} {law.commands[name].unit}" for name, (_, high) in one.limit.items())
        late = max(law.delay.values(), default=0)
        steps = ", ".join(f"{value:.2g} {law.readings[name].unit}" for name, value in one.quantum.items())
        rows.append(
            (one.name, 1e3 * one.period, late, limits, steps, law.memory.size, wb.document.Code(law.fingerprint[:12]))
        )
    columns = (
        wb.document.TableColumn("law"),
        wb.document.TableColumn("period", "ms", "right"),
        wb.document.TableColumn("delay", "periods", "right"),
        wb.document.TableColumn("limits"),
        wb.document.TableColumn("quantisation steps of the readings"),
        wb.document.TableColumn("numbers in memory", align="right"),
        wb.document.TableColumn("fingerprint"),
    )
    words = (
        "Each law is handed over for one period, with its observer, its limits, its memory and the queue that delays "
        "a command by a period. The law reads its reference at each instant. The first four laws drive "
        "the arm of the paper along the paper's first scenario. LQG holds the arm at a pose under the same "
        "disturbance. EKF + LQR balances a cart-pole whose cart follows a sine. AOSMC-RGS is the repaired law of a1. "
        "An observer of the momentum replaces the true disturbance, which no instrument gives."
    )
    given = "; ".join(f"{one.name}: {one.information}" for one in handover_loops())
    starts = "; ".join(f"{one.name}: {one.starts[0]} (near), {one.starts[1]} (far)" for one in handover_loops())
    caption = "The laws that are handed over, and their computers."
    handed_table = wb.document.ReportTable(
        HANDED, caption, columns, tuple(rows), (f"Given: {given}.", f"Starts: {starts}.")
    )
    return wb.Section(
        "What is handed over",
        (wb.Paragraph(words), handed_table, shown_card().table("assumed", "card", "The assumed numbers.")),
    )


def margins_section(results: wb.Results) -> wb.Section:
    """Each effect by itself."""
    caption = (
        "Each effect of the computer by itself, from starts about the {}: the growth of the error at the declared "
        f"level, and the largest levels up to which the error of every run stays within {KEEPS_RATIO:g} times, or "
        f"within {STANDS_RATIO:g} times, its error without the effect."
    )
    tables = [
        wb.evidence.computer_table(
            f"margins{'' if start == NEAR_START else '_far'}",
            caption.format(START_WORDS[start]),
            [(one.name, margins(results, one, start=start)) for one in handover_loops()],
        )
        for start in BOTH
    ]
    tables = [replace(one, notes=one.notes + far_off(results, start)) for one, start in zip(tables, BOTH, strict=True)]
    late = {key: scan.threshold for key, scan in scans(results).delays.items()}
    delays = wb.document.ReportTable(
        "delays",
        "The longest delay from reading to command, from the near start; the declared delay is one period.",
        (
            wb.document.TableColumn("loop"),
            wb.document.TableColumn("error kept up to", "periods", "right"),
            wb.document.TableColumn("not kept at", "periods", "right"),
        ),
        tuple((one.name, int(late[one.key].largest), finite(late[one.key].next)) for one in handover_loops()),
        (
            f"Kept: at most {KEEPS_RATIO:g} times the error with a delay of one period. One run for each delay, always "
            "at the declared period.",
        ),
    )
    words = (
        "With jitter, each instant comes late by a new random delay, which is uniform up to the stated level. Law and "
        "reference use the nominal time. In a missed period the computer does nothing: command and memory keep their "
        "values. Readings become coarser in multiples of the declared quantisation steps. Each level has "
        f"{DRAWS} runs from starts within {NEAR:g} rad or m of the near or the far start. Each run is compared with "
        "the run from the same start without the effect."
    )
    blocks: tuple[wb.document.Block, ...] = (
        wb.Paragraph(words),
        *tables,
        shared_table(results),
        delays,
        ladders(results),
    )
    return wb.Section("The largest level of each effect that the laws tolerate", blocks)


def finite(value: float) -> wb.document.Cell:
    """A whole number, or that there is none."""
    return int(value) if np.isfinite(value) else "not met"


def ladders(results: wb.Results) -> wb.document.Figure:
    """The error over each effect, of all loops."""
    panels = []
    for name, label in (
        ("coarser readings", "multiple of the declared steps"),
        ("jitter", "jitter [% of the period]"),
        ("missed periods", "missed periods [%]"),
    ):
        series = []
        for style, one in enumerate(handover_loops()):
            held = next(each for each in margins(results, one).each if each.effect.name == name)
            scale = {"jitter": 100 / one.period, "missed periods": 100.0}.get(name, 1.0)
            worst = held.ratios.max(axis=1)
            y = np.where(np.isinf(worst), np.nan, worst)
            series.append(wb.document.Series(one.name, scale * np.array(held.effect.levels), y, style))
        panels.append(wb.document.Panel("error ratio", tuple(series), label, xscale="log", yscale="log"))
    caption = (
        f"The ratio of the settled error to its value without the effect: the worst of {DRAWS} runs about the near "
        "start and of the joints. A line ends where a run diverges."
    )
    return wb.document.Figure("ladders", caption, tuple(panels), columns=3)


def periods_figure(results: wb.Results) -> wb.document.Figure:
    """Total variation over the period, from both starts."""
    panels = []
    for start in BOTH:
        series = []
        for style, one in enumerate(handover_loops()):
            found = quiet_periods(results).get((one.name, PATHS[start]))
            if found:
                y = QUIET * found.largest_setting.worst(TV)
                x = 1e3 * np.array(found.largest_setting.threshold.values)
            else:
                scan = scans(results).periods[one.key, start]
                x, y = 1e3 * np.array(scan.threshold.values), np.asarray(scan.TV)
            series.append(wb.document.Series(one.name, x, np.where(np.isinf(y), np.nan, y), style))
        series.append(wb.document.Series("allowed", np.array([0.025, 30.0]), np.full(2, QUIET), "bound"))
        axes = "total variation, ratio", tuple(series), "period [ms]"
        panels.append(wb.document.Panel(*axes, xscale="log", yscale="log", title=START_WORDS[start]))
    caption = (
        "Total variation of the commands as a function of the period, with exact readings and commands a period late. "
        "It is divided by its value in continuous time; for LQG and EKF + LQR, by its value at a quarter of the "
        "declared period."
    )
    return wb.document.Figure("periods", caption, tuple(panels), columns=2)


def periods_section(results: wb.Results) -> wb.Section:
    """The longest period allowed, by start."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for one in handover_loops():
        cells: list[wb.document.Cell] = []
        for start in BOTH:
            found = quiet_periods(results).get((one.name, PATHS[start]))
            low, high = ends(found) if found else bracket(scans(results).periods[one.key, start].threshold)
            rule: wb.document.Cell = 1e3 * found.rule if found and found.rule is not None else None
            cells += [rule, 1e3 * low, 1e3 * high if np.isfinite(high) else "none tried"]
        rows.append((one.name, 1e3 * one.period, *cells))
    columns = (
        wb.document.TableColumn("law"),
        wb.document.TableColumn("declared", "ms", "right", digits=3),
        *(
            column
            for start in ("near", "far")
            for column in (
                wb.document.TableColumn(f"limit by the eigenvalue, {start}", "ms", "right", digits=3),
                wb.document.TableColumn(f"allowed up to, {start}", "ms", "right", digits=3),
                wb.document.TableColumn(f"not allowed at, {start}", "ms", "right", digits=3),
            )
        ),
    )
    notes = (
        f"Laws of the paper's arm: total variation at most {QUIET:g} times its value in continuous time, by the "
        f"search of a9. LQG and EKF + LQR: error at most {KEEPS_RATIO:g} and total variation at most {QUIET:g} times "
        "their values at a quarter of the declared period; each period tried is a quarter longer than the last.",
        (
            "Near and far: the starts listed below ",
            wb.document.CrossReference(HANDED),
            ". Limit by the eigenvalue: the period above which the boundary layer is unstable, by the largest "
            "eigenvalue of M^-1 K along the run in continuous time (a9). A dash: the law has no switching gain.",
        ),
    )
    caption = "The longest period allowed from the near and from the far start."
    table = wb.document.ReportTable("periods_table", caption, columns, tuple(rows), notes)
    return wb.Section("The longest period allowed", (table,))


def bracket(threshold: wb.evidence.Threshold) -> tuple[float, float]:
    """The two ends of a search."""
    return threshold.largest, threshold.next


def loss_cell(loss: Loss) -> wb.document.Cell:
    """A loss in per cent, as a cell."""
    return wb.document.ValueWithError(100 * loss.value, 100 * loss.error) if np.isfinite(loss.value) else "diverged"


def losses_section(results: wb.Results) -> wb.Section:
    """The growth of the error without double precision and a perfect clock, from both starts."""
    tables = [losses_table(results, start) for start in BOTH]
    return wb.Section("The error that single precision and an imperfect clock add", tuple(tables))


def losses_table(results: wb.Results, start: str) -> wb.document.ReportTable:
    """The growth of the error of each loop from a start."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for one in handover_loops():
        own = all_losses(results, start=start)[one.name]
        error, _, unit = error_of(results, one.name, start=start)
        more = error * own.together.value
        growth = amount(more, unit).replace("-", "\N{MINUS SIGN}") if np.isfinite(more) else "diverged"
        parts = (own.readings, own.single, own.jitter, own.missed_periods, own.together, own.noisier)
        rows.append((one.name, amount(error, unit), growth, *map(loss_cell, parts)))
    heads = ("readings", "single precision", "jitter", "missed periods", "all three", "TV, all three")
    columns = (
        wb.document.TableColumn("law"),
        wb.document.TableColumn(ERROR, align="right"),
        wb.document.TableColumn("mean growth, all three", align="right"),
        *(wb.document.TableColumn(head, "%", "right") for head in heads),
    )
    notes = (
        f"Growth of the settled error, which is the error after {100 * TRANSIENT_SHARE:.0f} % of the run, at the "
        f"worst joint: the mean over {DRAWS} starts, with twice its standard error. Readings: the growth from exact "
        "to quantised readings. The other columns give the growth from double precision and a perfect clock, with "
        f"quantised readings in both: by single precision; by {CLOCK}; by all three, which are single precision, "
        "jitter and missed periods. TV: the total variation of the commands.",
    )
    name = "losses" if start == NEAR_START else f"losses_{start}"
    return wb.document.ReportTable(
        name,
        f"The growth of the settled error, from starts about the {START_WORDS[start]}.",
        columns,
        tuple(rows),
        notes,
    )

"""The page of b4: the findings, what is handed over, the targets, the margins, the periods, and what is lost."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from studies.b4_handover.findings import CLOCK, all_losses, findings
from studies.b4_handover.loops import CARD, ERROR, SETTLED, handed
from studies.b4_handover.machines import machine_findings, machines_section
from studies.b4_handover.margins import DRAWS, NEAR, QUIET, Loss, margins, scans
from workbench.study import Figure, Paragraph, Results, Section, Table
from workbench.study.document.document import Cell, Code, Column, Measured, Panel, Series
from workbench.study.evidence.computer_margins import KEPT, STANDS, computer_table


def sections(results: Results) -> Sequence[Section]:
    """The whole page."""
    return (
        Section("What was found", (periods_figure(results), *machine_findings(results), *findings(results))),
        handed_section(),
        machines_section(results),
        margins_section(results),
        periods_section(results),
        losses_section(results),
    )


def headlines(results: Results) -> Sequence[str]:
    """The findings in a line each."""
    return tuple(str(one.statement) for one in (*machine_findings(results), *findings(results)))


def handed_section() -> Section:
    """The laws, their computers, and their fingerprints."""
    rows = []
    for one in handed():
        law = one.digital().law()
        limits = ", ".join(f"±{high:g} {law.commands[name].unit}" for name, (_, high) in one.limit.items())
        late = max(law.delay.values(), default=0)
        steps = ", ".join(f"{value:.2g} {law.readings[name].unit}" for name, value in one.quantum.items())
        rows.append((one.name, 1e3 * one.period, late, limits, steps, law.memory.size, Code(law.fingerprint[:12])))
    columns = (
        Column("law"),
        Column("period", "ms", "right"),
        Column("delay", "periods", "right"),
        Column("limits"),
        Column("steps of the readings"),
        Column("numbers kept", align="right"),
        Column("fingerprint"),
    )
    words = (
        "Each law leaves with its observer, limits, memory and the queue of a command that is a period late, for the "
        "period that is stated; what is wanted comes in at each instant. The first four drive the arm of the paper "
        "along its first scenario from a start on the reference, LQG holds it at a pose under the same disturbance, "
        "and EKF and LQR balance a cart-pole that follows a sine. AOSMC-RGS is the repaired law of a1, with the true "
        "disturbance, which no instrument gives, replaced by an observer of the momentum."
    )
    given = "; ".join(f"{one.name}: {one.given}" for one in handed())
    caption = "What is handed over, and to which computer."
    handed_table = Table("handed", caption, columns, tuple(rows), (f"Given: {given}.",))
    return Section(
        "What is handed over", (Paragraph(words), handed_table, CARD.table("assumed", "card", "What is assumed."))
    )


def margins_section(results: Results) -> Section:
    """Each effect by itself."""
    own = [(one.name, margins(results, one)) for one in handed()]
    caption = (
        "What the computer may do to each law: the loss at what is declared, and how far each effect may go before a "
        f"run has more than {KEPT:g} and {STANDS:g} times the error."
    )
    late = {key: scan.threshold for key, scan in scans(results).delays.items()}
    table = computer_table("margins", caption, own)
    delays = Table(
        "delays",
        "The periods from reading to command, of which one is declared.",
        (Column("loop"), Column("error kept up to", "periods", "right"), Column("no longer at", "periods", "right")),
        tuple((one.name, int(late[one.key].largest), finite(late[one.key].next)) for one in handed()),
        (f"Kept: at most {KEPT:g} times the error with one period. One run each; no period is shortened for a delay.",),
    )
    words = (
        "An instant comes late by a delay that is uniform up to the jitter, fresh each time, while law and reference "
        "count on the nominal time; in a missed period nothing is done, and command and memory stay. Readings grow "
        f"coarser from the declared steps on. Each level has {DRAWS} runs from starts within {NEAR:g} of the loop's "
        "own, each held against the run of the same start without the effect."
    )
    return Section("The law's margin for what the computer does", (Paragraph(words), ladders(results), table, delays))


def finite(value: float) -> Cell:
    """A whole number, or that there is none."""
    return int(value) if np.isfinite(value) else "not met"


def ladders(results: Results) -> Figure:
    """The error over each effect, of all loops."""
    panels = []
    for name, label in (
        ("coarser readings", "declared steps, times"),
        ("jitter", "jitter [% of the period]"),
        ("missed periods", "missed periods [%]"),
    ):
        series = []
        for style, one in enumerate(handed()):
            held = next(each for each in margins(results, one).each if each.effect.name == name)
            scale = {"jitter": 100 / one.period, "missed periods": 100.0}.get(name, 1.0)
            worst = held.ratios.max(axis=1)
            y = np.where(np.isinf(worst), np.nan, worst)
            series.append(Series(one.name, scale * np.array(held.effect.levels), y, style))
        panels.append(Panel("error, times", tuple(series), label, xscale="log", yscale="log"))
    caption = (
        f"The error after the approach over that without the effect, the worst of {DRAWS} runs and of the joints; a "
        "line ends where a run diverges."
    )
    return Figure("ladders", caption, tuple(panels), columns=3)


def periods_figure(results: Results) -> Figure:
    """Error and total variation over the period."""
    panels = []
    for label, kind, bound in (("error, times", "error", KEPT), ("total variation, times", "TV", QUIET)):
        series = []
        for style, one in enumerate(handed()):
            found = scans(results).periods[one.key]
            y = getattr(found, kind)
            series.append(
                Series(one.name, 1e3 * np.array(found.threshold.values), np.where(np.isinf(y), np.nan, y), style)
            )
        ends = np.array([0.05, 30.0])
        series.append(Series("allowed", ends, np.full(2, bound), "bound"))
        panels.append(Panel(label, tuple(series), "period [ms]", xscale="log", yscale="log"))
    caption = (
        "Error and total variation of the commands over the period, both over those of a quarter of the declared "
        "period, with exact readings and commands that are a period late."
    )
    return Figure("periods", caption, tuple(panels), columns=2)


def periods_section(results: Results) -> Section:
    """The longest period that sampling allows."""
    rows: list[tuple[Cell, ...]] = []
    for one in handed():
        found = scans(results).periods[one.key].threshold
        after: Cell = 1e3 * found.next if np.isfinite(found.next) else "not met"
        rows.append((one.name, 1e3 * one.period, 1e3 * found.largest, after, found.largest / one.period))
    columns = (
        Column("law"),
        *(Column(head, "ms", "right", digits=3) for head in ("declared", "allowed up to", "not allowed at")),
        Column("room", "times", "right", digits=3),
    )
    notes = (
        f"Allowed: error at most {KEPT:g} and total variation at most {QUIET:g} times those of a quarter of the "
        "declared period, at periods that rise by a quarter from one to the next, up to the first that is not; one run "
        "each.",
    )
    table = Table("periods_table", "The longest period that sampling allows.", columns, tuple(rows), notes)
    return Section("The longest period", (table,))


def shown(loss: Loss) -> Cell:
    """A loss in per cent, as a cell."""
    return Measured(100 * loss.value, 100 * loss.error) if np.isfinite(loss.value) else "lost"


def losses_section(results: Results) -> Section:
    """The end of the page: what is lost by leaving double precision and a perfect clock."""
    rows = []
    for one in handed():
        own, base = all_losses(results)[one.name], margins(results, one).without.mean(axis=0)
        unit = one.made(one.period).plant.outputs[one.follows].unit
        parts = (own.readings, own.single, own.jitter, own.missed, own.together, own.noisier)
        rows.append((one.name, f"{base.max():.3g} {unit}", *map(shown, parts)))
    heads = ("readings", "single", "jitter", "missed", "all three", "TV, all three")
    columns = (Column("law"), Column(ERROR, align="right"), *(Column(head, "%", "right") for head in heads))
    notes = (
        f"In per cent of the error, from {100 * SETTLED:.0f} % of the run on, the worst joint; the mean over {DRAWS} "
        "starts, paired, with twice its standard error. Readings: from exact ones to those with steps. The others are "
        f"held against double precision and a perfect clock with the same readings: single precision; {CLOCK}; all "
        "three. TV: the total variation of the commands.",
    )
    table = Table("losses", "What is lost without double precision and a perfect clock.", columns, tuple(rows), notes)
    return Section("What is lost without double precision and a perfect clock", (table,))

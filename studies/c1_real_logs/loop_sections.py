"""The sections of the positioning system and of the tanks, each of which begins with the misfit."""

from __future__ import annotations

from collections.abc import Sequence

import workbench as wb
from studies.c1_real_logs.logs import SOURCES
from studies.c1_real_logs.pendulum_section import number_column
from studies.c1_real_logs.positioning import CUTOFF, PUBLISHED, UNITS, WAYS, Estimate
from studies.c1_real_logs.tanks import TankFit

PER_CENT = 0.01  # of a published number
TANK_TABLE = (  # as table 2 of the article in the notes prints them; it was read
    ("polynomial nonlinear state space", 0.4498),
    ("nonlinear state space 2", 0.3433),
    ("best linear approximation", 0.7574),
    ("Volterra, third degree", 0.5400),
)


def is_near(estimate: Estimate, word: str) -> bool:
    """True if a number is within 1 % of the published one."""
    return abs(estimate.values[word] / PUBLISHED[word] - 1) <= PER_CENT


def positioning_section(results: wb.Results) -> wb.Section:
    """The positioning system."""
    every: Sequence[Estimate] = results.work("positioning")
    misfits = [wb.Paragraph(f"{way[0].upper()}{way[1:]}. {one.misfit}") for way, one in zip(WAYS, every, strict=True)]
    loop, free = every[1], every[2]
    controller = (
        "In the loop the reference drives the published controller, and both the position and the command are outputs, "
        "each weighed by its own noise, which is estimated. Three things decide this fit. The speed of the controller "
        "is the backward difference of the half sum of two readings, and so one period of 1 ms late: with the gains of "
        f"the file, this law gives the logged command from the logged readings to {1000 * loop.law[0]:.2g} mV, and to "
        f"{1000 * loop.law[1]:.3g} mV if it were not late. The command is held, and so half a period late in the mean. "
        f"And friction does not turn at once: tanh(q' / v) has a fitted v of {1000 * loop.values['slow']:.3g} mm/s. "
        f"If both delays are fitted too, they are {1000 * free.values['late']:.3g} and "
        f"{1000 * free.values['hold']:.3g} ms, and no number of the table moves by more than "
        f"{100 * max(abs(free.values[word] / loop.values[word] - 1) for word in PUBLISHED):.2g} %."
    )
    method = (
        f"Source: {SOURCES['emps']}. The regression goes through one filter of {CUTOFF:g} Hz, and its standard "
        "errors allow for correlated residuals. Those in the loop do not, and are too small. The form of the model in "
        "the loop was settled with the published numbers in view; its gains and delays are those of the source."
    )
    table = positioning_table(every)
    return wb.Section("The positioning system", (*misfits, table, wb.Paragraph(controller), wb.Paragraph(method)))


def positioning_table(every: Sequence[Estimate]) -> wb.document.ReportTable:
    """The numbers of the carriage beside the published ones."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for word, published in PUBLISHED.items():
        cells = [f"{one.values[word]:.5g} \N{PLUS-MINUS SIGN} {one.standard_errors[word]:.1g}" for one in every]
        near = [f"{round(100 * (one.values[word] / published - 1), 2) + 0.0:+.2f} %" for one in every]
        texts = [f"{a} ({b})".replace("-", "\N{MINUS SIGN}") for a, b in zip(cells, near, strict=True)]
        rows.append((f"{word} [{UNITS[word]}]", published, *texts))
    columns = (
        wb.document.TableColumn("number"),
        number_column("published", digits=6),
        *(wb.document.TableColumn(way) for way in WAYS),
    )
    notes = (
        "In brackets the difference from the published number, which the authors' program Simulation_EMPS states "
        "(Janot, Gautier and Brunot 2019); intervals of the source were not found. The gain of the drive is that of "
        "the file. The controller is that of the authors' simulation as the program nlgreyfast restates it (Retzler, "
        "Swevers, Gillis and Kollar 2022).",
    )
    return wb.document.ReportTable(
        "positioning", "The carriage, by three ways, with standard errors.", columns, tuple(rows), notes
    )


def loop_fit_section(results: wb.Results) -> wb.Section:
    """The fit of the positioning system in its loop."""
    fit = results.work("positioning")[1].fit
    return wb.fit_section(fit, "The positioning system in its loop: the fit", name="positioning_fit")


def tank_fit_section(results: wb.Results) -> wb.Section:
    """The fit of the tanks."""
    return wb.fit_section(results.work("tanks")[0].summary, "The cascaded tanks: the fit", name="tank_fit")


def tank_section(results: wb.Results) -> wb.Section:
    """The cascaded tanks."""
    one: TankFit = results.work("tanks")[0]
    misfit = (
        f"The model misses the level of the lower tank by {one.hold_out_error:.3g} V on the record that was held out "
        f"and by {one.error:.3g} V on the other (root mean square)."
    )
    marked = " and ".join(map(str, one.marked_samples))
    method = (
        f"Source: {SOURCES['cascaded_tanks']}. The sensor ends at 10 V: {marked} samples "
        "there are marked, have no weight, and count in the error of the hold-out, where the model is cut off at 10 V "
        "too. Both initial levels of the hold-out were estimated from it, and nothing else. The form of the model was "
        "chosen among nine with the hold-out in view."
    )
    others: list[tuple[wb.document.Cell, ...]] = [("this page, in V", one.hold_out_error), *TANK_TABLE]
    beside = wb.document.ReportTable(
        "tank_errors",
        "The error on the hold-out beside printed ones.",
        (wb.document.TableColumn("model"), number_column("error", digits=4)),
        tuple(others),
        (
            "Printed: Hammerstein Box-Jenkins system identification of the cascaded tanks benchmark system, "
            "Mathematical Problems in Engineering (2021) 6613425, table 2, whose head says mean squares. If they are, "
            "their roots are 0.671, 0.586, 0.870 and 0.735 V; ours is a root.",
        ),
    )
    return wb.Section("The cascaded tanks", (wb.Paragraph(misfit), beside, wb.Paragraph(method)))

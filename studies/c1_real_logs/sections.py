"""The sections of the page, each of which begins with the misfit."""

from __future__ import annotations

from collections.abc import Sequence

import workbench as wb
from studies.c1_real_logs.logs import MODELS, POOR_LOGS, SOURCES
from studies.c1_real_logs.pendulum import CUTOFF, DELAYS, TERMS, Fold
from studies.c1_real_logs.positioning import CUTOFF as FORCE_CUTOFF
from studies.c1_real_logs.positioning import PUBLISHED, UNITS, Estimate
from studies.c1_real_logs.tanks import TankFit

JOINTS = ("shoulder", "elbow")
WAYS = ("inverse dynamics", "loop, stated gains", "loop, fitted gains")
PER_CENT = 0.01  # of a published number
TANK_TABLE = (  # as table 2 of the article in the notes prints them; it was read
    ("polynomial nonlinear state space", 0.4498),
    ("nonlinear state space 2", 0.3433),
    ("best linear approximation", 0.7574),
    ("Volterra, third degree", 0.5400),
)


def folds(results: wb.Results) -> Sequence[Fold]:
    """The excitations that were held out in turn."""
    return results.work("pendulum")


def both_beaten(one: Fold) -> bool:
    """True if both torques are better than those of each published model."""
    return all(one.beaten(joint) == len(MODELS) for joint in range(2))


def number_column(name: str, unit: str = "", digits: int = 3) -> wb.document.TableColumn:
    """A column of numbers."""
    return wb.document.TableColumn(name, unit, "right", digits=digits)


def pendulum_section(results: wb.Results) -> wb.Section:
    """The double pendulum."""
    every = folds(results)
    worst = [max(one.ours[joint] for one in every) for joint in range(2)]
    lost = [f"{one.name} ({JOINTS[j]})" for one in every for j in range(2) if one.beaten(j) < len(MODELS)]
    misfit = (
        f"On the excitation that was held out, the model misses the torque by up to {worst[0]:.3g} N m at the shoulder "
        f"and {worst[1]:.3g} N m at the elbow (root mean square). In {sum(map(both_beaten, every))} of {len(every)} "
        f"excitations both torques are nearer than those of all published models; missed: {', '.join(lost) or 'none'}."
    )
    method = (
        f"The log is from {SOURCES['double_pendulum_dfki']}. Positions and torques go through one filter of {CUTOFF:g} "
        f"Hz. The torque may come up to {1000 * max(DELAYS):g} ms before the motion: each fit takes the delay of the "
        "least error on its own four logs. The published models are evaluated with the same positions, and with the "
        "better of that delay and none. The errors are against the torques as measured. Model 2.0 was made from logs "
        "of this machine, among which these may be; a fit of ours has never seen its hold-out. The form of the model "
        "(first moments beside the links, slow samples without weight) and the cutoff were chosen with all five logs "
        "in view. The Coulomb friction of the published models is cf arctan(100 qd), quoted from memory. "
        f"Samples below {TERMS.least_speed:g} rad/s have no weight in a fit and count in the errors."
    )
    refusals = [
        wb.Paragraph(f"The log {file.rpartition('/')[2]} of the design C.1 alone is refused. {text}")
        for file, text in zip(POOR_LOGS, results.work("poor"), strict=True)
    ]
    tables = (fold_table(every), number_table(every))
    return wb.Section("The double pendulum", (wb.Paragraph(misfit), *tables, wb.Paragraph(method), *refusals))


def fold_table(every: Sequence[Fold]) -> wb.document.ReportTable:
    """The errors by excitation."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for one in every:
        for j, joint in enumerate(JOINTS):
            others = [errors[j] for errors in one.published_errors]
            verdict = "yes" if one.beaten(j) == len(MODELS) else "no"
            rows.append((one.name, joint, one.ours[j], *others, verdict, 1000 * one.delay, one.condition))
    columns = (
        wb.document.TableColumn("held out"),
        wb.document.TableColumn("joint"),
        number_column("ours", "N m", 4),
        *(number_column(f"model {name}", "N m", 4) for name in MODELS),
        wb.document.TableColumn("ours is best"),
        number_column("delay", "ms"),
        number_column("condition"),
    )
    notes = (
        "Condition: of the weighed columns of the regression, each of length one. In 060245 the elbow's torque "
        "chatters by 1 N m at a frequency above the filter, which no model here has.",
    )
    caption = "Root mean squares of the torque's error on the excitation that was held out."
    return wb.document.ReportTable("pendulum_errors", caption, columns, tuple(rows), notes)


def number_table(every: Sequence[Fold]) -> wb.document.ReportTable:
    """The numbers of all folds."""
    rows: list[tuple[wb.document.Cell, ...]] = [
        (name, *(f"{one.numbers[name][0]:.4g} +- {one.numbers[name][1]:.1g}" for one in every))
        for name in every[0].numbers
    ]
    columns = (wb.document.TableColumn("number"), *(wb.document.TableColumn(f"without {one.name}") for one in every))
    notes = (
        "First moments in kg m, inertias in kg m^2, frictions in N m s/rad and N m. link1.mc_x has 0.3 m of the mass "
        "of link 2, and link1.I_zz 0.09 m^2 of it and the drive. Each is of a rigid body.",
    )
    return wb.document.ReportTable(
        "pendulum_numbers", "Base parameters with standard errors, by excitation left out.", columns, tuple(rows), notes
    )


def is_near(estimate: Estimate, word: str) -> bool:
    """True if a number is within 1 % of the published one."""
    return abs(estimate.values[word] / PUBLISHED[word] - 1) <= PER_CENT


def positioning_section(results: wb.Results) -> wb.Section:
    """The positioning system."""
    every: Sequence[Estimate] = results.work("positioning")
    rows: list[tuple[wb.document.Cell, ...]] = []
    for word, published in PUBLISHED.items():
        cells = [f"{one.values[word]:.5g} +- {one.standard_errors[word]:.1g}" for one in every]
        near = [f"{100 * (one.values[word] / published - 1):+.2f} %" for one in every]
        rows.append((f"{word} [{UNITS[word]}]", published, *(f"{a} ({b})" for a, b in zip(cells, near, strict=True))))
    columns = (
        wb.document.TableColumn("number"),
        number_column("published", digits=6),
        *(wb.document.TableColumn(way) for way in WAYS),
    )
    notes = (
        "In brackets the difference from the published number, as programs quote it from Janot, Gautier and Brunot "
        "(2019); intervals of the source were not found. The gain of the drive is that of the file.",
    )
    table = wb.document.ReportTable(
        "positioning", "The carriage, by three ways, with standard errors.", columns, tuple(rows), notes
    )
    gains = (
        f"With the gains of the file the loop gives {every[1].values['mass']:.4g} kg, as the logged command is larger "
        f"than they say: fitted, kv is {every[2].values['kv']:.4g} V s/m instead of 243.45, and the mass "
        f"{every[2].values['mass']:.4g} kg. Viscous and Coulomb friction then trade with each other."
    )
    method = (
        f"Source: {SOURCES['emps']}. The regression goes through one filter of {FORCE_CUTOFF:g} Hz, and its standard "
        "errors allow for correlated residuals. Those in the loop do not, and are too small."
    )
    misfits = [wb.Paragraph(f"{one.misfit} ({way})") for way, one in zip(WAYS, every, strict=True)]
    return wb.Section("The positioning system", (*misfits, table, wb.Paragraph(gains), wb.Paragraph(method)))


def tank_section(results: wb.Results) -> wb.Section:
    """The cascaded tanks."""
    one: TankFit = results.work("tanks")[0]
    misfit = (
        f"The model misses the level of the lower tank by {one.hold_out_error:.3g} V on the record that was held out "
        f"and by {one.error:.3g} V on the other (root mean square). {one.warnings}"
    )
    marked = " and ".join(map(str, one.marked_samples))
    method = (
        f"Source: {SOURCES['cascaded_tanks']}. The sensor ends at 10 V: {marked} samples "
        "there are marked, have no weight, and count in the error of the hold-out, where the model is cut off at 10 V "
        "too. Both initial levels of the hold-out were estimated from it, and nothing else. The form of the model was "
        "chosen among nine with the hold-out in view."
    )
    rows: list[tuple[wb.document.Cell, ...]] = [
        (name, f"{value:.4g} +- {one.standard_errors[name]:.1g}") for name, value in one.values.items()
    ]
    numbers = wb.document.ReportTable(
        "tank_numbers",
        "The numbers of the tanks, with standard errors.",
        (wb.document.TableColumn("number"), wb.document.TableColumn("estimate")),
        tuple(rows),
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
    return wb.Section("The cascaded tanks", (wb.Paragraph(misfit), beside, numbers, wb.Paragraph(method)))

"""The sections of c0 on the logs and their fits."""

from __future__ import annotations

import numpy as np

import workbench as wb
from studies.c0_identify_arm.answers import LawLog
from studies.c0_identify_arm.arm import BASE, CARD, FREE, ODD, PERIOD, SPAN, TRUTH, UNITS, WORDS
from studies.c0_identify_arm.estimates import Curves, LogFit
from studies.c0_identify_arm.judgement import Evidence, verdict, words_of
from studies.c0_identify_arm.logs import limit_of

JOINTS = ("joint 1", "joint 2")
SPARSE = 10  # of the thinned readings of a picture, those that are drawn beside the model
NEAR_AXIS = 0.05  # of a direction: an entry above it is named


def number_column(header: str, unit: str = "", digits: int = 3) -> wb.document.TableColumn:
    """A column of numbers at the right."""
    return wb.document.TableColumn(header, unit, "right", digits)


def log_section(evidence: Evidence) -> wb.Section:
    """Both logs and their fits."""
    law, second = evidence.law, evidence.designed_log
    about = (
        f"Both logs have {SPAN:g} s of encoder readings and torques, every {1e3 * PERIOD:g} ms. In the first, "
        "AOSMC-RGS follows the paper's first motion with the paper's model, which has other masses and lengths than "
        "the arm, and no friction. Its noisy estimates make the torque chatter. In the second, the computer plays "
        "sines that were designed for the arm of the first log. The fit drives the equations of the arm by "
        "the torques, and compares the positions with the readings; the last fifth of each log is held out."
    )
    blocks = (
        wb.Paragraph(about),
        wb.Paragraph(fit_words("law's log", law.fit)),
        wb.Paragraph(fit_words("designed log", second.fit)),
        estimate_table(law.fit, second.fit),
        log_figure("law_log", "The log under AOSMC-RGS", law.curves),
        log_figure("designed_log", "The log of the designed excitation", second.curves),
    )
    return wb.Section("Both logs and their fits", blocks)


def fit_words(name: str, fit: LogFit) -> str:
    """The misfit, the hold-out and the residual tests of a fit, in words."""
    misfit = " and ".join(f"{value:.3f}" for _, value in fit.misfit)
    ratios = " and ".join(f"{value:.2f}" for _, value in fit.hold_out)
    least = min(fit.tests, key=lambda test: test[2])
    said = " ".join(fit.warnings) or "The fit has no warning."
    return (
        f"Of the {name}, {misfit} times the noise is left at the two joints; on the hold-out it is {ratios} times as "
        f"large. Of {len(fit.tests)} residual tests, the least p-value is {least[2]:.2g} ({least[0]}, {least[1]}). "
        f"{said}"
    )


def estimate_table(first: LogFit, second: LogFit) -> wb.document.ReportTable:
    """The estimates of both logs beside the truth."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for i, name in enumerate(FREE):
        both = [f"{one.theta[i]:.5f} ± {one.errors[i]:.5f}" for one in (first, second)]
        z = [float((one.theta[i] - TRUTH[i]) / one.errors[i]) for one in (first, second)]
        rows.append((WORDS[name], UNITS[name], TRUTH[i], both[0], z[0], both[1], z[1]))
    columns = (
        wb.document.TableColumn("number"),
        wb.document.TableColumn("unit"),
        number_column("truth"),
        wb.document.TableColumn("law's log", align="right"),
        number_column("off", "std. errors", 2),
        wb.document.TableColumn("designed log", align="right"),
        number_column("off", "std. errors", 2),
    )
    notes = (
        "Estimates with standard errors. Off: the estimate less the truth. The last fifth of each log is held out.",
    )
    return wb.document.ReportTable("estimates", "Estimates from one log of each kind.", columns, tuple(rows), notes)


def log_figure(name: str, caption: str, curves: Curves) -> wb.document.Figure:
    """Readings with the model, residuals, and torques, joint by joint."""
    panels = []
    kept = float(0.8 * SPAN)
    for j, joint in enumerate(JOINTS):
        model = wb.document.Series("model", curves.t, curves.q[:, j] + curves.errors[:, j], 0)
        read = wb.document.Series("readings", curves.t[::SPARSE], curves.q[::SPARSE, j], 1, "marks")
        panels.append(wb.document.Panel("position [rad]", (model, read), vlines=(kept,), title=joint))
    for j in (0, 1):
        left = wb.document.Series("", curves.t, 1e3 * curves.errors[:, j], 0, "marks")
        panels.append(wb.document.Panel("model − reading [mrad]", (left,), vlines=(kept,)))
    for j in (0, 1):
        torque = wb.document.Series("", curves.t, curves.tau[:, j], 0, "steps")
        panels.append(wb.document.Panel("torque [N m]", (torque,), vlines=(kept,)))
    text = f"{caption}: readings and model, what is left, and torques. Behind the thin line, samples are held out."
    return wb.document.Figure(name, text, tuple(panels), columns=2)


# What the logs cannot tell


def untold_section(evidence: Evidence) -> wb.Section:
    """The directions that the logs cannot tell, and those that they tell least."""
    law: LawLog = evidence.law
    masses = (
        "Angles and torques have no unit of length in them. If gravity is estimated as well, a fit is refused, and "
        f"says why: {readable(' '.join(law.lengthless))} Gravity is therefore taken as known."
    )
    rigid = (
        "Links with a mass, a centre of mass and an inertia have more numbers than their motion shows, even if their "
        f"lengths are known: {readable(' '.join(law.rigid))} The paper's arm has all mass at the ends of its links, "
        "which settles both directions."
    )
    weak = [
        f"What the {name} tells least: {weak_direction(fit)}"
        for name, fit in (("law's log", law.fit), ("designed log", evidence.designed_log.fit))
    ]
    held = evidence.law_repeats["held"]
    i = int(np.argmax(held.errors.mean(axis=0) / np.abs(TRUTH)))
    pose = (
        f"While AOSMC-RGS holds the arm in a pose, {WORDS[FREE[i]]} has a standard error of "
        f"{100 * held.errors[:, i].mean() / TRUTH[i]:.0f} % of its number: such a log does not tell it. What it tells "
        "of the rest is due to chattering."
    )
    return wb.Section(
        "What the logs cannot tell",
        (*(wb.Paragraph(text) for text in (masses, rigid, *weak, pose)), odd_table(evidence)),
    )


def readable(text: str) -> str:
    """A sentence with the numbers of the page in the place of their paths."""
    for path, word in WORDS.items():
        text = text.replace(path, word)
    for i in (0, 1):
        for field, word in (("mass", "m"), ("com", "c"), ("inertia", "I")):
            text = text.replace(f"arm.links[{i}].{field}", f"{word}{i + 1}")
    return text.replace("arm.gravity", "g").replace("-", "−")


def weak_direction(fit: LogFit) -> str:
    """The direction of the estimates, relative to their numbers, with the largest standard error."""
    sizes = np.abs(TRUTH)
    values, axes = np.linalg.eigh(fit.covariance / np.outer(sizes, sizes))
    axis = axes[:, -1] * np.sign(axes[np.argmax(np.abs(axes[:, -1])), -1])
    parts = [
        f"{WORDS[FREE[i]]} by {100 * np.sqrt(values[-1]) * axis[i]:+.2g} %"
        for i in np.argsort(-np.abs(axis))
        if abs(axis[i]) > NEAR_AXIS
    ]
    return f"{wb.document.join_names(parts)} at once are one standard error.".replace("-", "−")


def odd_table(evidence: Evidence) -> wb.document.ReportTable:
    """The verdicts on both kinds of logs under other conditions."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for case in (BASE, *ODD):
        cells: list[wb.document.Cell] = [case.words]
        for repeats in (evidence.law_repeats, evidence.designed_repeats):
            if case.name not in repeats:
                cells += [None, None]
                continue
            one = repeats[case.name]
            misfit = float(np.mean(one.worst_misfit)) if len(one.theta) else None
            cells += [verdict(one, case.true_values), misfit]
        cells.append(words_of(evidence.law_repeats[case.name], case.true_values))
        rows.append(tuple(cells))
    columns = (
        wb.document.TableColumn("conditions", width=24),
        wb.document.TableColumn("law's log"),
        number_column("misfit"),
        wb.document.TableColumn("designed log"),
        number_column("misfit"),
        wb.document.TableColumn("worst number of the law's log", width=30),
    )
    notes = (
        "Misfit: the larger root mean square of the residuals of both joints, in units of the noise that is stated; "
        "mean of the logs.",
    )
    return wb.document.ReportTable("conditions", "What logs under other conditions tell.", columns, tuple(rows), notes)


def conditions_section(evidence: Evidence) -> wb.Section:
    """The assumed numbers, and the limits of the design."""
    sizes = dict(evidence.designed_log.largest_sizes)
    words = (
        "The design keeps limits for the arm that the law's log gave; the true arm is another one, and was run once "
        "beside them. Its torques are not corrected by any reading."
    )
    rows: list[tuple[wb.document.Cell, ...]] = []
    units = {"q": "rad", "qd": "rad/s", "tau": "N m"}
    for name, value in sizes.items():
        high = limit_of(name)
        rows.append((name, units[name.partition("[")[0]], high, value, "yes" if value <= high else "no"))
    columns = (
        wb.document.TableColumn("largest size of"),
        wb.document.TableColumn("unit"),
        number_column("limit"),
        number_column("reached", digits=4),
        wb.document.TableColumn("kept"),
    )
    table = wb.document.ReportTable("limits", "Limits of the design on the true arm.", columns, tuple(rows))
    assumed = CARD.table("assumed", "arm", "The assumed arm, computer and encoders.")
    return wb.Section("Conditions", (wb.Paragraph(words), table, assumed))

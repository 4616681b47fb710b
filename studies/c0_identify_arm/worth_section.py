"""The sections of c0 on the worth of a model and on the limits of the linear loop."""

from __future__ import annotations

import numpy as np

import workbench as wb
from studies.c0_identify_arm.judgement import Change, Evidence, both, change
from studies.c0_identify_arm.requirements import ARMS, SPECIFICATION
from studies.c0_identify_arm.sections import number_column
from studies.c0_identify_arm.worth import EFFORT, LAWS, MODELS, MOTIONS, SETTLED, Trial
from studies.c0_identify_arm.worth_findings import all_checks, limit_words

BESIDE = 0.27  # of a row, between the bars of two laws
TABLES = {  # word, unit, units of it in one of SI, and the note
    SETTLED: ("error", "mrad", 1e3, "Root mean square of both positions from 2 s on: means with standard errors."),
    EFFORT: ("torque", "N m", 1.0, "Root mean square of both torques over the run: means with standard errors."),
}
MOTION_WORDS = {"paper": "the paper's first motion", "fast": "a faster motion"}


def worth_section(evidence: Evidence) -> wb.Section:
    """Laws with each model on the true arm, and on the arms that the logs allow."""
    words = (
        "Three laws run with the model of the paper, with those of the logs and with the true one. AOSMC-RGS has "
        "D_hat, which makes up for friction and for errors of the model. LQR + model adds an LQR, designed for each "
        "model, to the torque that the model needs for the reference; the computed torque has the same poles with each "
        "model. Both add the friction of the model at the velocity of the reference."
    )
    drawn = (
        "Before the law is tried on the true arm, the fit predicts its error: the arm is drawn by the factors of "
        "the fit, with their correlations, and the law has the model of the estimates."
    )
    blocks = (
        wb.Paragraph(words),
        worth_figure(evidence),
        worth_table(evidence, SETTLED),
        worth_table(evidence, EFFORT),
        wb.Paragraph(drawn),
        prediction_table(evidence),
    )
    return wb.Section("The cost of not having known", blocks)


def mean_and_error(values: wb.Array) -> wb.document.ValueWithError:
    """A mean with its standard error."""
    return wb.document.ValueWithError(float(values.mean()), float(values.std(ddof=1) / np.sqrt(len(values))))


def worth_table(evidence: Evidence, metric: str) -> wb.document.ReportTable:
    """A metric by law and model in both motions, and its change from the true model."""
    word, unit, scale, text = TABLES[metric]
    rows: list[tuple[wb.document.Cell, ...]] = []
    for law in LAWS:
        for k, model in enumerate(MODELS):
            cells: list[wb.document.Cell] = [law if k == 0 else "", model]
            for motion in MOTIONS:
                trial, true = Trial(law, model, motion), Trial(law, "true", motion)
                cells.append(mean_and_error(scale * both(evidence.samples[trial], metric)))
                cells.append(None if model == "true" else percent(change(evidence, trial, true, metric)))
            rows.append(tuple(cells))
    columns = (
        wb.document.TableColumn("law"),
        wb.document.TableColumn("model"),
        *(
            column
            for motion in MOTIONS
            for column in (
                wb.document.TableColumn(f"{word}, {motion}", unit, "right"),
                wb.document.TableColumn("change", "%", "right"),
            )
        ),
    )
    notes = (f"{text} Change: from the true model, run by run, with half of its 95 % interval.",)
    caption = f"{word.capitalize()} on the true arm, by the model that a law has; the paper's motion and a faster one."
    return wb.document.ReportTable(f"worth_{word}", caption, columns, tuple(rows), notes)


def percent(one: Change) -> wb.document.ValueWithError:
    """A change in per cent with half of its interval."""
    return wb.document.ValueWithError(100 * one.value, 50 * (one.high - one.low))


def worth_figure(evidence: Evidence) -> wb.document.Figure:
    """The error of each law with each model."""
    panels = []
    for motion in MOTIONS:
        bars: list[wb.document.Mark] = []
        for i, law in enumerate(LAWS):
            trials = [Trial(law, model, motion) for model in MODELS]
            ends = np.array([1e3 * both(evidence.samples[trial], SETTLED).mean() for trial in trials])
            places = np.asarray(np.arange(len(MODELS)) + BESIDE * (i - 1), dtype=float)
            bars.append(wb.document.Bars(law, places, ends, np.zeros(len(ends)), style=i, thick=0.8 * BESIDE))
        panels.append(
            wb.document.Panel("model", tuple(bars), "error [mrad]", title=MOTION_WORDS[motion], ynames=MODELS)
        )
    caption = "The root mean square of both positions from 2 s on, on the true arm, by law and model."
    return wb.document.Figure("worth_of_models", caption, tuple(panels), columns=2)


def prediction_table(evidence: Evidence) -> wb.document.ReportTable:
    """The error that a fit predicts beside the one on the true arm."""
    rows: list[tuple[wb.document.Cell, ...]] = []
    for law in LAWS:
        for k, model in enumerate(MODELS[1:4]):
            cells: list[wb.document.Cell] = [law if k == 0 else "", model]
            for metric, scale in ((SETTLED, 1e3), (EFFORT, 1.0)):
                drawn = scale * both(evidence.samples[Trial(law, model, is_drawn=True)], metric)
                reached = scale * both(evidence.samples[Trial(law, model)], metric)
                low, high = np.quantile(drawn, (0.05, 0.95))
                span = f"{low:.4g} to {high:.4g}" if metric == SETTLED else f"{low:.3g} to {high:.3g}"
                cells += [float(drawn.mean()), span, float(reached.mean())]
            rows.append(tuple(cells))
    columns = (
        wb.document.TableColumn("law"),
        wb.document.TableColumn("log"),
        *(
            column
            for words, unit in (("error", "mrad"), ("torque", "N m"))
            for column in (
                number_column(f"{words}: predicted", unit, 4),
                wb.document.TableColumn("5 to 95 %", unit, "right"),
                number_column("true arm", unit, 4),
            )
        ),
    )
    notes = (
        "Means and quantiles over draws of the arm, the start and the noise; on the true arm, means over start and "
        "noise.",
    )
    return wb.document.ReportTable(
        "predictions", "What each log predicts of a law, and what the true arm shows.", columns, tuple(rows), notes
    )


def specification_section(evidence: Evidence) -> wb.Section:
    """The limits on the linear loop, on drawn arms."""
    words = (
        "The regulator LQR + model is linearised about the pose in which the arm hangs, with observer (10), on an arm "
        f"that slides. Its limits are checked on {ARMS} arms that a log allows, drawn by the factors of its fit, and "
        "by a search in the box of all intervals at 99.9 %. So a machine is refused or passed before it is run."
    )
    rows: list[tuple[wb.document.Cell, ...]] = []
    for one in all_checks(evidence):
        cells: list[wb.document.Cell] = []
        for i in range(len(SPECIFICATION.limits)):
            low, high = float(one.figures[:, i].min()), float(one.figures[:, i].max())
            text = f"{low:.3g}" if f"{low:.3g}" == f"{high:.3g}" else f"{low:.3g} to {high:.3g}"
            cells.append(text if one.holds[:, i].all() else wb.document.Strong(text))
        refuted = sum(kind == "refuted" for kind in one.in_box)
        rows.append((one.gains, one.arms, *cells, f"{refuted} of {len(one.in_box)}" if one.in_box else ""))
    columns = (
        wb.document.TableColumn("gains for"),
        wb.document.TableColumn("arms"),
        *(wb.document.TableColumn(limit_words(limit.words), align="right") for limit in SPECIFICATION.limits),
        wb.document.TableColumn("refuted in the box", align="right"),
    )
    notes = ("Least and largest figure of the arms. Bold: the limit fails on some arm.",)
    table = wb.document.ReportTable(
        "limits_on_arms", "The limits on the loop, on arms that the logs allow.", columns, tuple(rows), notes
    )
    return wb.Section("Limits checked on the arms that a log allows", (wb.Paragraph(words), table))

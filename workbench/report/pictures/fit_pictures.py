"""The page of a fit: what speaks against it, the estimates, the log beside the model, residuals and correlations."""

from __future__ import annotations

import numpy as np

from workbench.core.validation.refusals import Array, known_name
from workbench.core.validation.signatures import check_arguments
from workbench.identification.estimation.fit import Fit
from workbench.report.picture import Picture
from workbench.study.document.document import Block, Figure, Itemize, Panel, Paragraph, ReportTable, TableColumn
from workbench.study.document.figure import Series, Tiles

MEASURED, MODELLED = 1, 0  # styles
WIDEST = 12  # numbers in a picture of correlations
CLOSE = 0.95  # correlation beyond which an experiment hardly tells two numbers apart


@check_arguments
def fit_pictures(fit: Fit, name: str = "fit") -> tuple[Block, ...]:
    """The results of a fit as blocks for a section of a study; what speaks against the fit stands first.

    Parameters
    ----------
    fit
        The result of `wb.fit`.
    name
        The first part of the names of the figures and of the table.

    Examples
    --------
    >>> motor = wb.open_loop(wb.DCMotor())
    >>> t = np.linspace(0.0, 2.0, 101)
    >>> v = 12.0 * np.sign(np.sin(5.0 * t) + 0.1)
    >>> log = wb.Dataset.of(t, {"v": v, "omega": np.cumsum(v) / 400}, {"v": "V", "omega": "rad/s"})
    >>> found = wb.fit(motor, log, ["J", "R"])
    >>> [type(block).__name__ for block in wb.pictures.fit_pictures(found)]
    ['Paragraph', 'Itemize', 'ReportTable', 'Figure', 'Figure', 'Figure']
    """
    first = Paragraph(_verdict(fit))
    against = (Itemize(fit.warnings),) if fit.warnings else ()
    figures = [_outputs(fit, f"{name}_outputs"), _residuals(fit, f"{name}_residuals")]
    if len(fit.names) > 1:
        figures.append(_correlations(fit, f"{name}_correlations"))
    return (first, *against, _estimates(fit, f"{name}_estimates"), *figures)


@check_arguments
def draw_fit(fit: Fit, kind: str = "outputs") -> Picture:
    """The picture of a kind of a fit: "outputs", "residuals" or "correlations"."""
    return Picture(KINDS[known_name(kind, KINDS, "pictures of a fit")](fit, f"fit_{kind}"))


def _verdict(fit: Fit) -> str:
    """The misfit in a sentence, and how the hold-out compares."""
    unit = "times the noise that was stated" if fit.is_noise_known else "of the spread of the signal"
    parts = [f"{value:.3g} {unit} for '{signal}'" for signal, value in fit.misfit.items()]
    said = f"The root mean square of the residuals is {', '.join(parts)}."
    ratios = {signal: ratio for signal, ratio in fit.hold_out.items() if np.isfinite(ratio)}
    if ratios and not fit.is_exact:
        largest = max(ratios, key=lambda signal: ratios[signal])
        said += f" On the samples held out it is at most {ratios[largest]:.3g} times as large, for '{largest}'."
    return said


def _estimates(fit: Fit, name: str) -> ReportTable:
    intervals, errors = fit.intervals(), fit.standard_errors
    rows = []
    for number, value in zip(fit.model.numbers, fit.theta.tolist(), strict=True):
        low, high = intervals[number.name]
        rows.append((number.name, number.unit or "1", number.start, value, errors[number.name], low, high))
    columns = (
        TableColumn("number"),
        TableColumn("unit"),
        TableColumn("start", align="right"),
        TableColumn("estimate", align="right", digits=5),
        TableColumn("standard error", align="right", digits=2),
        TableColumn("from", align="right", digits=5),
        TableColumn("to", align="right", digits=5),
    )
    notes = (
        f"From and to: 95 % interval, for white noise that is {'stated' if fit.is_noise_known else 'estimated'}. "
        f"{fit.data.counts.sum():g} samples count. The search ended as {fit.certificate.reason}; "
        f"{fit.end.agreeing} of {fit.end.starts} searches ended in this minimum, reached by {fit.end.shooting}.",
    )
    return ReportTable(name, "Estimated numbers.", columns, tuple(rows), notes)


def _outputs(fit: Fit, name: str) -> Figure:
    """The log and the model over time, a panel for each sensor of each experiment."""
    panels = []
    for e, experiment in enumerate(fit.model.dataset):
        t = experiment.t - experiment.t[0]
        for j, (signal, _) in enumerate(fit.model.outputs):
            samples = fit.data.samples[e][:, j]
            seen, kept = fit.data.weighs[e][:, j], fit.held_out[e][:, j]
            model = Series("model", t, samples + fit.errors[e][:, j], MODELLED)
            marks = [Series("samples of the fit", t[seen], samples[seen], MEASURED, "marks")]
            if kept.any():
                marks.append(Series("samples held out", t[kept], samples[kept], MEASURED + 1, "marks"))
            lines = (float(t[kept][0]),) if kept.any() else ()
            panels.append(Panel(_label(fit, signal), (model, *marks), vlines=lines, title=_title(fit, experiment.name)))
    about = "The log and the model. Behind the thin line are the samples held out." if fit.held_out else "The log."
    return Figure(name, about, tuple(panels), columns=2 if len(panels) > 1 else 1)


def _residuals(fit: Fit, name: str) -> Figure:
    """The residuals over time, in standard deviations of the noise."""
    panels = []
    for e, experiment in enumerate(fit.model.dataset):
        t = experiment.t - experiment.t[0]
        for j, (signal, _) in enumerate(fit.model.outputs):
            error = fit.errors[e][:, j] / fit.end.sigma[j]
            marks = []
            for label, mask, style in (
                ("fit", fit.data.weighs[e][:, j], MODELLED),
                ("held out", fit.held_out[e][:, j], MEASURED + 1),
            ):
                if mask.any():
                    marks.append(Series(label, t[mask], error[mask], style, "marks"))
            title = _title(fit, experiment.name)
            panels.append(Panel(f"residual of {signal} [sd]", tuple(marks), hlines=(-2.0, 0.0, 2.0), title=title))
    about = (
        "Residuals, model minus sample, in standard deviations of the noise. Of white normal noise 95 % lie between "
        "the outer lines."
    )
    return Figure(name, about, tuple(panels), columns=2 if len(panels) > 1 else 1)


def _correlations(fit: Fit, name: str) -> Figure:
    """The correlations of the estimates as tiles."""
    most = min(WIDEST, len(fit.names))
    names, matrix = fit.names[:most], fit.correlation[:most, :most]
    texts = tuple(tuple(("",) if i < j else (f"{matrix[i, j]:.2f}",) for j in range(most)) for i in range(most))
    shades = np.where(np.tril(np.ones((most, most))) > 0, np.abs(matrix), np.nan)
    tiles = Tiles("", texts, shades)
    closest = _closest(fit.correlation)
    pair = f"{fit.names[closest[0]]} and {fit.names[closest[1]]}"
    value = fit.correlation[closest]
    about = f"Correlations of the estimates. The closest pair is {pair} with {value:.3f}"
    about += ": another experiment is needed to tell them apart well." if abs(value) > CLOSE else "."
    return Figure(name, about, (Panel("", (tiles,), xlabel="", xnames=names, ynames=names),), width=0.7)


def _closest(correlation: Array) -> tuple[int, int]:
    """The pair with the largest correlation."""
    off = np.abs(correlation - np.diag(np.diag(correlation)))
    i, j = np.unravel_index(int(np.argmax(off)), off.shape)
    return int(i), int(j)


def _label(fit: Fit, signal: str) -> str:
    labels, units = fit.model.dataset.signals.labels, [u for e in fit.model.dataset.signals.entries for u in e.units]
    unit = units[labels.index(signal)]
    return f"{signal} [{unit}]" if unit not in ("", "1", "?") else signal


def _title(fit: Fit, experiment: str) -> str:
    return experiment if len(fit.model.dataset.names) > 1 else ""


KINDS = {"outputs": _outputs, "residuals": _residuals, "correlations": _correlations}

"""The pictures of a fit: the log beside the model, its residuals, correlations, and profiles of the likelihood."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np

from workbench.core.validation.refusals import Array, known_name
from workbench.core.validation.signatures import check_arguments
from workbench.identification.datasets.experiment import Marks
from workbench.identification.estimation.fit import Fit
from workbench.identification.summaries.fit_summary import FitSummary
from workbench.identification.summaries.summary_parts import ExperimentSummary, NumberSummary, SensorSummary
from workbench.report.picture import Picture
from workbench.study.document.figure import Area, Figure, Panel, Series, Tiles
from workbench.study.document.phrases_and_tables import superscript_powers

MODELLED, MEASURED = 0, 1  # styles
WIDEST = 12  # numbers in a picture of correlations
CLOSE = 0.95  # correlation beyond which an experiment hardly tells two numbers apart
MOST_PANELS = 12  # of a figure: a page has no room for more
FEW = 600  # samples of which each is drawn
MANY = 120  # samples that are drawn as dots
FAR = 2.0  # ranges of a curve, beyond which a page does not move it
RIM = 0.06  # of the range of an axis, beyond its numbers
NO_UNIT = ("", "1", "?")


@check_arguments
def draw_fit(fit: Fit, kind: str = "outputs") -> Picture:
    """The picture of a kind of a fit: "outputs", "residuals" or "correlations"."""
    draw = KINDS[known_name(kind, KINDS, "pictures of a fit")]
    return Picture(draw(FitSummary.of(fit), f"fit_{kind}"))


def outputs_figure(fit: FitSummary, name: str) -> Figure:
    """The log and the model over time, a panel for each sensor of each experiment, with the hold-out shaded."""
    about = "The log and the model over time."
    if any(one.held_out.any() for one in fit.experiments):
        about += " The fit did not see the samples in the shaded part."

    def panel(one: ExperimentSummary, j: int, sensor: SensorSummary, title: str) -> Panel:
        used = one.weighs[:, j] | one.held_out[:, j]
        samples = Series("sample", one.t[used], one.samples[used, j], MEASURED, _look(used))
        model = Series("model", one.t, one.outputs[:, j], MODELLED)
        label = with_unit(sensor.name, sensor.unit)
        shade = _shade(one, j, _limits(one.samples[used, j], one.outputs[:, j], rim=FAR))
        return Panel(label, (model, samples, *shade), xlim=_span(one.t), title=title)  # whose ordinate may grow

    return _over_time(fit, name, about, panel)


def residuals_figure(fit: FitSummary, name: str) -> Figure:
    """The residuals over time, in standard deviations of the noise."""
    about = (
        "Residuals, model less sample, in standard deviations of the noise (sd). Of white normal noise 95 % lie "
        "between the outer lines."
    )

    def panel(one: ExperimentSummary, j: int, sensor: SensorSummary, title: str) -> Panel:
        used = one.weighs[:, j] | one.held_out[:, j]
        errors = (one.outputs - one.samples)[used, j] / sensor.noise
        limits = _limits(errors, np.array([-2.5, 2.5]))
        marks = Series("residual", one.t[used], errors, MODELLED, _look(used))
        lines = (-2.0, 0.0, 2.0)
        shade = _shade(one, j, limits)
        return Panel(f"{sensor.name} [sd]", (marks, *shade), xlim=_span(one.t), ylim=limits, title=title, hlines=lines)

    return _over_time(fit, name, about, panel)


def correlations_figure(fit: FitSummary, name: str) -> Figure:
    """The correlations of the estimates as tiles."""
    most = min(WIDEST, len(fit.names))
    names, matrix = fit.names[:most], fit.correlation[:most, :most]
    texts = tuple(tuple(("",) if i < j else (f"{matrix[i, j]:.2f}",) for j in range(most)) for i in range(most))
    shades = np.where(np.tril(np.ones((most, most))) > 0, np.abs(matrix), np.nan)
    about = "Correlations of the estimates."
    if len(fit.names) > 1:
        i, j = _closest(fit.correlation)
        value = fit.correlation[i, j]
        about += f" The closest pair is {fit.names[i]} and {fit.names[j]} with {value:.3f}"
        about += ": another experiment is needed to tell them apart well." if abs(value) > CLOSE else "."
    if most < len(fit.names):
        about += f" The first {most} of {len(fit.names)} numbers are drawn."
    tiles = Tiles("", texts, shades)
    return Figure(name, about, (Panel("", (tiles,), xlabel="", xnames=names, ynames=names),), width=0.7)


def profiles_figure(fit: FitSummary, name: str) -> Figure:
    """The profile likelihoods, each beside the parabola of its linear interval."""
    numbers = {number.name: number for number in fit.numbers}
    panels = []
    for profile in fit.profiles:
        number: NumberSummary = numbers[profile.name]
        parabola = profile.limit * ((profile.values - number.estimate) / _half(number)) ** 2
        top = 1.6 * profile.limit
        curves = (
            Series("profile", profile.values, np.where(profile.ratios <= 4 * top, profile.ratios, np.nan), MODELLED),
            Series("linear", profile.values, np.where(parabola <= 4 * top, parabola, np.nan), "aid"),
        )
        limits = (min(0.0, float(profile.ratios.min())) - RIM * top, top)
        label = with_unit(profile.name, profile.unit)
        ends = tuple(end for end in profile.interval if np.isfinite(end))
        panels.append(Panel("ratio", curves, xlabel=label, ylim=limits, hlines=(profile.limit,), vlines=ends))
    about = (
        "Profile of the log-likelihood ratio: one number is held, and all others are fitted again. The values below "
        "the line across are the interval, which ends at the upright lines. Dashed: if the outputs were linear in the "
        "numbers."
    )
    return Figure(name, about, tuple(panels), columns=min(2, len(panels)))


def with_unit(name: str, unit: str) -> str:
    """A name with its unit in brackets, if it has one."""
    return name if unit in NO_UNIT else f"{name} [{superscript_powers(unit)}]"


KINDS: dict[str, Callable[[FitSummary, str], Figure]] = {
    "outputs": outputs_figure,
    "residuals": residuals_figure,
    "correlations": correlations_figure,
}


def _over_time(
    fit: FitSummary, name: str, about: str, panel: Callable[[ExperimentSummary, int, SensorSummary, str], Panel]
) -> Figure:
    """A panel for each record that is drawn."""
    pairs, total = drawn_records(fit), len(_records(fit))
    if len(pairs) < total:
        about += f" The {len(pairs)} of {total} records with the largest residuals are drawn."
    if max(len(one.t) for one in fit.experiments) > FEW:
        about += " Of very many samples some are drawn."
    several, experiments = len(fit.experiments) > 1, fit.experiments
    panels = tuple(panel(experiments[e], j, fit.sensors[j], experiments[e].name if several else "") for e, j in pairs)
    return Figure(name, about, panels, columns=2 if len(panels) > 1 else 1)


def drawn_records(fit: FitSummary) -> list[tuple[int, int]]:
    """The experiment and the sensor of each panel over time: all, or if they are too many the worst."""
    pairs = _records(fit)
    if len(pairs) <= MOST_PANELS:
        return pairs
    sizes = []
    for e, j in pairs:
        one = fit.experiments[e]
        sizes.append(float(np.std((one.outputs - one.samples)[one.weighs[:, j], j])) / fit.sensors[j].noise)
    return [pairs[i] for i in sorted(np.argsort(sizes)[-MOST_PANELS:].tolist())]


def _records(fit: FitSummary) -> list[tuple[int, int]]:
    every = range(len(fit.sensors))
    return [(e, j) for e, one in enumerate(fit.experiments) for j in every if one.weighs[:, j].any()]


def _look(used: Marks) -> Literal["marks", "dots"]:
    return "dots" if used.sum() > MANY else "marks"


def _span(t: Array) -> tuple[float, float]:
    return float(t[0]), float(t[-1])


def _limits(*columns: Array, rim: float = RIM) -> tuple[float, float]:
    """The limits of an axis around all finite numbers of some columns, and a rim, as a share of their range."""
    numbers = np.concatenate(columns)
    numbers = numbers[np.isfinite(numbers)]
    low, high = (float(numbers.min()), float(numbers.max())) if numbers.size else (0.0, 1.0)
    beyond = rim * (high - low) or max(abs(low), 1.0) * rim
    return low - beyond, high + beyond


def _shade(one: ExperimentSummary, j: int, limits: tuple[float, float]) -> tuple[Area, ...]:
    """The part of a panel that was held out, from its first sample to its last."""
    times = one.t[one.held_out[:, j]]
    if not times.size:
        return ()
    corners = np.array([times[0], times[-1], times[-1], times[0]])
    return (Area("held out", corners, np.repeat(limits, 2)),)


def _half(number: NumberSummary) -> float:
    """The half width of the linear interval of a number; never zero, for a quotient."""
    return max((number.high - number.low) / 2, 1e-300)


def _closest(correlation: Array) -> tuple[int, int]:
    """The pair with the largest correlation."""
    off = np.abs(correlation - np.diag(np.diag(correlation)))
    i, j = np.unravel_index(int(np.argmax(off)), off.shape)
    return int(i), int(j)

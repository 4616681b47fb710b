"""Bode plots: gains in decibels and phases in degrees over decades of frequency, with margins and asymptotes."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.design.frequency import Crossover
from workbench.design.frequency.frequency_axis import phases
from workbench.report.loop_pictures.asymptotes import gain_asymptote, phase_asymptote
from workbench.report.loop_pictures.confidence_regions import confidence_bands, region_remarks
from workbench.report.loop_pictures.margin_words import margin_remarks, names_of_gains, names_of_phases
from workbench.study.document.figure import Figure, Guides, Label, Mark, Panel, Points, Series, Style
from workbench.study.document.frequency_curves import (
    FrequencyCurve,
    add_remarks,
    between,
    decibels,
    doubts,
    number,
    styles,
)
from workbench.study.document.gain_bounds import GainBound, shaded_bounds
from workbench.study.document.phrases_and_tables import Cell, Phrase, ReportTable, TableColumn

FREQUENCY = "frequency [rad/s]"
DECIBELS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 40.0, 60.0, 80.0, 100.0, 200.0, 400.0)
DEGREES = (1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 45.0, 90.0, 180.0, 360.0, 720.0, 1800.0, 3600.0)
NEAR = 30.0  # degrees above -180 from which on this line is drawn
DEEPEST = 160.0  # decibels below the highest gain, at which a panel ends
MARGIN = 0.06  # of a range


@check_arguments
def bode_figure(
    name: str,
    caption: Phrase,
    curves: Sequence[FrequencyCurve],
    asymptotes: bool = False,
    bounds: Sequence[GainBound] = (),
    ylabel: Label = "magnitude",
) -> Figure:
    """The gains and phases of one channel or several over frequency.

    Gain and phase margins are marked if a curve has them, and the caption states them. Lines mark -180 degrees and, for
    a loop in a computer, Nyquist's frequency. With `asymptotes`, they are drawn for curves that have `corners`.
    `bounds` shade regions that gains must not reach. For curves with a `source`, margins are marked but not stated in
    the caption.

    Raises
    ------
    ValueError
        If there is no curve, none has a frequency above zero, or asymptotes are wanted for a sampled curve.
    """
    check_curves("bode_figure", curves)
    gains, turns = _marks(curves, asymptotes)
    panels = _gain_panel(curves, [*gains, *shaded_bounds(bounds)], ylabel), _phase_panel(curves, turns)
    still = [one for one in curves if one.source is None]
    remarks = [
        *margin_remarks(still, len(curves) > 1),
        *(said for one in still for said in doubts(one, len(curves) > 1)),
    ]
    remarks += region_remarks(curves, "The bands have")
    if asymptotes and any(one.corners is not None for one in curves):
        remarks.append("Dashed: asymptotes.")
    return Figure(name, add_remarks(caption, remarks), panels, 1, numbers_of_curves(name, caption, curves))


def _marks(curves: Sequence[FrequencyCurve], asymptotes: bool) -> tuple[list[Mark], list[Mark]]:
    """The marks of both panels: the curves, then their margins and their asymptotes."""
    gains, turns = confidence_bands(curves)
    own = styles(curves)
    for one, style in zip(curves, own, strict=True):
        omega, values = one.logarithmic
        gains.append(Series(one.label, omega, decibels(values), style, sources=one.sources("magnitude")))
        turns.append(Series(one.label, omega, phases(omega, values), style, sources=one.sources("phase")))
    for one, style in zip(curves, own, strict=True):
        gains += _gain_margins(one, style, len(curves) == 1)
        turns += _phase_margins(one, style, len(curves) == 1)
        if asymptotes and one.corners is not None:
            gains.append(gain_asymptote(one))
            turns.append(phase_asymptote(one))
    return gains, turns


def _gain_panel(curves: Sequence[FrequencyCurve], marks: Sequence[Mark], ylabel: Label) -> Panel:
    limits = limits_of([decibels(one.logarithmic[1]) for one in curves], [*_heights(marks), 0.0], DEEPEST)
    return Panel(
        magnitude(ylabel, curves),
        (*marks, *named_lines(curves, limits)),
        FREQUENCY,
        frequency_limits(curves),
        limits,
        "log",
        hlines=(0.0,) if limits[0] < 0 < limits[1] else (),
        vlines=nyquist_lines(curves),
        ysteps=DECIBELS,
        aspect="wide",
    )


def _phase_panel(curves: Sequence[FrequencyCurve], marks: Sequence[Mark]) -> Panel:
    limits = limits_of([phases(*one.logarithmic) for one in curves], _heights(marks), np.inf)
    half = _half_turns(curves, limits)
    return Panel(
        "phase [degrees]",
        tuple(marks),
        FREQUENCY,
        frequency_limits(curves),
        limits_of([np.array(limits)], half, np.inf, 0.03 if half else 0.0),
        "log",
        hlines=half,
        vlines=nyquist_lines(curves),
        ysteps=DEGREES,
        aspect="wide",
    )


def check_curves(call: str, curves: Sequence[FrequencyCurve], zeros: bool = False) -> None:
    """Refuse no curves, and one without two frequencies above zero or without an answer, or with no other than zero."""
    if not curves:
        raise ValueError(f"`{call}(curves=...)` must have at least one curve; got none.")
    for one in curves:
        omega, values = one.logarithmic
        if len(omega) < 2 or not (np.isfinite(values) & (zeros | (values != 0))).any():
            answer = "is no gap" if zeros else "is neither zero nor a gap"
            raise ValueError(
                f"`{call}(curves=...)` must have two or more frequencies above zero and an answer that {answer}; the "
                f"curve '{one.label}' has none."
            )


def frequency_limits(curves: Sequence[FrequencyCurve]) -> tuple[float, float]:
    """The ends of an axis of frequencies: those of the curves, and a little more than Nyquist's frequency."""
    low = min(float(one.logarithmic[0][0]) for one in curves)
    high = max(float(one.logarithmic[0][-1]) for one in curves)
    tops = nyquist_lines(curves)
    return low, max(high, *(1.6 * top for top in tops)) if tops else high


def nyquist_lines(curves: Sequence[FrequencyCurve]) -> tuple[float, ...]:
    """Nyquist's frequency pi / period of each sampled curve, in rad/s, each once."""
    return tuple(dict.fromkeys(math.pi / one.period for one in curves if one.period is not None))


def named_lines(curves: Sequence[FrequencyCurve], limits: tuple[float, float]) -> list[Guides]:
    """The names of the lines at Nyquist's frequencies."""
    lines = tuple((np.array([top, top]), np.array(limits)) for top in nyquist_lines(curves))
    names = tuple(f"Nyquist, {number(top)} rad/s" for top in nyquist_lines(curves))
    return [Guides(lines, names)] if lines else []


def limits_of(
    curves: Sequence[Array], others: Sequence[float], deepest: float, margin: float = MARGIN
) -> tuple[float, float]:
    """The ends of an axis around curves and other numbers, not deeper than so much below the highest."""
    held = np.concatenate([*curves, np.asarray(others, dtype=float)])
    held = held[np.isfinite(held)]
    high = float(held.max())
    low = max(float(held.min()), high - deepest)
    reach = max(high - low, 1e-3 * max(1.0, abs(high)))
    return low - margin * reach, high + margin * reach


def magnitude(ylabel: Label, curves: Sequence[FrequencyCurve]) -> Label:
    """The label of gains in decibels, with the unit that they all share."""
    units = {one.unit for one in curves}
    unit = units.pop() if len(units) == 1 else ""
    own = ylabel if isinstance(ylabel, tuple) else (ylabel,)
    return (*own, f" [dB of {unit}]" if unit not in ("", "1") else " [dB]")


def numbers_of_curves(name: str, caption: Phrase, curves: Sequence[FrequencyCurve]) -> ReportTable | None:
    """The answers of all curves as a table; None if their sources say in a file of their marks what these are."""
    if all(one.source is not None for one in curves):
        return None
    rows: list[tuple[Cell, ...]] = []
    for one in curves:
        omega, values = one.logarithmic
        columns = (omega, decibels(values), phases(omega, values), values.real, values.imag)
        rows += [(one.label, *(_known(x) for x in row)) for row in zip(*columns, strict=True)]
    heads = (
        TableColumn("curve"),
        TableColumn("frequency", "rad/s"),
        TableColumn("magnitude", "dB"),
        TableColumn("phase", "degrees"),
    )
    return ReportTable(name, caption, (*heads, TableColumn("real part"), TableColumn("imaginary part")), tuple(rows))


def _known(value: float) -> float | None:
    return None if math.isnan(value) else float(value)


def _heights(marks: Sequence[Mark]) -> list[float]:
    """The ordinates of points, which a panel must hold."""
    return [float(y) for mark in marks if isinstance(mark, Points) for y in mark.y]


def _half_turns(curves: Sequence[FrequencyCurve], limits: tuple[float, float]) -> tuple[float, ...]:
    """The odd multiples of 180 degrees near the phases, and -180 itself for a loop with margins."""
    low, high = limits[0] - NEAR, limits[1] + NEAR
    first, last = math.ceil((low - 180) / 360), math.floor((high - 180) / 360)
    held = {360.0 * k + 180.0 for k in range(first, last + 1)}
    if any(one.margins is not None for one in curves):
        held.add(-180.0)
    return tuple(sorted(held - {180.0} if high < 180 + NEAR else held)) if len(held) <= 9 else (-180.0,)


def _inside(one: FrequencyCurve, rows: Sequence[Crossover]) -> list[Crossover]:
    """The crossovers within the frequencies of a curve."""
    omega, _ = one.logarithmic
    return [row for row in rows if omega[0] <= row.frequency.value <= omega[-1]]


def _gain_margins(one: FrequencyCurve, style: Style, named: bool) -> list[Mark]:
    """A dashed line from 0 dB to the gain at each phase crossover, and a point there."""
    rows = [] if one.margins is None else _inside(one, one.margins.phase_crossovers)
    at = np.array([row.frequency.value for row in rows])
    gains = np.array([-20 * math.log10(row.margin.value) for row in rows])
    names = names_of_gains(one.margins, rows) if named and one.margins is not None and one.source is None else ()
    return _dropped(one, "gain margins", (at, gains, np.zeros(len(at))), names, style)


def _phase_margins(one: FrequencyCurve, style: Style, named: bool) -> list[Mark]:
    """A dashed line from -180 degrees to the phase at each gain crossover, and a point there."""
    rows = [] if one.margins is None else _inside(one, one.margins.gain_crossovers)
    omega, values = one.logarithmic
    turned, at = phases(omega, values), np.array([row.frequency.value for row in rows])
    margins = np.array([row.margin.value for row in rows])
    drawn = np.array([between(omega, turned, w) for w in at.tolist()]) - margins
    base = 360 * np.round((drawn + 180) / 360) - 180
    names = names_of_phases(one.margins, rows) if named and one.margins is not None and one.source is None else ()
    return _dropped(one, "phase margins", (at, base + margins, base), names, style)


def _dropped(
    one: FrequencyCurve, kind: str, ends: tuple[Array, Array, Array], names: tuple[Label, ...], style: Style
) -> list[Mark]:
    """Dashed lines at x from their bases to y, with points there; of a curve with a source even if there are none."""
    x, y, base = ends
    held = np.isfinite(y)
    x, y, base = x[held], y[held], base[held]
    if not x.size:
        if one.source is None:
            return []
        x, y, base = one.logarithmic[0][:1], np.array([np.nan]), np.array([np.nan])
    names = tuple(name for name, there in zip(names, held, strict=True) if there) if names else ()
    across, up = np.repeat(x, 3), np.column_stack([base, y, np.full(len(x), np.nan)]).ravel()
    shown = one.sources(kind)
    points = Points("", x, y, names, style, sources=() if shown is None else (shown,) * len(x))
    return [Series("", across, up, "aid", sources=shown), points]

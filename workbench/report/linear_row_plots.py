"""The pictures of many rows of a linear loop: envelopes over the draws of a sweep, with the worst draw by its name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from workbench.core.validation.refusals import Array, Integers, known_name, one_of, refusal
from workbench.core.validation.signatures import check_arguments
from workbench.design.frequency import hinf_norm
from workbench.design.linear_loop import LinearRows
from workbench.design.linear_loop.frequency_answers import CutModels
from workbench.design.linear_loop.loop_channels import channel_models, loop_frequencies
from workbench.report.linear_row_responses import row_steps
from workbench.report.loop_pictures import Envelope, bode_envelope, envelope_figure
from workbench.report.loop_pictures.pole_maps import grid_remarks, root_panel
from workbench.report.picture import Picture, known_options
from workbench.study.document.figure import Figure, Mark, Points, Series
from workbench.study.document.frequency_curves import Complex, number
from workbench.study.document.gain_bounds import GainBound

CALL = "LinearRows.plot"
LOOKED_AT = 16  # rows whose roots fix the range of frequencies
FREQUENCIES = 400
MAX_POLES = 600  # poles
MAX_VALUES = 3  # values of a row that are printed beside its number


class WorstRow(NamedTuple):
    """The place of the worst row, and its name with what makes it the worst."""

    row: int
    name: str


def draw_rows(rows: LinearRows, kind: str = "", **options: object) -> Picture:
    """The picture of a kind of rows; by default a Bode plot, or of several channels the largest gain of S."""
    if not isinstance(rows, LinearRows):
        raise refusal(f"{CALL}(rows)", "one `LinearRows`", rows)
    one_of(f"{CALL}(kind)", kind, ("", *KINDS))
    made = KINDS[kind or ("bode" if len(rows.models.channels) == 1 else "sensitivity")]
    return made(rows, **known_options(f"{CALL}({repr(kind) * bool(kind)})", made, options))


@check_arguments
def bode(
    rows: LinearRows,
    frequencies: Array | None = None,
    at: str | None = None,
    of: str = "L",
    inputs: str | None = None,
    outputs: str | None = None,
    bounds: tuple[GainBound, ...] = (),
) -> Picture:
    """The Bode plots of the rows, at one channel of the cut while the loop is closed at the others, or of an answer."""
    chosen = replace(rows, models=_cut_at(rows, at))
    omega = _frequencies(rows) if frequencies is None else frequencies
    found = chosen.response(omega, of, inputs, outputs)
    if found.values.shape[2:] != (1, 1):
        raise ValueError(
            f"`{CALL}('bode')` draws one answer; there are {len(found.outputs)} x {len(found.inputs)}: name a channel "
            f"by `at`, or one of the inputs, {', '.join(found.inputs)}, and outputs, {', '.join(found.outputs)}."
        )
    worst = worst_row(rows, omega)
    above = omega > 0
    draws = Envelope(omega[above], found.values[:, above, 0, 0], worst.row, worst.name)
    words = f"{of} at {found.inputs[0]}" if of in ("L", "S", "T") else f"{found.outputs[0]} from {found.inputs[0]}"
    return Picture(bode_envelope("bode", f"{words}.", draws, rows.models.closed_model.period, bounds))


@check_arguments
def sensitivity(rows: LinearRows, frequencies: Array | None = None, bounds: tuple[GainBound, ...] = ()) -> Picture:
    """The largest singular value of S at all channels of the cut at once, of each row over frequency."""
    omega = _frequencies(rows) if frequencies is None else frequencies
    above, worst = omega > 0, worst_row(rows, omega)
    sizes = _largest_gains(rows, omega)[:, above]
    figure = bode_envelope(
        "sensitivity",
        "",
        Envelope(omega[above], sizes.astype(complex), worst.row, worst.name),
        rows.models.closed_model.period,
        bounds,
    )
    panel = replace(figure.panels[0], ylabel="|S| [dB]" if len(rows.models.channels) == 1 else "largest gain of S [dB]")
    return Picture(replace(figure, panels=(panel,)))


@check_arguments
def step(
    rows: LinearRows, until: float | None = None, inputs: str | None = None, outputs: str | None = None
) -> Picture:
    """The responses of one output to a step of one input, of each row that is stable."""
    t, values, names = row_steps(rows, until, inputs, outputs)
    worst, lost = worst_row(rows, _frequencies(rows)), int((~rows.stable & ~rows.flagged_rows).sum())
    said = [f"Step of 1 at {names[0]}."]
    if lost:
        said.append(f"Not stable, and not drawn: {lost} row{'s' if lost > 1 else ''}.")
    draws = Envelope(t, values.astype(complex), worst.row, worst.name)
    return Picture(envelope_figure("step", " ".join(said), draws, "time [s]", names[1], names[2]))


@check_arguments
def poles(rows: LinearRows, grid: bool = True) -> Picture:
    """The poles of the closed loops of the rows, as dots, and those of the worst, as crosses."""
    worst = worst_row(rows, _frequencies(rows))
    sound = np.flatnonzero(~rows.flagged_rows)
    shown = _some(rows.poles[sound])
    held, own = rows.poles[sound[shown]].ravel(), rows.poles[worst.row]
    marks: list[Mark] = [
        Points(f"worst: {worst.name}", own.real, own.imag, (), 1, shape="pole"),
        Series("all draws", held.real, held.imag, 0, "marks"),
    ]
    period = rows.models.closed_model.period and rows.models.closed_model.period * rows.models.closed_model.count
    panel = root_panel(marks, np.concatenate([held, own]), period, grid)
    said = [f"The poles of {len(sound)} rows."]
    if len(shown) < len(sound):
        said.append(f"{len(shown)} of them are drawn, the rows with the most extreme poles among these.")
    if rows.reasons:
        said.append(f"Rows without an answer, which are left out: {len(rows.reasons)}.")
    said.append(f"The worst is {worst.name}.")
    return Picture(Figure("poles", " ".join([*said, *map(str, grid_remarks(period) if grid else [])]), (panel,)))


KINDS: dict[str, Callable[..., Picture]] = {"bode": bode, "sensitivity": sensitivity, "step": step, "poles": poles}


def worst_row(rows: LinearRows, omega: Array) -> WorstRow:
    """The row that grows fastest, if one is not stable; else the one with the largest peak of S at the frequencies.

    The peak of the worst row is then enclosed by `hinf_norm`, where that has an answer.
    """
    late = bool(rows.models.delays.any())
    if not late:
        lost = np.flatnonzero(~rows.stable & ~rows.flagged_rows)
        if lost.size:
            values = rows.poles[lost]
            growth = values.real if rows.models.closed_model.period is None else np.abs(values)
            row = int(lost[int(growth.max(axis=1).argmax())])
            return WorstRow(row, f"{_name(rows, row)}, not stable")
    peaks = np.nan_to_num(_largest_gains(rows, omega), nan=-np.inf).max(axis=1)
    row = int(peaks.argmax())
    words = "Ms" if len(rows.models.channels) == 1 else "largest gain of S"
    peak = float(peaks[row])
    if not late and rows.models.closed_model.count == 1:
        try:
            peak = hinf_norm(row_models(rows.models, row).kind(CALL, "S").system()).gain.value
        except ValueError:
            words = f"{words} on the grid"
    else:
        words = f"{words} on the grid"
    return WorstRow(row, f"{_name(rows, row)}, {words} {number(peak)}")


def row_models(models: CutModels, row: int) -> CutModels:
    """The models of one row."""
    opened = None if models.open_model is None else models.open_model.row(row)
    return replace(models, closed_model=models.closed_model.row(row), open_model=opened)


def _name(rows: LinearRows, row: int) -> str:
    held = [f"{name} = {number(float(column[row]))}" for name, column in rows.varied_values.items()][:MAX_VALUES]
    return f"row {row} ({', '.join(held)})" if held else f"row {row}"


def _largest_gains(rows: LinearRows, omega: Array) -> Array:
    """The largest singular value (N, m) of S at all channels of the cut; NaN in rows without an answer."""
    values = rows.response(omega, "S").values
    if values.shape[-1] == 1:
        return np.asarray(np.abs(values[:, :, 0, 0]))
    sizes, sound = np.full(values.shape[:2], np.nan), np.isfinite(values).all(axis=(2, 3))
    sizes[sound] = np.linalg.norm(values[sound], 2, axis=(1, 2))
    return sizes


def _frequencies(rows: LinearRows) -> Array:
    """Frequencies in rad/s that show the rows: the range of those that show some of them."""
    sound = np.flatnonzero(~rows.flagged_rows)
    some = sound[np.unique(np.linspace(0, len(sound) - 1, LOOKED_AT).astype(int))]
    held = [loop_frequencies(CALL, row_models(rows.models, int(row))) for row in some]
    low, high = min(float(one[0]) for one in held), max(float(one[-1]) for one in held)
    return np.geomspace(low, high, FREQUENCIES)


def _cut_at(rows: LinearRows, at: str | None) -> CutModels:
    """The models cut at one of the channels by its name."""
    if at is None:
        return rows.models
    names = [rows.point.equations.drive[k] for k in rows.models.channels]
    known_name(at, names, "channels of this cut")
    return channel_models(rows.models, names.index(at))


def _some(values: Complex) -> Integers:
    """The places of rows of poles (N, nx) that are drawn: all, or some with the extremes of each part among them."""
    count = max(1, MAX_POLES // max(1, values.shape[1]))
    if len(values) <= count:
        return np.arange(len(values))
    parts = [values.real, values.imag, np.abs(values)]
    ends = [int(end(part.max(axis=1))) for part in parts for end in (np.argmax, np.argmin)]
    return np.unique([*np.linspace(0, len(values) - 1, count).astype(int), *ends])

"""Step and impulse responses over time, with the figures of a step: rise, overshoot, settling and final value."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array, finite, numbers, refusal, seconds
from workbench.core.validation.signatures import check_arguments
from workbench.design.step_response import StepInfo
from workbench.study.document.figure import STYLES, Band, Figure, Label, Mark, Panel, Points, Series, Style
from workbench.study.document.frequency_curves import add_remarks, number
from workbench.study.document.phrases_and_tables import Phrase, superscript_powers

SETTLING_BAND = 0.02  # of the step: the band of the settling time
RISE = (0.1, 0.9)  # of the step: the ends of the rise time


@dataclass(frozen=True, eq=False)
@check_arguments
class TimeResponse:
    """A response y (N,) at times t (N,) in s to a step or an impulse at the first of them; a NaN is a gap.

    `final` is the value to which the response tends; None if it is not known or not finite. For a loop in a computer,
    with its `period` in s, the values are those at its instants. Rise time and overshoot come from `info`, as
    `wb.step_info` gives it for the response of a linear system from zero, or else from lines between the samples.
    """

    label: Label
    t: Array
    y: Array
    final: float | None = None
    unit: str = ""
    period: float | None = None
    style: Style | None = None
    info: StepInfo | None = None

    def __post_init__(self) -> None:
        t, y = (numbers(f"TimeResponse({name}=...)", getattr(self, name), 1) for name in ("t", "y"))
        if len(t) < 2 or not np.isfinite(t).all() or (np.diff(t) <= 0).any():
            raise refusal("TimeResponse(t=...)", "two or more finite times in rising order", self.t)
        if y.shape != t.shape or np.isinf(y).any():
            raise refusal("TimeResponse(y=...)", f"a number, or NaN for a gap, at each of {len(t)} times", self.y)
        if self.final is not None:
            finite("TimeResponse(final=...)", self.final)
        if self.period is not None:
            seconds("TimeResponse(period=...)", self.period)
        object.__setattr__(self, "t", t)
        object.__setattr__(self, "y", y)


@dataclass(frozen=True)
@show
class SampledStepInfo:
    """Rise time and the like of a sampled step response, times in s from the step on; NaN if a level is not reached.

    `rise_time` is the time from 10 % to 90 % of the step. After `settling_time` the response stays within 2 % of the
    step about its final value. `overshoot` is the excess over the final value, in % of the step. `peak` is the value
    farthest in the direction of the step, at `peak_time`.
    """

    rise_time: float
    settling_time: float
    overshoot: float
    peak: float
    peak_time: float
    final: float


@check_arguments
def sampled_step_info(t: Array, y: Array, final: float, band: float = SETTLING_BAND) -> SampledStepInfo:
    """Rise time and the like of a response y (N,) at times t (N,) in s to a step at the first of them, from rest at
    y[0].

    Crossings are found on the straight lines between the samples. `final` is the value to which the response tends, and
    `band` the half-width of the settling band as a share of the step. A response that is outside the band at the last
    time has no settling time.

    Raises
    ------
    ValueError
        If the step is zero: the response ends where it begins.

    Examples
    --------
    >>> from workbench.report.loop_pictures import sampled_step_info
    >>> sampled_step_info([0.0, 1.0, 2.0, 3.0], [0.0, 0.5, 1.2, 1.0], 1.0, 0.02)
    SampledStepInfo(rise_time=1.37143, settling_time=2.9, overshoot=20, peak=1.2, peak_time=2, final=1)
    """
    one = TimeResponse("", t, y)
    t, y, start = one.t, one.y, float(one.y[0])
    size = finite("sampled_step_info(final=...)", final) - start
    if not np.isfinite(y).all() or not (size and math.isfinite(size)):
        raise ValueError(
            "`sampled_step_info(t, y, final)` needs a response without gaps, whose final value is not that at the "
            f"first time; got a step of {size:g}."
        )
    finite("sampled_step_info(band=...)", band, " of the step", low=0)
    share = (np.asarray(y) - start) / size
    low, high = (_first_above(t, share, level) for level in RISE)
    outside = np.flatnonzero(np.abs(share - 1) > band)
    k = int(outside[-1]) if outside.size else -1
    settling = math.nan
    if k < 0:
        settling = 0.0
    elif k + 1 < len(t):
        edge = 1 + band if share[k] > 1 else 1 - band
        part = (edge - share[k]) / (share[k + 1] - share[k])
        settling = float(t[k] + part * (t[k + 1] - t[k]) - t[0])
    top = int(np.argmax(share))
    return SampledStepInfo(
        high - low, settling, max(0.0, 100 * (float(share[top]) - 1)), float(y[top]), float(t[top] - t[0]), final
    )


def _rounded(info: StepInfo) -> SampledStepInfo:
    """The figures of a linear system, without their bounds; the peak is that on the side of the final value."""
    final, overshoot = info.final.value, info.overshoot.value
    inverse = info.undershoot.value > 100 + overshoot  # then `peak` is on the other side
    times = info.rise_time.value, info.settling_time.value
    return SampledStepInfo(
        *times, overshoot, final * (1 + overshoot / 100), math.nan if inverse else info.peak_time.value, final
    )


def _first_above(t: Array, share: Array, level: float) -> float:
    """The time, from the first one on, at which a response first reaches a level."""
    k = int(np.argmax(share >= level))
    if share[k] < level:
        return math.nan
    if k == 0:
        return 0.0
    part = (level - share[k - 1]) / (share[k] - share[k - 1])
    return float(t[k - 1] + part * (t[k] - t[k - 1]) - t[0])


@check_arguments
def step_figure(name: str, caption: Phrase, responses: Sequence[TimeResponse], ylabel: Label = "response") -> Figure:
    """Step responses over time, with rise time, overshoot and settling time if a final value is known.

    For one response the peak, the rise and the settling are marked, with a band of 2 % of the step about the final
    value. For several responses the caption states these numbers.

    Raises
    ------
    ValueError
        If there is no response, or the final value of one is its first value, so that there is no step.
    """
    marks, remarks = _curves("step_figure", responses), []
    for k, one in enumerate(responses):
        if one.final is None or not np.isfinite(one.y).all():
            continue
        info = sampled_step_info(one.t, one.y, one.final) if one.info is None else _rounded(one.info)
        remarks.append(_sentence(one, info, len(responses) > 1))
        if len(responses) == 1:
            marks += _marked(one, info, k)
    return _figure(name, add_remarks(caption, remarks), responses, marks, ylabel)


@check_arguments
def impulse_figure(name: str, caption: Phrase, responses: Sequence[TimeResponse], ylabel: Label = "response") -> Figure:
    """Impulse responses over time.

    Raises
    ------
    ValueError
        If there is no response.

    Examples
    --------
    >>> from workbench.report.loop_pictures import TimeResponse, impulse_figure
    >>> impulse_figure("pulse", "After a pulse", [TimeResponse("y", [0.0, 1.0, 2.0], [1.0, 0.4, 0.1], 0.0)], "y").name
    'pulse'
    """
    return _figure(name, caption, responses, _curves("impulse_figure", responses), ylabel)


def _curves(call: str, responses: Sequence[TimeResponse]) -> list[Mark]:
    if not responses:
        raise ValueError(f"`{call}(responses=...)` must have at least one response; got none.")
    return [
        Series(one.label, one.t, one.y, _style(one, k), "line" if one.period is None else "steps")
        for k, one in enumerate(responses)
    ]


def _style(one: TimeResponse, k: int) -> Style:
    return k % STYLES if one.style is None else one.style


def _figure(
    name: str, caption: Phrase, responses: Sequence[TimeResponse], marks: Sequence[Mark], ylabel: Label
) -> Figure:
    units = {one.unit for one in responses}
    unit = units.pop() if len(units) == 1 else ""
    own = ylabel if isinstance(ylabel, tuple) else (ylabel,)
    label = (*own, f" [{superscript_powers(unit)}]") if unit not in ("", "1") else own
    ends = min(float(one.t[0]) for one in responses), max(float(one.t[-1]) for one in responses)
    return Figure(name, caption, (Panel(label, tuple(marks), xlim=ends),))


def _marked(one: TimeResponse, info: SampledStepInfo, k: int) -> list[Mark]:
    """The band about the final value, the rise, the peak and the settling."""
    start = float(one.y[0]) if one.info is None else 0.0
    step, ends = info.final - start, one.t[[0, -1]]
    edges = sorted((info.final - SETTLING_BAND * step, info.final + SETTLING_BAND * step))
    marks: list[Mark] = [
        Series("final value", ends, np.full(2, info.final), "bound"),
        Band("2 % of the step", ends, np.full(2, edges[0]), np.full(2, edges[1]), "reference"),
    ]
    at = float(one.t[0])
    points: list[tuple[float, float, str]] = []
    rise = _first_above(one.t, (one.y - start) / step, RISE[1])
    if math.isfinite(info.rise_time + rise):
        points.append((at + rise, start + RISE[1] * step, f"rise time {number(info.rise_time)} s"))
    if info.overshoot > 0 and at + info.peak_time <= one.t[-1]:
        points.append((at + info.peak_time, info.peak, f"overshoot {number(info.overshoot)} %"))
    if info.settling_time > 0 and at + info.settling_time <= one.t[-1]:
        y = float(np.interp(at + info.settling_time, one.t, one.y))
        points.append((at + info.settling_time, y, f"settling time {number(info.settling_time)} s"))
    if points:
        x, y_of, names = zip(*points, strict=True)
        marks.append(Points("", np.array(x), np.array(y_of), names, _style(one, k)))
    return marks


def _sentence(one: TimeResponse, info: SampledStepInfo, several: bool) -> Phrase:
    label = one.label if isinstance(one.label, tuple) else (one.label,)
    parts = [
        f"rise time {number(info.rise_time)} s" if math.isfinite(info.rise_time) else "no rise within these times",
        f"overshoot {number(info.overshoot)} %",
        f"settling time {number(info.settling_time)} s"
        if math.isfinite(info.settling_time)
        else "not settled within these times",
        f"final value {number(info.final)}",
    ]
    said = ", ".join(parts)
    return (*label, ": ", f"{said}.") if several else f"{said[0].upper()}{said[1:]}."

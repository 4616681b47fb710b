"""Pictures of systems of python-control in one call: Bode, Nyquist, Nichols, poles and zeros, root locus, steps."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from workbench.design.frequency import StabilityMargins, stability_margins
from workbench.design.linear.system_answers import (
    feedback_poles,
    lti,
    period_of,
    step_answers,
    system_answers,
    system_roots,
)
from workbench.design.matrices import Refused
from workbench.design.step_response import exact_figures
from workbench.report.picture import Picture
from workbench.study.loop_pictures import (
    Corners,
    FrequencyCurve,
    FrequencyMatrix,
    GainBound,
    PoleZeroSet,
    TimeResponse,
    bode_figure,
    nichols_figure,
    nyquist_figure,
    root_locus_figure,
    singular_value_figure,
    step_figure,
)
from workbench.study.loop_pictures import pole_zero_map as pole_zero_figure
from workbench.validation.refusals import Array, numbers, refusal
from workbench.validation.signatures import door

GAINS = np.concatenate([[0.0], np.geomspace(1e-3, 1e3, 800)])  # of a root locus
ON_AXIS = 1e-8  # relative: a pole nearer to the axis is none of the unstable ones


@door
def bode(
    systems: Any,
    frequencies: Array | None = None,
    margins: bool = False,
    asymptotes: bool = False,
    bounds: tuple[GainBound, ...] = (),
) -> Picture:
    """The Bode plot of a system with one channel, of several by their names, or of answers, a `FrequencyCurve`.

    Parameters
    ----------
    systems
        A `StateSpace` or `TransferFunction` of python-control, a `FrequencyCurve`, or a mapping from names to such.
    frequencies
        (m,) in rad/s, in rising order; by default what shows the poles and zeros.
    margins
        True for loop gains L of negative feedback: certified margins are marked and told.
    asymptotes, bounds
        As of `bode_figure`.

    Raises
    ------
    ValueError
        If a system has several channels (take `singular_values`) or is none, or the frequencies do not rise.

    Examples
    --------
    >>> import control
    >>> picture = wb.bode(control.tf([4], [1, 3, 3, 1]), margins=True)
    >>> picture.caption
    'Gain margin 6.02 dB upwards, phase margin 27.1 degrees, delay margin 0.384 s, Ms 3, disk margin 0.378.'
    """
    curves, refused = _curves("bode", systems, frequencies, margins, asymptotes)
    return Picture(bode_figure("bode", refused, curves, asymptotes, bounds))


@door
def nyquist(
    systems: Any, frequencies: Array | None = None, margins: bool = True, reach: float | None = None
) -> Picture:
    """The Nyquist plot of a loop gain L with one channel, of several by their names, or of a `FrequencyCurve`.

    Turns about -1 are counted, and with the unstable poles of a single L those of the closed loop are told. Systems,
    frequencies and margins are as of `bode`; the curve is cut at the distance `reach` from zero.

    Raises
    ------
    ValueError
        As of `bode`.

    Examples
    --------
    >>> import control
    >>> picture = wb.nyquist(control.tf([2, 6], [1, 0, -1]))
    >>> picture.caption.split(". ")[0]
    'The closed curve encircles −1 once, anticlockwise'
    """
    held = _named(systems)
    curves, refused = _curves("nyquist", systems, frequencies, margins)
    unstable = None
    if len(held) == 1 and not isinstance(held[0][1], FrequencyCurve):
        unstable = _unstable_poles(held[0][1])
    return Picture(nyquist_figure("nyquist", refused, curves, unstable, reach=reach))


@door
def nichols(systems: Any, frequencies: Array | None = None, margins: bool = True) -> Picture:
    """The Nichols plot of a loop gain L with one channel, of several by their names, or of a `FrequencyCurve`.

    Systems, frequencies and margins are as of `bode`.

    Raises
    ------
    ValueError
        As of `bode`.

    Examples
    --------
    >>> import control
    >>> wb.nichols(control.tf([4], [1, 3, 3, 1])).figure.name
    'nichols'
    """
    curves, refused = _curves("nichols", systems, frequencies, margins)
    return Picture(nichols_figure("nichols", refused, curves))


@door
def singular_values(systems: Any, frequencies: Array | None = None, bounds: tuple[GainBound, ...] = ()) -> Picture:
    """The singular values over frequency of a system with several channels, or of several systems by their names.

    Raises
    ------
    ValueError
        If a system is none of python-control, or the frequencies do not rise.

    Examples
    --------
    >>> import control
    >>> plant = control.ss([[-1, 0], [0, -2]], np.eye(2), [[1, 1], [0, 1]], np.zeros((2, 2)))
    >>> wb.singular_values(plant).figure.name
    'singular_values'
    """
    held = []
    for label, one in _named(systems):
        found = system_answers(lti("singular_values", one), frequencies)
        held.append(FrequencyMatrix(label, found.frequencies, found.values, found.inputs, found.outputs, found.period))
    return Picture(singular_value_figure("singular_values", "", held, bounds))


@door
def pole_zero_map(systems: Any, grid: bool = True) -> Picture:
    """The poles and zeros of a system of python-control, or of several by their names, with lines of damping.

    Raises
    ------
    ValueError
        If a system is none of python-control, the periods differ, or there is neither a pole nor a zero.

    Examples
    --------
    >>> import control
    >>> wb.pole_zero_map(control.tf([1, 1], [1, 0.4, 4])).figure.name
    'pole_zero_map'
    """
    held = []
    for label, one in _named(systems):
        roots = system_roots(lti("pole_zero_map", one))
        held.append(PoleZeroSet(label, roots.poles, roots.zeros, roots.period))
    return Picture(pole_zero_figure("pole_zero_map", "", held, grid))


@door
def root_locus(system: Any, gains: Array | None = None, marked: tuple[float, ...] = (), grid: bool = True) -> Picture:
    """The poles of the negative feedback of k G over gains k, for a system G of python-control with one channel.

    Over another parameter of a loop take the poles of its rows, and `root_locus_figure`. `marked` gains have dots.

    Raises
    ------
    ValueError
        If the system is none, has several channels, or the gains do not rise.

    Examples
    --------
    >>> import control
    >>> wb.root_locus(control.tf([1], [1, 3, 3, 1]), gains=np.linspace(0, 20, 401)).caption.split(". ")[1]
    'A pole crosses the limit of stability at k = 8, by interpolation'
    """
    plant = _one_channel("root_locus", lti("root_locus", system))
    roots = system_roots(plant)
    values = GAINS * _gain_scale(roots.poles, roots.zeros, roots.gain) if gains is None else gains
    values = numbers("root_locus(gains=...)", values, 1)
    if not np.isfinite(values).all():
        raise refusal("root_locus(gains=...)", "finite numbers", gains)
    if not len(roots.poles) or len(roots.zeros) > len(roots.poles):
        raise refusal("root_locus(system)", "a system with poles, and no more zeros than poles", system)
    poles = feedback_poles(plant, values)
    figure = root_locus_figure("root_locus", "", "k", values, poles, "", marked, roots.zeros, roots.period, grid=grid)
    return Picture(figure)


def _gain_scale(poles: Any, zeros: Any, gain: float | None) -> float:
    """A gain at which the poles have moved by about their size."""
    size = float(np.abs(np.concatenate([poles, zeros])).max(initial=0.0)) or 1.0
    return size ** (len(poles) - len(zeros)) / (gain or 1.0) if gain else 1.0


@door
def step_response(systems: Any, until: float | None = None) -> Picture:
    """The step response of a system of python-control with one channel, or of several by their names, and its figures.

    Rise time, overshoot and settling time are told where the response tends to a value; `until` is in s.

    Raises
    ------
    ValueError
        If a system is none, or has several channels.

    Examples
    --------
    >>> import control
    >>> wb.step_response(control.tf([1], [1, 1]), until=10.0).caption
    'Rise time 2.2 s, overshoot 0 %, settling time 3.91 s, final value 1.'
    """
    held = []
    for label, one in _named(systems):
        system = _one_channel("step_response", lti("step_response", one))
        t, y, final = step_answers(system, until)
        value = float(final[0, 0])
        known = bool(np.isfinite(value)) and value != 0
        info = exact_figures(system) if known else None
        tends = value if info is not None or (known and value != float(y[0, 0, 0])) else None
        held.append(TimeResponse(label, t, y[0, 0], tends, period=period_of(system), info=info))
    return Picture(step_figure("step_response", "", held))


def _named(systems: Any) -> list[tuple[str, Any]]:
    """The systems by their names; a single one has its own, or none."""
    if isinstance(systems, Mapping):
        if not systems:
            raise refusal("bode(systems) and its like", "a system, or a mapping from names to systems", systems)
        return [(str(name), one) for name, one in systems.items()]
    return [("", systems)]


def _one_channel(call: str, system: Any) -> Any:
    if not system.issiso():
        raise ValueError(
            f"`{call}(systems)` draws one input and one output; this one has {system.ninputs} and {system.noutputs}: "
            "take one channel, as `system[0, 0]`, or `singular_values`."
        )
    return system


def _curves(
    call: str, systems: Any, frequencies: Array | None, margins: bool, asymptotes: bool = False
) -> tuple[list[FrequencyCurve], str]:
    """The answers of systems with what is asked to be drawn beside them, and why some have no margins."""
    pairs = [_curve(call, label, one, frequencies, margins, asymptotes) for label, one in _named(systems)]
    return [curve for curve, _ in pairs], " ".join(reason for _, reason in pairs if reason)


def _curve(
    call: str, label: str, system: Any, frequencies: Array | None, margins: bool, asymptotes: bool
) -> tuple[FrequencyCurve, str]:
    """The answers of a system, and the sentence that refuses its margins if it has none."""
    if isinstance(system, FrequencyCurve):
        return system, ""
    held = _one_channel(call, lti(call, system))
    found = system_answers(held, frequencies)
    corners = None
    if asymptotes:
        roots = system_roots(held)
        corners = None if roots.gain is None else Corners(roots.poles, roots.zeros, roots.gain)
    known, refused = _margins(held) if margins else (None, "")
    name = label or "L" * margins
    curve = FrequencyCurve(name, found.frequencies, found.values[:, 0, 0], found.period, margins=known, corners=corners)
    return curve, f"No margins of {name}: {refused}" if refused else ""


def _margins(system: Any) -> tuple[StabilityMargins | None, str]:
    """The certified margins of a loop gain, or none and the sentence that refuses them."""
    try:
        return stability_margins(system), ""
    except Refused as refusal:
        return None, str(refusal)


def _unstable_poles(system: Any) -> int:
    """The number of poles in the right half-plane, or outside the unit circle, but for rounding."""
    roots = system_roots(system)
    sizes = np.abs(roots.poles)
    outside = sizes - 1 if roots.period is not None else roots.poles.real
    return int((outside > ON_AXIS * np.maximum(sizes, 1e-300)).sum())

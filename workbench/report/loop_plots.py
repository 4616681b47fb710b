"""Pictures of systems and loops in one call: Bode, Nyquist, Nichols, poles and zeros, root locus, steps."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from workbench.core.validation.refusals import Array, numbers, refusal
from workbench.core.validation.signatures import check_arguments
from workbench.design.linear.system_answers import feedback_poles, lti, system_roots
from workbench.design.linear_loop import LinearLoop
from workbench.report.linear_loop_loci import locus_figure
from workbench.report.loop_pictures import (
    bode_figure,
    nichols_figure,
    nyquist_figure,
    root_locus_figure,
    singular_value_figure,
)
from workbench.report.loop_pictures import pole_zero_map as pole_zero_figure
from workbench.report.picture import Picture
from workbench.report.response_figures import responses_figure
from workbench.report.system_curves import Systems, curves_of, matrices_of, one_channel, roots_of
from workbench.study.document.frequency_curves import Complex
from workbench.study.document.gain_bounds import Disk, GainBound

GAINS = np.concatenate([[0.0], np.geomspace(1e-3, 1e3, 800)])  # of a root locus


@check_arguments
def bode(
    systems: Systems,
    frequencies: Array | None = None,
    margins: bool | None = None,
    asymptotes: bool = False,
    bounds: tuple[GainBound, ...] = (),
) -> Picture:
    """The Bode plot of a system with one channel, of a loop, of several by their names, or of a `FrequencyCurve`.

    For a `LinearLoop` it is the loop gain at each channel of its cut, while the loop is closed at the others.

    Parameters
    ----------
    systems
        A `StateSpace` or `TransferFunction` of python-control, a `LinearLoop`, a `FrequencyCurve`, a
        `FrequencyEstimate` from a log, or a mapping from names to these.
    frequencies
        (m,) in rad/s, in rising order; by default a range that shows the poles and zeros.
    margins
        True for loop gains L of negative feedback: certified margins are marked, and the caption states them. By
        default a `LinearLoop` has them, and a system has none.
    asymptotes
        True to draw the asymptotes of the gain, too.
    bounds
        Bounds on the gain; the side that a gain must not reach is shaded.

    Raises
    ------
    ValueError
        If a system has several channels (take `singular_values_plot`) or is not one of these, or the frequencies do not
        rise.

    Examples
    --------
    >>> import control
    >>> picture = wb.bode(control.tf([4], [1, 3, 3, 1]), margins=True)
    >>> picture.caption
    'Gain margin 6.02 dB, phase margin 27.1 degrees, delay margin 0.384 s, Ms 3, disk margin 0.378.'
    """
    found = curves_of("bode", systems, frequencies, margins, asymptotes)
    return Picture(bode_figure("bode", " ".join(found.remarks), found.curves, asymptotes, bounds))


@check_arguments
def nyquist(
    systems: Systems,
    frequencies: Array | None = None,
    margins: bool = True,
    reach: float | None = None,
    forbidden_disks: tuple[Disk, ...] = (),
) -> Picture:
    """The Nyquist plot of a loop gain L with one channel, of a loop, of several by their names, or of a curve.

    The caption states the encirclements of -1 and, for a single L, the unstable poles of the closed loop. Systems,
    frequencies and margins are as of `bode`. The curve is cut at the distance `reach` from zero, and `forbidden_disks`
    are shaded.

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
    found = curves_of("nyquist", systems, frequencies, margins)
    unstable = found.unstable[0] if len(found.curves) == 1 else None
    remarks = " ".join(found.remarks)
    return Picture(
        nyquist_figure("nyquist", remarks, found.curves, unstable, forbidden_disks=forbidden_disks, reach=reach)
    )


@check_arguments
def nichols(systems: Systems, frequencies: Array | None = None, margins: bool = True) -> Picture:
    """The Nichols plot of a loop gain L with one channel, of a loop, of several by their names, or of a curve.

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
    found = curves_of("nichols", systems, frequencies, margins)
    return Picture(nichols_figure("nichols", " ".join(found.remarks), found.curves))


@check_arguments
def singular_values_plot(
    systems: Systems, frequencies: Array | None = None, bounds: tuple[GainBound, ...] = ()
) -> Picture:
    """The singular values over frequency of a system with several channels, or of several systems by their names.

    For a `LinearLoop` they are those of the loop gain L at all channels, and the caption has the disk margin. `bounds`
    shade regions that the largest singular value must not reach.

    Raises
    ------
    ValueError
        If a system is not one of python-control, or the frequencies do not rise.

    Examples
    --------
    >>> import control
    >>> plant = control.ss([[-1, 0], [0, -2]], np.eye(2), [[1, 1], [0, 1]], np.zeros((2, 2)))
    >>> wb.singular_values_plot(plant).figure.name
    'singular_values'
    """
    held, remarks = matrices_of("singular_values_plot", systems, frequencies)
    return Picture(singular_value_figure("singular_values", " ".join(remarks), held, bounds))


@check_arguments
def pole_zero_map(systems: Systems, grid: bool = True) -> Picture:
    """The poles and zeros of a system of python-control, or of several by their names, with lines of damping.

    For a `LinearLoop` they are the poles of the closed loop.

    Raises
    ------
    ValueError
        If a system is not one of python-control, the periods differ, there is neither a pole nor a zero, or a loop has
        a delay, and so no finite number of poles.

    Examples
    --------
    >>> import control
    >>> wb.pole_zero_map(control.tf([1, 1], [1, 0.4, 4])).figure.name
    'pole_zero_map'
    """
    return Picture(pole_zero_figure("pole_zero_map", "", roots_of("pole_zero_map", systems), grid))


@check_arguments
def root_locus(
    system: Systems,
    over: object = None,
    values: Array | None = None,
    marked_values: tuple[float, ...] = (),
    grid: bool = True,
) -> Picture:
    """The poles of a loop over the values of any of its parameters, or of the negative feedback of k G over gains k.

    Parameters
    ----------
    system
        A `LinearLoop`, or a system G of python-control with one channel.
    over
        For a loop, the path of a parameter, as "plant.m", or a mapping from the path to its values; for a system, the
        gains k (N,).
    values
        The values (N,) of the parameter of a loop, in rising or falling order.
    marked_values
        Values at which each pole gets a dot; for a loop, by default the present value.
    grid
        True for lines of constant damping and natural frequency.

    Raises
    ------
    ValueError
        If the system is not one of these, or has several channels; values are missing, or neither rise nor fall; or the
        loop has a delay, and so no finite number of poles.
    LookupError
        If the loop has no such parameter.

    Examples
    --------
    >>> import control
    >>> wb.root_locus(control.tf([1], [1, 3, 3, 1]), np.linspace(0, 20, 401)).caption.split(". ")[1]
    'A pole crosses the limit of stability at k = 8, by interpolation'
    """
    if isinstance(system, LinearLoop):
        return Picture(locus_figure("root_locus", system, over, values, marked_values, grid))
    if values is not None or isinstance(over, str | Mapping):
        raise refusal("root_locus(system)", "a `LinearLoop`, if a parameter is named", system)
    plant = one_channel("root_locus", lti("root_locus", system))
    roots = system_roots(plant)
    scale = _gain_scale(roots.poles, roots.zeros, roots.gain)
    gains = GAINS * scale if over is None else numbers("root_locus(over=...)", over, 1)
    if not np.isfinite(gains).all():
        raise refusal("root_locus(over=...)", "finite numbers", over)
    if not len(roots.poles) or len(roots.zeros) > len(roots.poles):
        raise refusal("root_locus(system)", "a system with poles, and no more zeros than poles", system)
    poles = feedback_poles(plant, gains)
    figure = root_locus_figure(
        "root_locus", "", "k", gains, poles, "", marked_values, roots.zeros, roots.period, grid=grid
    )
    return Picture(figure)


def _gain_scale(poles: Complex, zeros: Complex, gain: float | None) -> float:
    """A gain at which the poles have moved by about their size."""
    size = float(np.abs(np.concatenate([poles, zeros])).max(initial=0.0)) or 1.0
    return size ** (len(poles) - len(zeros)) / (gain or 1.0) if gain else 1.0


@check_arguments
def step_response(systems: Systems, until: float | None = None) -> Picture:
    """The step response of a system with one channel, of a loop, or of several by their names.

    For a `LinearLoop` it is the response of the outputs that follow a reference to this reference, or else to a load.
    The caption states rise time, overshoot and settling time if the response tends to a value. `until` is the last time
    in s.

    Raises
    ------
    ValueError
        If a system is not one of these, or has several channels; or a loop has a delay, which needs infinitely many
        states.

    Examples
    --------
    >>> import control
    >>> wb.step_response(control.tf([1], [1, 1]), until=10.0).caption
    'Rise time 2.2 s, overshoot 0 %, settling time 3.91 s, final value 1.'
    """
    return Picture(responses_figure("step_response", systems, until))

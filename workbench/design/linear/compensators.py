"""Gains and compensators by their poles and margins: pole placement, and lead-lag."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from workbench.core.point import OperatingPoint, PointedGain
from workbench.core.validation.notebook_display import show
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array, describe, error_text, finite, refusal
from workbench.core.validation.signatures import check_arguments
from workbench.design.control_system import System
from workbench.design.linear.linear_modes import controllability
from workbench.design.linear.loop_margins import loop_margins
from workbench.design.linear.operating_point import state_space
from workbench.design.matrices import EPS, Complex, DesignError, pole_text

if TYPE_CHECKING:
    import control

SAME = 1e-9  # of the size of the poles: nearer ones count as one that is repeated
OFF = 1e-6  # how far a simple pole may lie from where it was wanted, relative to its size
MOST_LEAD = 75.0  # degrees of one section, whose gain at high frequencies is then 58 times that at low ones
CLOSE = 1e-4  # degrees that the search for a crossover may be off, where the margin is met exactly
DECADE = 10.0  # from the zero of the lag to the crossover, where it costs 6 degrees at most


@dataclass(frozen=True, eq=False)
@show
class Placement:
    """The gain K (nu, nx) of u = -K x, the poles (nx,) of A - B K, and their largest `error`, relative to each pole.

    `point` is the operating point of the linearised system for which K was computed, if any.
    """

    K: Array
    poles: Complex
    error: float
    point: OperatingPoint | None = None


@check_arguments
def place(system: control.StateSpace, poles: Numbers) -> Placement:
    """The gain K of u = -K x that gives A - B K these poles, by python-control; for several inputs a robust one.

    Parameters
    ----------
    system
        A `StateSpace` with nx states, continuous or discrete.
    poles
        (nx,), complex ones in conjugate pairs. With several inputs, a pole may occur as often as there are inputs.

    Raises
    ------
    ValueError
        If `poles` is not as above.
    DesignError
        If no input moves a mode, or the poles of A - B K are not those of `poles`.

    References
    ----------
    Tits and Yang (1996), Globally convergent algorithms for robust pole assignment, IEEE Trans. Autom. Control 41.

    Examples
    --------
    >>> motor = wb.linearize(wb.open_loop(wb.DCMotor()), 0.0, [0.0, 0.0])
    >>> wb.place(motor, [-10.0, -20.0]).K.round(3)
    array([[-0.01,  9.  ]])
    """
    from workbench.design.linear.pointed_systems import point_of

    state_space("place", system)
    wanted = _conjugate(poles, system)
    if (test := controllability(system)).failing_modes:
        mode = test.failing_modes[0]
        raise DesignError(
            f"`place(system, poles)` can move only modes that an input reaches; the pole {mode.value:.4g} of "
            f"'{system.name}' is reached by none. Take `lqr`, if it decays."
        )
    distance = np.abs(wanted[:, np.newaxis] - wanted)
    most = int((distance <= SAME * np.abs(wanted).max()).sum(axis=1).max())
    K = _gain(system, wanted, most)
    reached = np.linalg.eigvals(system.A - system.B @ K).astype(complex)
    reached, errors = _match_poles(wanted, reached)
    worst = int(errors.argmax())
    # rounding moves a pole that is repeated m times by the m-th root of itself
    if not errors[worst] <= max(OFF, (1e3 * EPS) ** (1 / most)):
        raise DesignError(
            f"`place(system, poles)`: A - B K has the pole {pole_text(complex(reached[worst]))} in the place of "
            f"{pole_text(complex(wanted[worst]))}; take poles nearer to those of the system and to each other, or not "
            "repeated."
        )
    point = point_of(system)
    return Placement(PointedGain.of(K, point), reached, float(errors[worst]), point)


def _gain(system: control.StateSpace, target_poles: Complex, most: int) -> Array:
    """The gain of python-control for poles of which one comes so often at most."""
    import control

    design = control.acker if system.ninputs == 1 and most > 1 else control.place
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # what does not converge is seen in the poles
            return np.asarray(design(system.A, system.B, target_poles), dtype=float).reshape(system.ninputs, -1)
    except ValueError as error:
        raise DesignError(f"`place(system, poles)`: python-control has no such gain: {error_text(error)}.") from error


def _conjugate(poles: Numbers, system: System) -> Complex:
    call = "place(poles=...)"
    try:
        given = np.array(poles)
    except Exception:  # an object of the user's may raise anything when it is asked for its numbers
        raise refusal(call, "a vector of numbers", poles) from None
    if given.dtype.kind not in "iufc":  # symbols of CasADi, say, or a number beyond 1.8e308
        raise refusal(call, "a vector of numbers", poles)
    with np.errstate(over="ignore"):  # a number beyond 1.8e308 becomes infinite, and is refused
        wanted = given.astype(complex)
    if wanted.shape != (len(system.A),) or not np.isfinite(wanted).all():
        raise ValueError(f"`{call}` must be {len(system.A)} finite numbers, one for each state; got {describe(poles)}.")
    if not np.allclose(np.sort_complex(wanted), np.sort_complex(wanted.conj()), rtol=SAME, atol=0):
        raise ValueError(f"`{call}` must come in conjugate pairs, as the gain is real; got {describe(poles)}.")
    return wanted


def _match_poles(target_poles: Complex, reached_poles: Complex) -> tuple[Complex, Array]:
    """The poles that are reached in the order of the wanted ones, with the error of each relative to its own size.

    A pole at zero has no size; its error is relative to the largest.
    """
    from scipy.optimize import linear_sum_assignment  # here, as it takes long to import

    distance = np.abs(target_poles[:, np.newaxis] - reached_poles)
    rows, columns = linear_sum_assignment(distance)
    size = np.where(target_poles != 0, np.abs(target_poles), max(float(np.abs(target_poles).max()), EPS))
    return reached_poles[columns], distance[rows, columns] / size


@check_arguments
def lead_lag(
    plant: control.StateSpace, crossover: float, margin: float, lag_factor: float = 1.0
) -> control.TransferFunction:
    """The compensator C for which |P C| is one at `crossover`, and the phase margin is `margin` there:

        C = k (s + wc/10) / (s + wc/(10 b)) (s + wc sqrt(a)) / (s + wc/sqrt(a)),       a = (1 - sin f)/(1 + sin f),

    where b is `lag_factor` and f the phase still missing at the crossover wc. The input of C is the error, reference
    minus output, and C has the signal names of the plant: `LinearLaw(C, error=True)` runs it, and `c2d(C, period,
    "tustin")` samples it. For a linearised plant, the law adds the input u0 of its operating point to the output of C.

    Parameters
    ----------
    plant
        A `StateSpace` or `TransferFunction` in continuous time with one input and one output.
    crossover, margin
        The crossover frequency wc in rad/s; the phase margin in degrees, between 0 and 90.
    lag_factor
        The factor by which the lag raises the gain at low frequencies; 1 for no lag.

    Raises
    ------
    ValueError
        If `plant` is not such a system, or a number is out of its range.
    DesignError
        If more than 75 degrees of phase are missing, the closed loop is not stable, or another crossover has less
        margin.

    References
    ----------
    Franklin, Powell and Emami-Naeini (2019), Feedback Control of Dynamic Systems, section 6.7.

    Examples
    --------
    >>> motor = wb.linearize(wb.open_loop(wb.DCMotor()), 0.0, [0.0, 0.0])
    >>> lead = wb.lead_lag(motor, crossover=10.0, margin=60.0, lag_factor=10.0)
    >>> np.sort(lead.poles().real).round(2)
    array([-11.67,  -0.1 ])
    """
    import control

    from workbench.design.linear.pointed_systems import PointedTransfer, point_of

    _refuse_odd_plant(plant)
    wc = finite("lead_lag(crossover=...)", crossover, " of rad/s", low=1e-12, high=1e12)
    degrees = finite("lead_lag(margin=...)", margin, " of degrees", low=0, high=90)
    more = finite("lead_lag(lag_factor=...)", lag_factor, low=1, high=1e6)
    lag = control.tf([1, wc / DECADE], [1, wc / DECADE / more]) if more > 1 else control.tf([1], [1])
    shape = lag * _lead(wc, degrees - 180 - np.degrees(np.angle(plant(1j * wc) * lag(1j * wc))))
    names = {"inputs": plant.output_labels, "outputs": plant.input_labels, "name": f"lead-lag of {plant.name}"}
    C: control.TransferFunction = control.tf(
        shape.num_list[0][0] / abs(plant(1j * wc) * shape(1j * wc)), shape.den_list[0][0], **names
    )
    _refuse_margin(control.ss(plant) * control.ss(C), wc, degrees)
    point = point_of(plant)
    return C if point is None else PointedTransfer(C, point.of_compensator())


def _refuse_odd_plant(plant: System) -> None:
    import control

    linear = isinstance(plant, control.StateSpace | control.TransferFunction)
    if not linear or not plant.issiso() or plant.isdtime(strict=True):
        must = "a `StateSpace` or `TransferFunction` in continuous time with one input and one output"
        raise refusal("lead_lag(plant=...)", must, plant)


def _refuse_margin(loop: control.StateSpace, wc: float, degrees: float) -> None:
    """Refuse a loop that is not stable once closed, or has less margin at any of its crossovers."""
    import control

    poles = control.feedback(loop, 1).poles()
    if not poles.real.max() < 0:
        raise DesignError(
            f"`lead_lag(...)`: with a crossover at {wc:g} rad/s the closed loop has the pole "
            f"{poles[poles.real.argmax()]:.3g}, so it is not stable; take another crossover, or `lqg`."
        )
    (reached,) = loop_margins(loop)
    if not reached.phase >= degrees - CLOSE:
        raise DesignError(
            f"`lead_lag(...)`: the loop crosses a gain of one at {reached.crossover:.4g} rad/s, not only at {wc:g}, "
            f"and its phase margin there is {reached.phase:.3g} degrees, not {degrees:g}. Take another crossover, "
            "beyond the resonance of the plant say, a smaller margin, or `lqg`."
        )


def _lead(wc: float, phase: float) -> control.TransferFunction:
    """The section that leads by a phase in degrees at a frequency; a gain of one where no phase lacks."""
    import control

    phase = 180 - (180 - phase) % 360
    if phase <= 0:
        return control.tf([1], [1])
    if not phase <= MOST_LEAD:
        raise DesignError(
            f"`lead_lag(...)`: {phase:.3g} degrees lack at {wc:g} rad/s, and one section of lead gives {MOST_LEAD:g} "
            "at most; take a lower crossover or a smaller margin."
        )
    sine = np.sin(np.radians(phase))
    a = (1 - sine) / (1 + sine)
    return control.tf([1, wc * np.sqrt(a)], [1, wc / np.sqrt(a)])

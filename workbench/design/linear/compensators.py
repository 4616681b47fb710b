"""Gains and compensators by their poles and margins: pole placement, and lead-lag."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from workbench.design.linear.linear_modes import controllability
from workbench.design.linear.operating_point import state_space
from workbench.design.matrices import EPS, Complex, Refused
from workbench.validation.notebook_display import show
from workbench.validation.refusals import Array, described, finite, raised, refusal
from workbench.validation.signatures import door

if TYPE_CHECKING:
    import control

SAME = 1e-9  # of the size of the poles: nearer ones count as one that is repeated
OFF = 1e-6  # how far simple poles may lie from what was wanted, relative to the largest
MOST_LEAD = 75.0  # degrees of one section, whose gain at high frequencies is then 58 times that at low ones
DECADE = 10.0  # from the zero of the lag to the crossover, where it costs 6 degrees at most


@dataclass(frozen=True, eq=False)
@show
class Placement:
    """The gain K (nu, nx) of u = -K x, the poles (nx,) of A - B K, and their largest error, relative to the largest."""

    K: Array
    poles: Complex
    error: float


@door
def place(system: control.StateSpace, poles: Any) -> Placement:
    """The gain K of u = -K x that gives A - B K these poles, by python-control; for several inputs a robust one.

    Parameters
    ----------
    system
        A `StateSpace` with nx states, continuous or discrete.
    poles
        (nx,), complex ones in conjugate pairs. With several inputs none more often than there are inputs.

    Raises
    ------
    ValueError
        If the poles are not such numbers.
    Refused
        If a mode is not moved by any input, or the poles of A - B K are not those that were wanted.

    References
    ----------
    Tits and Yang (1996), Globally convergent algorithms for robust pole assignment, IEEE Trans. Autom. Control 41.

    Examples
    --------
    >>> motor = wb.linearize(wb.open_loop(wb.DCMotor()), 0.0, [0.0, 0.0])
    >>> wb.place(motor, [-10.0, -20.0]).K.round(3)
    array([[-0.01,  9.  ]])
    """
    import control

    state_space("place", system)
    wanted = _conjugate(poles, system)
    if (test := controllability(system)).failing:
        mode = test.failing[0]
        raise Refused(
            f"`place(system, poles)` can move only modes that an input reaches; the pole {mode.value:.4g} of "
            f"'{system.name}' is reached by none. Take `lqr`, if it decays."
        )
    distance = np.abs(wanted[:, np.newaxis] - wanted)
    most = int((distance <= SAME * np.abs(wanted).max()).sum(axis=1).max())
    design = control.acker if system.ninputs == 1 and most > 1 else control.place
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # what does not converge is seen in the poles
            K = np.asarray(design(system.A, system.B, wanted), dtype=float).reshape(system.ninputs, -1)
    except ValueError as error:
        raise Refused(f"`place(system, poles)`: python-control has no such gain: {raised(error)}.") from error
    reached = np.linalg.eigvals(system.A - system.B @ K).astype(complex)
    off = _apart(wanted, reached) / max(float(np.abs(wanted).max()), EPS)
    # rounding moves a pole that is repeated m times by the m-th root of itself
    if not off <= max(OFF, (1e3 * EPS) ** (1 / most)):
        raise Refused(
            f"`place(system, poles)`: the poles of A - B K lie up to {off:.1e} of the largest away from those that "
            "were wanted; take poles nearer to those of the system, or not repeated."
        )
    return Placement(K, reached, off)


def _conjugate(poles: Any, system: Any) -> Complex:
    call = "place(poles=...)"
    try:
        given = np.array(poles)
    except Exception:  # an object of the user's may raise anything when it is asked for its numbers
        raise refusal(call, "a vector of numbers", poles) from None
    if given.dtype.kind not in "iufc":  # symbols of CasADi, say, or a number beyond 1.8e308
        raise refusal(call, "a vector of numbers", poles)
    wanted = given.astype(complex)
    if wanted.shape != (len(system.A),) or not np.isfinite(wanted).all():
        raise ValueError(
            f"`{call}` must be {len(system.A)} finite numbers, one for each state; got {described(poles)}."
        )
    if not np.allclose(np.sort_complex(wanted), np.sort_complex(wanted.conj()), rtol=SAME, atol=0):
        raise ValueError(f"`{call}` must come in conjugate pairs, as the gain is real; got {described(poles)}.")
    return wanted


def _apart(wanted: Complex, reached: Complex) -> float:
    """The largest distance between poles that are matched one by one."""
    distance = np.abs(wanted[:, np.newaxis] - reached)
    return float(distance[linear_sum_assignment(distance)].max())


@door
def lead_lag(
    plant: control.StateSpace, crossover: float, margin: float, boost: float = 1.0
) -> control.TransferFunction:
    """The compensator C with which P C crosses a gain of one at a frequency, with at least this phase margin:

        C = k (s + wc/10) / (s + wc/(10 boost)) (s + wc sqrt(a)) / (s + wc/sqrt(a)),       a = (1 - sin f)/(1 + sin f),

    where f is the phase that lacks at the crossover wc. Its input is the error, reference minus output, and it has the
    names of the plant: `LinearLaw(C, error=True)` runs it, and `control.c2d(C, period, "tustin")` samples it.

    Parameters
    ----------
    plant
        A `StateSpace` or `TransferFunction` in continuous time with one input and one output.
    crossover, margin
        In rad/s, and in degrees between 0 and 90.
    boost
        The factor by which the lag raises the gain at low frequencies; 1 for no lag.

    Raises
    ------
    ValueError
        If the plant is none, or a number is out of its range.
    Refused
        If more than 75 degrees lack, or the closed loop is not stable.

    References
    ----------
    Franklin, Powell and Emami-Naeini (2019), Feedback Control of Dynamic Systems, section 6.7.

    Examples
    --------
    >>> motor = wb.linearize(wb.open_loop(wb.DCMotor()), 0.0, [0.0, 0.0])
    >>> lead = wb.lead_lag(motor, crossover=10.0, margin=60.0, boost=10.0)
    >>> np.sort(lead.poles().real).round(2)
    array([-11.67,  -0.1 ])
    """
    import control

    linear = isinstance(plant, control.StateSpace | control.TransferFunction)
    if not linear or not plant.issiso() or plant.isdtime(strict=True):
        must = "a `StateSpace` or `TransferFunction` in continuous time with one input and one output"
        raise refusal("lead_lag(plant=...)", must, plant)
    wc = finite("lead_lag(crossover=...)", crossover, " of rad/s", low=1e-12, high=1e12)
    degrees = finite("lead_lag(margin=...)", margin, " of degrees", low=0, high=90)
    more = finite("lead_lag(boost=...)", boost, low=1, high=1e6)
    lag = control.tf([1, wc / DECADE], [1, wc / DECADE / more]) if more > 1 else control.tf([1], [1])
    shape = lag * _lead(wc, degrees - 180 - np.degrees(np.angle(plant(1j * wc) * lag(1j * wc))))
    names = {"inputs": plant.output_labels, "outputs": plant.input_labels, "name": f"lead-lag of {plant.name}"}
    C = control.tf(shape.num_list[0][0] / abs(plant(1j * wc) * shape(1j * wc)), shape.den_list[0][0], **names)
    poles = control.feedback(control.ss(plant) * control.ss(C), 1).poles()
    if not poles.real.max() < 0:
        raise Refused(
            f"`lead_lag(...)`: with a crossover at {wc:g} rad/s the closed loop has the pole "
            f"{poles[poles.real.argmax()]:.3g}, so it is not stable; take another crossover, or `lqg`."
        )
    return C


def _lead(wc: float, phase: float) -> control.TransferFunction:
    """The section that leads by a phase in degrees at a frequency; a gain of one where no phase lacks."""
    import control

    phase = 180 - (180 - phase) % 360
    if phase <= 0:
        return control.tf([1], [1])
    if not phase <= MOST_LEAD:
        raise Refused(
            f"`lead_lag(...)`: {phase:.3g} degrees lack at {wc:g} rad/s, and one section of lead gives {MOST_LEAD:g} "
            "at most; take a lower crossover or a smaller margin."
        )
    sine = np.sin(np.radians(phase))
    a = (1 - sine) / (1 + sine)
    return control.tf([1, wc * np.sqrt(a)], [1, wc / np.sqrt(a)])

"""Answers of a system of python-control at frequencies that fit it, its roots, and its step responses."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import schur, solve_triangular

from workbench.core.validation.refusals import Array, refusal
from workbench.core.validation.signatures import check_arguments
from workbench.design.control_system import System
from workbench.design.frequency.frequency_axis import checked_frequencies
from workbench.design.linear.finite_zeros import finite_zeros, markov_parameter
from workbench.design.linear.response_times import exact_responses, response_times, times_of
from workbench.design.matrices import Complex, DesignError

if TYPE_CHECKING:
    import control

BEYOND = 30.0  # times the fastest root, and as much below the slowest: the range of frequencies
DECADE = 120  # frequencies in a decade
MOST = 3000  # frequencies in all
MANY = 30  # states, from which on one Schur form serves all frequencies
LIGHT = 0.2  # the damping below which a root has frequencies of its own
SHARPEST = 1e-6  # the damping that a sharper root counts as having
CLOSE = 0.06  # radians of the circle that a resonance draws, from one frequency to the next
ABOUT = 12_000  # frequencies about all lightly damped roots
CONSTANTS = 8.0  # time constants of the slowest mode, which a step response shows
UNSTABLE = 3.0  # time constants of the fastest growth
LONGEST = 5000  # periods of a response in a computer
AT_ZERO = 1e-7  # of the largest root: a root nearer to zero, or to z = 1, stands for one there
ON_AXIS = 1e-8  # relative: a pole nearer to the axis is none of the unstable ones


@dataclass(frozen=True, eq=False)
class SystemAnswers:
    """The answers (m, ny, nu) of a system at `frequencies` (m,) in rad/s, NaN at a pole, its names and its period."""

    frequencies: Array
    values: Complex
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    period: float | None


@dataclass(frozen=True, eq=False)
class SystemRoots:
    """The poles, the zeros, and of one channel the gain K of G = K (s - z1) ... / (s - p1) ...; None for several."""

    poles: Complex
    zeros: Complex
    gain: float | None
    period: float | None

    @property
    def integrators(self) -> int:
        """The number of poles at zero, or at z = 1, less that of the zeros there."""
        both, one = np.concatenate([self.poles, self.zeros]), 0.0 if self.period is None else 1.0
        near = AT_ZERO * float(np.abs(self.poles if len(self.poles) else both).max(initial=0.0))
        return int((np.abs(self.poles - one) <= near).sum() - (np.abs(self.zeros - one) <= near).sum())


def lti(call: str, system: System) -> System:
    """A `StateSpace` or `TransferFunction` of python-control with a known period; anything else is refused."""
    import control

    if not isinstance(system, control.StateSpace | control.TransferFunction) or system.dt is True:
        must = "a `StateSpace` or `TransferFunction` of python-control, and its `dt` a number"
        raise refusal(f"{call}(system)", must, system)
    if not all(np.isfinite(part).all() for part in _numbers_of(system)):
        raise ValueError(f"`{call}(system)` must have finite numbers; '{system.name}' has nan or an infinity.")
    return system


def _numbers_of(system: System) -> list[Array]:
    """The matrices, or all numerators and denominators, of a system."""
    if hasattr(system, "A"):
        parts = [system.A, system.B, system.C, system.D]
    else:
        parts = [entry for rows in (*system.num_list, *system.den_list) for entry in rows]
    return [np.asarray(part, dtype=float) for part in parts]


def _refuse_improper(call: str, system: System) -> None:
    """Refuse a transfer function that differentiates: its response to a step is no function of time."""
    if hasattr(system, "A"):
        return
    for tops, bottoms in zip(system.num_list, system.den_list, strict=True):
        for top, bottom in zip(tops, bottoms, strict=True):
            degrees = [len(np.trim_zeros(np.asarray(part, dtype=float), "f")) - 1 for part in (top, bottom)]
            if degrees[0] > degrees[1]:
                raise ValueError(
                    f"`{call}(system)` must be proper; the numerator of '{system.name}' has degree {degrees[0]}, its "
                    f"denominator {degrees[1]}. Add the poles that its differentiation has in truth."
                )


def period_of(system: System) -> float | None:
    """The period of a system in s, None in continuous time."""
    return float(system.dt) if system.dt else None


@check_arguments
def system_roots(system: control.StateSpace | control.TransferFunction) -> SystemRoots:
    """The poles and the zeros of a system, as python-control computes them, without zeros that are infinite in truth.

    Raises
    ------
    ValueError
        If the system is none of python-control.
    """
    held = lti("system_roots", system)
    poles, zeros = (np.asarray(roots, dtype=complex) for roots in (held.poles(), held.zeros()))
    zeros, gain = zeros[np.isfinite(zeros)], None
    if held.issiso() and hasattr(held, "A"):
        parts = (np.asarray(part, dtype=float) for part in (held.A, held.B, held.C, held.D))
        excess, slope = markov_parameter(*parts)
        zeros, gain = finite_zeros(zeros, held.nstates - excess), slope or None
    elif held.issiso():
        top, bottom = (np.trim_zeros(np.asarray(part[0][0], dtype=float), "f") for part in (held.num, held.den))
        gain = float(top[0] / bottom[0]) if top.size else None
    return SystemRoots(poles, zeros, gain, period_of(held))


def unstable_poles(roots: SystemRoots) -> int:
    """The number of poles in the right half-plane, or outside the unit circle, but for rounding and for integrators."""
    sizes = np.abs(roots.poles)
    outside = sizes - 1 if roots.period is not None else roots.poles.real
    integrates = np.abs(roots.poles - (0.0 if roots.period is None else 1.0)) <= AT_ZERO * sizes.max(initial=0.0)
    return int(((outside > ON_AXIS * sizes) & ~integrates).sum())


def feedback_poles(system: control.StateSpace | control.TransferFunction, gains: Array) -> Complex:
    """The poles (N, nx) of the negative feedback of k G for N gains, as eigenvalues of A - B k C / (1 + k D).

    A row is NaN where 1 + k D is zero. Eigenvalues keep the digits that multiplied-out polynomials would lose.
    """
    import control

    space = control.ss(system)
    A, BC, D = np.asarray(space.A), np.asarray(space.B @ space.C), float(space.D[0, 0])
    poles = np.full((len(gains), len(A)), np.nan, complex)
    for row, k in zip(poles, gains, strict=True):
        if 1 + k * D:
            row[:] = np.linalg.eigvals(A - k / (1 + k * D) * BC)
    return poles


def fitting_frequencies(roots: SystemRoots) -> Array:
    """Frequencies in rad/s that show a system: whole decades about its roots, closer where a root is lightly damped."""
    both = np.concatenate([roots.poles, roots.zeros])
    if roots.period is not None:
        both = np.log(both[np.abs(both) > 0]) / roots.period
    sizes = np.abs(both)
    near = sizes > 1e-8 * sizes.max(initial=0.0)
    both, sizes = both[near], sizes[near]
    top = None if roots.period is None else math.pi / roots.period
    fastest = float(sizes.max(initial=0.0)) or (1.0 if top is None else top / 10)
    slowest = min(float(sizes.min(initial=fastest)), fastest)
    low = 10.0 ** math.floor(math.log10(slowest / BEYOND))
    high = 10.0 ** math.ceil(math.log10(fastest * BEYOND)) if top is None else top
    low = min(low, high / 100)
    count = min(MOST, max(2, round(DECADE * math.log10(high / low))))
    parts = [np.geomspace(low, high, count)]
    light = both[(np.abs(both.real) < LIGHT * sizes) & (both.imag > 0)]
    parts += [root.imag + distances(root, ABOUT // len(light)) for root in light]
    omega = np.unique(np.concatenate(parts))
    return np.asarray(omega[(omega >= low) & (omega <= high)])


def distances(root: complex, most: int) -> Array:
    """Distances in rad/s from the frequency of a lightly damped root, at even steps of the circle near it.

    They go on, in even ratios, until the frequencies of a whole picture are as close.
    """
    width = max(abs(root.real), SHARPEST * root.imag)
    end = float(np.arcsinh(max(1.0, 0.3 * root.imag / width)))
    count = min(most, 2 * math.ceil(end / CLOSE) + 1)
    return np.asarray(width * np.sinh(np.linspace(-end, end, count)))


@check_arguments
def system_answers(
    system: control.StateSpace | control.TransferFunction,
    frequencies: Array | None = None,
    call: str = "system_answers",
) -> SystemAnswers:
    """The answers of a system, by default at frequencies that fit its poles and zeros; refusals name the `call`.

    Raises
    ------
    ValueError
        If the system is none of python-control, or the frequencies are none, not finite, negative, falling or above
        Nyquist's.
    """
    held = lti(call, system)
    h = period_of(held)
    if frequencies is None:
        omega = fitting_frequencies(system_roots(held))
    else:
        omega = checked_frequencies(f"{call}(frequencies=...)", frequencies, h)
    at = 1j * omega if h is None else np.exp(1j * omega * h)
    with np.errstate(all="ignore"):
        if hasattr(held, "A") and held.nstates > MANY:
            values = _by_schur_form(held, np.asarray(at, dtype=complex))
        else:
            values = np.moveaxis(np.asarray(held(at, squeeze=False, warn_infinite=False), dtype=complex), -1, 0)
    values = np.where(np.isfinite(values), values, np.nan)
    return SystemAnswers(omega, values, tuple(held.input_labels), tuple(held.output_labels), h)


def _by_schur_form(system: System, at: Complex) -> Complex:
    """The answers (m, ny, nu) of a state space at points s or z (m,), from one unitary form of A for all of them."""
    T, Z = schur(np.asarray(system.A, dtype=complex), output="complex")
    into, out, places = Z.conj().T @ system.B, system.C @ Z, np.diag_indices(len(T))
    values = np.full((len(at), system.noutputs, system.ninputs), np.nan, complex)
    for k, point in enumerate(at):
        M = -T
        M[places] += point
        if (M[places] != 0).all():
            values[k] = out @ solve_triangular(M, into, check_finite=False) + system.D
    return values


@check_arguments
def step_answers(
    system: control.StateSpace | control.TransferFunction,
    until: float | None = None,
    impulse: bool = False,
    call: str = "step_answers",
) -> tuple[Array, Array, Array]:
    """The times (N,) in s, the step responses (ny, nu, N), and the values (ny, nu) to which they tend, NaN if to none.

    In continuous time the steps are shorter while fast modes last, and each value is exact but for rounding.

    Without `until` it is long enough for the slowest mode to decay, or for the fastest growth to be seen.

    Raises
    ------
    ValueError
        If the system is none of python-control, or improper, or `until` is not positive.
    DesignError
        If the response would have too many periods.
    """
    held = lti(call, system)
    _refuse_improper(call, held)
    h = period_of(held)
    poles = np.asarray(held.poles(), dtype=complex)
    if h is not None:
        poles = np.log(np.where(poles == 0, 1e-3, poles)) / h
    end = until if until is not None else showing_time(poles, h)
    if not 0 < end < math.inf:
        raise refusal(f"{call}(until=...)", "a positive number of seconds", until)
    if h is not None and end / h > LONGEST:
        raise DesignError(
            f"`{call}(until=...)` draws up to {LONGEST} periods; {end:g} s are {end / h:.0f} of them: give a "
            "shorter `until`."
        )
    t, outputs = _responses(held, poles, end, impulse)
    final = np.full((held.noutputs, held.ninputs), np.nan)
    rests = bool((poles.real < -1e-9 * np.abs(poles).max(initial=0.0)).all())
    if rests:
        final = np.zeros_like(final) if impulse else np.real(np.asarray(held.dcgain())).reshape(final.shape)
    return t, outputs, np.asarray(final, dtype=float)


def _responses(system: System, poles: Complex, end: float, impulse: bool) -> tuple[Array, Array]:
    """The times (N,) and the responses (ny, nu, N); in continuous time closer while fast modes last."""
    import control

    h = period_of(system)
    if h is not None:
        t = np.asarray(h * np.arange(max(2, round(end / h) + 1)), dtype=float)
        respond = control.impulse_response if impulse else control.step_response
        found = np.asarray(respond(system, t, squeeze=False).outputs, dtype=float)
        return t, found.reshape(system.noutputs, system.ninputs, len(t))
    space, steps = control.ss(system), response_times(poles, end)
    A, B, Cy, D = (np.asarray(part, dtype=float) for part in (space.A, space.B, space.C, space.D))
    return times_of(steps), np.asarray(np.moveaxis(exact_responses(A, B, Cy, D, steps, impulse), 0, -1))


def showing_time(poles: Complex, h: float | None) -> float:
    """The seconds that show the slowest mode decay, or the fastest grow, by poles (nx,) in 1/s."""
    rates = poles.real
    size = np.abs(poles).max(initial=0.0)
    if not size:
        return 10.0 * (h or 1.0)
    growing, decaying = rates[rates > 1e-6 * size], -rates[rates < -1e-6 * size]
    if growing.size:
        return UNSTABLE / float(growing.max())
    turning = 2 * math.pi / float(np.abs(poles.imag)[np.abs(poles) > 0].max(initial=0.0) or size)
    return CONSTANTS / float(decaying.min()) if decaying.size else 5 * turning

"""The error after a step of load at the input of a plant with delay, from its frequency response.

E(s) = P(s) / (1 + P(s) C(s)) / s is finite at zero, as C integrates. So e(t) = 2/pi int Re E(j omega) cos(omega t) d
omega, with Re E linear between frequencies.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.control_system import System
from workbench.design.matrices import Complex, DesignError
from workbench.design.pid_design.process import Process

FINE, REACH = 5.0, 2.0  # times the frequencies of a search, and as far up; half of both for the error
BEYOND, FARTHEST = 3.0, 16.0  # times the fastest root, if that is farther, and the farthest over those of a search
TIMES = 1200
DOUBLINGS = 12
REST = 5e-4  # the share of the integral that the second half of the times may have
STALLED = 0.5  # of the second half before: one that falls no faster is the ripple of what the frequencies leave out
WORST = 0.02  # an error, over the integral, beyond which the integral is refused


@dataclass(frozen=True)
class AbsoluteError:
    """The integral of |e| and an estimate of its error, from half the frequencies, half the times and the end."""

    value: float
    error: float


@dataclass(frozen=True, eq=False)
class LoadResponse:
    """The map from Re E at some frequencies, which is linear between them, to the error e at some times."""

    omega: Array
    inverse: Complex
    t: Array
    waves: Array

    @staticmethod
    def of(process: Process, omega: Array, t: Array) -> LoadResponse:
        """The map for a process."""
        cosines = -np.cos(np.outer(t, omega)) / t[:, np.newaxis] ** 2
        slopes = np.diff(cosines, axis=1) / np.diff(omega)  # the kinks of a function, taken over to its values
        waves = np.zeros_like(cosines)
        waves[:, :-1] += slopes
        waves[:, 1:] -= slopes
        waves[:, -1] += np.sin(omega[-1] * t) / t
        return LoadResponse(omega, process.inverse(omega), t, 2 / np.pi * waves)

    def errors(self, laws: Complex) -> Array:
        """e at the times for laws at the frequencies, (n, nw) to (n, nt); they must integrate and stabilise."""
        E = (1 / (self.inverse + laws) / (1j * self.omega)).real
        return np.asarray(E @ self.waves.T)

    def integrals(self, laws: Complex) -> Array:
        """The integrals of |e| over the times from 0, by the trapezoidal rule."""
        return np.asarray(np.trapezoid(np.abs(self.errors(laws)), self.t, axis=-1))


def times(span: float, count: int) -> Array:
    """Times up to a span, without 0."""
    return np.linspace(0, span, count)[1:]


def integral_absolute_error(plant: System, delay: float, law: System) -> AbsoluteError:
    """The integral of |e| after a unit step of load, for a stable loop of a plant with delay and a law of the error."""
    process = Process.of("integral_absolute_error", plant, delay)
    num, den = law.num[0][0], law.den[0][0]
    found = absolute_error(process, num, den)
    if not found.error <= WORST * found.value:
        raise DesignError(
            f"`PidDesign.IAE`: it is {found.value:.4g} with an error of about {found.error:.1g}, too large for a "
            "figure. The loop is hardly damped, or its parts differ too much in speed; simulate it."
        )
    return found


def absolute_error(process: Process, num: Array, den: Array) -> AbsoluteError:
    """The same for the polynomials of the law, whose denominator has a factor s; the error may be large."""
    corner = float(np.abs(np.roots(den)).max(initial=0))
    parts = []
    for share in (1.0, 0.5):
        omega = response_frequencies(process, corner, share)
        parts.append((omega, np.polyval(num, 1j * omega) / np.polyval(den, 1j * omega)))
    (omega, law), (fewer, their_law) = parts
    whole = float(abs(np.polyval(den[:-1], 0.0) / num[-1]))  # the integral of the error itself
    span, before = first_span(process, omega, law), math.inf
    for doubling in range(DOUBLINGS):
        t = times(span, TIMES + 1)
        e = LoadResponse.of(process, omega, t).errors(law)
        sum_, rest = _halves(t, np.abs(e))
        is_over = rest < REST * sum_ or STALLED * before < rest < WORST * sum_
        if is_over and abs(abs(float(np.trapezoid(e, t))) - whole) < WORST * whole:
            break
        span, before = span * (2 if doubling < DOUBLINGS - 1 else 1), rest
    coarse = float(LoadResponse.of(process, fewer, t).integrals(their_law))
    half = float(np.trapezoid(np.abs(e[1::2]), t[1::2]))
    missing = max(0.0, whole - sum_)
    return AbsoluteError(sum_ + missing, abs(coarse - sum_) + abs(half - sum_) + rest + missing)


def response_frequencies(process: Process, corner: float, share: float) -> Array:
    """Frequencies for the response of a loop to a load, up to where the process itself falls, or a share of them."""
    fastest = max((float(np.abs(part).max(initial=0)) for part in process.roots), default=0.0)
    reach = BEYOND * fastest / float(process.frequencies(corner=corner)[-1])
    return process.frequencies(FINE * share, min(max(REACH, reach), FARTHEST) * share, corner)


def first_span(process: Process, omega: Array, law: Complex) -> float:
    """A time in which much of the error of a loop is over."""
    error = (1 / (process.inverse(omega) + law) / (1j * omega)).real
    return 5 / float(omega[np.argmax(np.abs(error) < 0.5 * np.abs(error[0]))])


def _halves(t: Array, sizes: Array) -> tuple[float, float]:
    """The integral, and that of the second half of the times."""
    middle = len(t) // 2
    sum_ = float(np.trapezoid(sizes, t)) + 0.5 * float(t[0] * sizes[0])
    rest = float(np.trapezoid(sizes[middle:], t[middle:]))
    return (sum_, rest) if math.isfinite(sum_) else (math.inf, math.inf)

"""The error after a step of load at the input of a plant with delay, from its frequency response.

E(s) = P(s) / (1 + P(s) C(s)) / s is finite at zero, as C integrates. So e(t) = 2/pi int Re E(j omega) cos(omega t) d
omega, with Re E linear between frequencies.
"""

from __future__ import annotations

import math

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.control_system import System
from workbench.design.pid_design.process import Process

FINE = 5.0  # times the frequencies of a search
REACH = 2.0  # times as far up
TIMES = 1200
DOUBLINGS = 10


def integral_absolute_error(plant: System, delay: float, law: System) -> float:
    """The integral of |e| after a unit step of load, for a stable loop of a plant with delay and a law of the error."""
    process = Process.of("integral_absolute_error", plant, delay)
    return absolute_error(process, law.num[0][0], law.den[0][0])


def absolute_error(process: Process, num: Array, den: Array) -> float:
    """The same for the polynomials of the law, whose denominator has a factor s."""
    omega = process.frequencies(FINE, REACH)
    s = 1j * omega
    law = np.polyval(num, s) / np.polyval(den, s)
    error = (1 / (process.inverse(omega) + law) / s).real
    whole = float(abs(np.polyval(den[:-1], 0.0) / num[-1]))  # the integral of the error itself
    span, sum_ = 5 / float(omega[np.argmax(np.abs(error) < 0.5 * np.abs(error[0]))]), math.inf
    for _ in range(DOUBLINGS):
        t = np.linspace(0, span, TIMES)[1:]
        e = _cosine_transform(omega, error, t)
        sum_ = float(np.trapezoid(np.abs(e), t))
        rest = float(np.trapezoid(np.abs(e[TIMES // 2 :]), t[TIMES // 2 :]))
        if rest < 1e-3 * sum_ and abs(abs(float(np.trapezoid(e, t))) - whole) < 0.02 * whole:
            break
        span *= 2
    return max(sum_, whole)


def _cosine_transform(omega: Array, values: Array, t: Array) -> Array:
    """2/pi times the integral of a function that is linear between frequencies, times cos(omega t)."""
    slopes = np.diff(values) / np.diff(omega)
    kinks = np.diff(slopes, prepend=0.0, append=0.0)
    waves = -(kinks * np.cos(np.outer(t, omega))).sum(axis=1) / t**2
    ends = values[-1] * np.sin(omega[-1] * t) / t
    return np.asarray(2 / np.pi * (waves + ends))

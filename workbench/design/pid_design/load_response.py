"""The error after a step of load at the input of a plant with delay, from its frequency response.

E(s) = P(s) / (1 + P(s) C(s)) / s is finite at zero, as C integrates. So e(t) = 2/pi int Re E(j omega) cos(omega t) d
omega, with Re E linear between frequencies.
"""

from __future__ import annotations

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.control_system import System
from workbench.design.pid_design.process import Process

FINE = 8.0  # times the frequencies of a search
TIMES = 1200


def integral_absolute_error(plant: System, delay: float, law: System) -> float:
    """The integral of |e| after a unit step of load, for a stable loop of a plant with delay and a law of the error."""
    process = Process.of("integral_absolute_error", plant, delay)
    return absolute_error(process, law.num[0][0], law.den[0][0])


def absolute_error(process: Process, num: Array, den: Array) -> float:
    """The same for the polynomials of the law, whose denominator has a factor s."""
    omega = process.frequencies(FINE, 4.0)
    s = 1j * omega
    law = np.polyval(num, s) / np.polyval(den, s)
    error = (1 / (process.inverse(omega) + law) / s).real
    total = abs(np.polyval(den[:-1], 0.0) / num[-1])
    # a span in which the error dies: doubled until its second half adds little
    span = 20 * total * abs(num[-1]) / max(abs(np.polyval(num, 0.0)), 1e-300) if total else 1.0
    span = max(span, 5 / omega[np.argmax(np.abs(error) < 0.5 * np.abs(error[0]))])
    sum_ = 0.0
    for _ in range(12):
        t = np.linspace(0, span, TIMES)[1:]
        e = _cosine_transform(omega, error, t)
        sum_ = float(np.trapezoid(np.abs(e), t))
        if np.trapezoid(np.abs(e[TIMES // 2 :]), t[TIMES // 2 :]) < 1e-4 * sum_:
            break
        span *= 2
    return sum_


def _cosine_transform(omega: Array, values: Array, t: Array) -> Array:
    """2/pi times the integral of a function that is linear between frequencies, times cos(omega t)."""
    slopes = np.diff(values) / np.diff(omega)
    kinks = np.diff(slopes, prepend=0.0, append=0.0)
    waves = -(kinks * np.cos(np.outer(t, omega))).sum(axis=1) / t**2
    ends = values[-1] * np.sin(omega[-1] * t) / t - values[0] * 0
    return np.asarray(2 / np.pi * (waves + ends))

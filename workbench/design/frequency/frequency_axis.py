"""Frequencies at which a system is asked for answers, and the phase of these without jumps."""

from __future__ import annotations

import math

import numpy as np

from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array, numbers
from workbench.design.matrices import Complex

TIE = 10.0  # degrees below 180, from which on a first phase is taken as -180

ROUNDING = 1e-12  # relative, of the quotient that is Nyquist's frequency


def checked_frequencies(call: str, frequencies: Numbers, period: float | None) -> Array:
    """Frequencies (m,) in rad/s that rise from zero on, up to Nyquist's in a computer."""
    omega = numbers(call, frequencies, 1)
    if not omega.size:
        raise ValueError(f"`{call}` must have at least one frequency in rad/s; got an empty range.")
    odd = omega[~np.isfinite(omega) | (omega < 0)]
    if odd.size:
        raise ValueError(f"`{call}` must be finite frequencies in rad/s, from zero on; got {odd[0]:g} among them.")
    if (np.diff(omega) < 0).any():
        raise ValueError(
            f"`{call}` must rise, in rad/s; got a range that falls, from {omega[0]:g} to {omega[-1]:g}: turn it round."
        )
    if period is not None and omega[-1] > math.pi / period * (1 + ROUNDING):
        raise ValueError(
            f"`{call}` must not exceed Nyquist's frequency pi / h = {math.pi / period:.6g} rad/s of the period "
            f"{period:g} s, above which samples repeat what they are below it; got {omega[-1]:.6g} rad/s."
        )
    return omega


def low_slope(omega: Array, values: Complex) -> int:
    """The slope of the gain at the lowest frequencies, in decades per decade: -1 for an integrator."""
    held = np.flatnonzero(np.isfinite(values) & (values != 0) & (omega > 0))[:2]
    if len(held) < 2:
        return 0
    (w0, w1), (v0, v1) = omega[held], np.abs(values[held])
    return round(math.log(v1 / v0) / math.log(w1 / w0)) if w1 > w0 else 0


def phases(omega: Array, values: Complex) -> Array:
    """The phase (m,) in degrees without jumps; the first lies from -190 to 170 about 90 times the slope of the gain."""
    held = np.isfinite(values) & (values != 0)
    phase = np.full(len(values), np.nan)
    if held.any():
        angles = np.degrees(np.unwrap(np.angle(values[held])))
        turns = math.floor((angles[0] - 90 * low_slope(omega, values) + 180 + TIE) / 360)
        phase[held] = angles - 360 * turns
    return phase

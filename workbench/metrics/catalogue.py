"""The metrics by the names they have in the field."""

from __future__ import annotations

import casadi as ca
import numpy as np

from workbench.metrics.integral import Integral
from workbench.metrics.sampled import Peak, SampledRms, TotalVariation
from workbench.metrics.step_response import Overshoot, SettlingTime
from workbench.validation.doors import door
from workbench.validation.words import Array, finite, known, positive, seconds

OBSERVED = {"q_error": "rad", "qd_error": "rad/s", "d_error": "N m"}


def _whole(integral: Array, horizon: float) -> Array:
    del horizon
    return integral


def _root_mean(integral: Array, horizon: float) -> Array:
    return np.sqrt(np.maximum(integral, 0) / horizon)


def _named(name: str, signal: str) -> str:
    return name if signal == "e" else f"{name} of {signal}"


@door
def rmse(signal: str = "e", unit: str | None = None, name: str | None = None) -> Integral:
    """sqrt(1/T integral of e^2 dt): what (43) of the paper becomes as its samples grow dense.

    Without a unit it has that of the signal, and without a name that of the metric and the signal.
    """
    about = f"root mean square of {signal}"
    return Integral(
        name or _named("RMSE", signal), unit or "", about, lambda t, y: y[signal] ** 2, _root_mean, (signal,)
    )


@door
def sampled_rmse(sample: float, signal: str = "e", unit: str | None = None, name: str | None = None) -> SampledRms:
    """sqrt(1/N sum of e(t_k)^2), equation (43) of the paper, on a grid of `sample` s that begins at t = 0."""
    sample = seconds("sampled_rmse(sample=...)", sample)
    about = f"root mean square of {signal} over samples every {1000 * sample:g} ms"
    return SampledRms(name or _named("RMSE (43)", signal), unit or "", about, signal, sample)


def iae() -> Integral:
    """Integral of |e| dt."""
    return Integral("IAE", "rad s", "integral of |e|", lambda t, y: ca.fabs(y["e"]), _whole)


def ise() -> Integral:
    """Integral of e^2 dt."""
    return Integral("ISE", "rad^2 s", "integral of e^2", lambda t, y: y["e"] ** 2, _whole)


def itae() -> Integral:
    """Integral of t |e| dt."""
    return Integral("ITAE", "rad s^2", "integral of t |e|", lambda t, y: t * ca.fabs(y["e"]), _whole)


def effort() -> Integral:
    """Root mean square of the torque that acts."""
    about = "root mean square of the applied torque"
    return Integral("effort", "N m", about, lambda t, y: y["tau_applied"] ** 2, _root_mean, ("tau_applied",))


def energy() -> Integral:
    """Integral of |tau qd| dt: the mechanical energy moved either way, none of it recovered."""
    about = "integral of |tau qd|, nothing recovered"
    return Integral(
        "energy", "J", about, lambda t, y: ca.fabs(y["tau_applied"] * y["qd"]), _whole, ("tau_applied", "qd")
    )


@door
def observer_error(signal: str) -> Integral:
    """Root mean square of an observer's error: `q_error`, `qd_error` or `d_error`."""
    signal = known(signal, OBSERVED, "errors of an observer")
    return rmse(signal, OBSERVED[signal], f"RMS {signal}")


def peak_error() -> Peak:
    """Largest |e|."""
    return Peak("peak error", "rad", "largest |e|", "e")


@door
def late_error(after: float) -> Peak:
    """Largest |e| from `after` s on: what the steady state leaves, once the start is forgotten."""
    after = finite("late_error(after=...)", after, " of seconds", low=0)
    return Peak("late error", "rad", f"largest |e| from {after:g} s on", "e", after)


def peak_torque() -> Peak:
    """Largest |tau| that acts."""
    return Peak("peak torque", "N m", "largest |tau| applied", "tau_applied")


@door
def total_variation(sample: float) -> TotalVariation:
    """Total variation of the applied torque per second on a grid of `sample` s."""
    sample = seconds("total_variation(sample=...)", sample)
    about = f"total variation of the applied torque per second, sampled every {1000 * sample:g} ms"
    return TotalVariation("TV", "N m/s", about, "tau_applied", sample)


def overshoot() -> Overshoot:
    """Largest excursion beyond the new level after a jump of the reference, in percent of the jump."""
    return Overshoot("overshoot", "%", "largest excursion beyond a new level, in percent of the jump")


@door
def settling_time(band: float = 0.02) -> SettlingTime:
    """Longest time after a jump of the reference until the error stays within `band` of the jump."""
    band = positive("settling_time(band=...)", band)
    about = f"longest time after a jump until the error stays within {100 * band:g} % of the jump"
    return SettlingTime("settling time", "s", about, band)

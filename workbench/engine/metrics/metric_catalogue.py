"""The metrics by the names they have in the field, of any signal, in its unit.

Without a signal a metric of an error is of the errors of what the loop follows, and one of an input of what acts on the
plant where it is driven. With the name of a signal that follows a reference it is of the error of that signal, with any
other of the signal itself.
"""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca
import numpy as np

from workbench.core.units import SECOND, read
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array, describe, finite, numbers, positive, refusal, seconds, vector
from workbench.core.validation.signatures import check_arguments
from workbench.engine.metrics.contract import Integral
from workbench.engine.metrics.energy import Energy
from workbench.engine.metrics.signal_choice import SignalChoice
from workbench.engine.metrics.step_metrics import Overshoot, Peak, SampledRms, SettlingTime, TotalVariation


def _whole(integral: Array, horizon: float) -> Array:
    return integral


def _root_mean(integral: Array, horizon: float) -> Array:
    return np.sqrt(np.maximum(integral, 0) / horizon)


def _square(t: ca.SX, e: ca.SX) -> ca.SX:
    return e**2


def _name_of(name: str, signal: str | None) -> str:
    return name if signal is None else f"{name} of {signal}"


def _error(
    name: str,
    signal: str | None,
    about: str,
    g: Callable[[ca.SX, ca.SX], ca.SX],
    finish: Callable[[Array, float], Array],
    measure: Callable[[str], str] = str,
) -> Integral:
    """An integral of the error of a signal."""
    return Integral(name, "", about, g, finish, signal=SignalChoice("error", signal), measure=measure)


def _over_time(order: int, seconds: int) -> Callable[[str], str]:
    """The unit of an integral over time: powers of the units of the signal and of time, multiplied."""
    return lambda unit: str(read(unit) ** order * SECOND**seconds)


@check_arguments
def rmse(signal: str | None = None, name: str | None = None) -> Integral:
    """Root mean square error, sqrt(1/T integral of e^2 dt): the limit of `sampled_rmse` for dense samples.

    The error e is that of the output `signal`, or of each output that follows a reference. `name` replaces "RMSE".

    Examples
    --------
    >>> law = wb.PID(wb.DCMotor().outputs, wb.DCMotor().inputs, Kp=100.0, Ki=200.0)
    >>> loop = wb.ClosedLoop(wb.DCMotor(), controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    >>> wb.measure(loop.ode(), [wb.rmse()], until=5.0, h=1e-3).score("RMSE").value.round(3)
    array([0.122])
    """
    return _error(name or _name_of("RMSE", signal), signal, "root mean square of {}", _square, _root_mean)


@check_arguments
def sampled_rmse(sample: float, signal: str | None = None, name: str | None = None) -> SampledRms:
    """Root mean square of samples of the error, sqrt(1/N sum of e(t_k)^2), every `sample` s from t = 0 on.

    References
    ----------
    Long (2025), equation (43), doi:10.54939/1859-1043.j.mst.107.2025.13-23.
    """
    sample = seconds("sampled_rmse(sample=...)", sample)
    about = f"root mean square of {{}} over samples every {1000 * sample:g} ms"
    return SampledRms(name or _name_of("sampled RMSE", signal), "", about, SignalChoice("error", signal), sample)


@check_arguments
def iae(signal: str | None = None) -> Integral:
    """Integral of |e| dt, with the error e of `signal` or of each output that follows a reference.

    Examples
    --------
    >>> from workbench.engine.metrics import iae, ise, itae, late_error, peak, sampled_rmse
    >>> law = wb.PID(wb.DCMotor().outputs, wb.DCMotor().inputs, Kp=100.0, Ki=200.0)
    >>> loop = wb.ClosedLoop(wb.DCMotor(), controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    >>> metrics = [iae(), ise(), itae(), peak("omega"), late_error(0.5), sampled_rmse(0.1)]
    >>> wb.measure(loop.ode(), metrics, until=1.0, h=1e-3).values.round(3)
    array([[[0.147, 0.075, 0.026, 1.305, 0.088, 0.338]]])
    """
    size = _over_time(1, 1)
    return _error(_name_of("IAE", signal), signal, "integral of |{}|", lambda t, e: ca.fabs(e), _whole, size)


@check_arguments
def ise(signal: str | None = None) -> Integral:
    """Integral of e^2 dt, with the error e of `signal` or of each output that follows a reference."""
    return _error(_name_of("ISE", signal), signal, "integral of {}^2", _square, _whole, _over_time(2, 1))


@check_arguments
def itae(signal: str | None = None) -> Integral:
    """Integral of t |e| dt, with the error e of `signal` or of each output that follows a reference."""
    size = _over_time(1, 2)
    return _error(_name_of("ITAE", signal), signal, "integral of t |{}|", lambda t, e: t * ca.fabs(e), _whole, size)


@check_arguments
def effort(signal: str | None = None) -> Integral:
    """Root mean square of `signal`, by default of each input of the plant, as it acts on the plant.

    Examples
    --------
    >>> law = wb.PID(wb.DCMotor().outputs, wb.DCMotor().inputs, Kp=100.0, Ki=200.0)
    >>> loop = wb.ClosedLoop(wb.DCMotor(), controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    >>> wb.measure(loop.ode(), [wb.effort("v")], until=5.0, h=1e-3).score("effort of v").value.round(3)
    array([16.238])
    """
    about = "root mean square of {}"
    return Integral(_name_of("effort", signal), "", about, _square, _root_mean, signal=SignalChoice("input", signal))


@check_arguments
def energy(power: tuple[str, str] | None = None) -> Energy:
    """Integral of |u v| dt of an effort u and a flow v: the energy moved either way, none of it recovered.

    `power` names two signals whose product is a power, such as a voltage and its current. By default they are those
    that the plant of the loop declares by its `power`.

    Examples
    --------
    >>> @wb.block
    ... class Mass(wb.Plant):
    ...     v: float = wb.initial(default=0.0, unit="m/s")
    ...     inputs, outputs, power = wb.layout(F="N"), wb.layout(v="m/s"), ("F", "v")
    ...     def rate(self, t, x, u):
    ...         return {"v": u.F / 2.0}
    >>> law = wb.PID(Mass().outputs, Mass().inputs, Kp=10.0)
    >>> loop = wb.ClosedLoop(Mass(), controller=law, reference=wb.Step("v", "m/s", 1.0))
    >>> wb.measure(loop.ode(), [wb.metrics.energy()], until=10.0, h=1e-2).score("energy").value.round(6)
    array([1.])
    """
    return Energy("energy" if power is None else f"energy of {' '.join(power)}", "", "", power=power)


@check_arguments
def observer_error(signal: str) -> Integral:
    """Root mean square of the error of an observer: `x_error` = x - x_hat of a signal x that it estimates.

    Examples
    --------
    >>> wb.metrics.observer_error("omega_error").name
    'RMS omega_error'
    """
    return Integral(f"RMS {signal}", "", "root mean square of {}", _square, _root_mean, signal=signal)


@check_arguments
def peak_error(signal: str | None = None) -> Peak:
    """Largest |e|, with the error e of `signal` or of each output that follows a reference.

    Examples
    --------
    >>> law = wb.PID(wb.DCMotor().outputs, wb.DCMotor().inputs, Kp=100.0, Ki=200.0)
    >>> loop = wb.ClosedLoop(wb.DCMotor(), controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    >>> wb.measure(loop.ode(), [wb.peak_error()], until=5.0, h=1e-3).score("peak error").value.round(3)
    array([1.])
    """
    return Peak(_name_of("peak error", signal), "", "largest |{}|", SignalChoice("error", signal))


@check_arguments
def late_error(after: float, signal: str | None = None) -> Peak:
    """Largest |e| from `after` s on: the error of the steady state, after the transient."""
    after = finite("late_error(after=...)", after, " of seconds", low=0)
    return Peak(
        _name_of("late error", signal), "", f"largest |{{}}| from {after:g} s on", SignalChoice("error", signal), after
    )


@check_arguments
def peak(signal: str | None = None) -> Peak:
    """Largest absolute value of `signal`, by default of each input of the plant, as it acts on the plant."""
    return Peak(_name_of("peak", signal), "", "largest |{}|", SignalChoice("input", signal))


@check_arguments
def violation(signal: str, low: Numbers | None = None, high: Numbers | None = None) -> tuple[Peak, Integral]:
    """Two metrics: the largest distance of a signal beyond its limits, and the seconds for which it is beyond.

    `low` and `high` are one number for the whole signal, or one for each of its components; give at least one.

    Examples
    --------
    >>> law = wb.PID(wb.DCMotor().outputs, wb.DCMotor().inputs, Kp=100.0, Ki=200.0)
    >>> loop = wb.ClosedLoop(wb.DCMotor(), controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    >>> found = wb.measure(loop.ode(), wb.metrics.violation("omega", high=1.1), until=5.0, h=1e-3)
    >>> [float(score.value.round(3)[0]) for score in found.scores]
    [0.205, 0.18]
    """
    least, most = _limit("low", low, -np.inf), _limit("high", high, np.inf)
    sizes = {limit.size for limit in (least, most)} - {1}
    if len(sizes) > 1 or not np.all(least < most) or np.isinf([*least, *most]).all():
        raise ValueError(
            "`violation(low=..., high=...)` must be numbers with room between them, at least one of them finite, and "
            f"one for all or one for each number of the signal; got {describe(low)} and {describe(high)}."
        )

    def beyond(e: ca.SX) -> ca.SX:
        for limit in (least, most):
            vector("violation(low=..., high=...)", limit, limit.size if limit.size == 1 else e.numel(), "signal")
        above, below = e - ca.DM(most), ca.DM(least) - e
        return ca.if_else(above > below, above, below)

    def outside(t: ca.SX, e: ca.SX) -> ca.SX:
        far = beyond(e)
        return ca.if_else(far > 0, 1, ca.if_else(far <= 0, 0, far))  # which is no number where e is none

    of, ends = SignalChoice("input", signal), (("below", low), ("above", high))
    where = " or ".join(f"{side} {describe(end)}" for side, end in ends if end is not None)
    return (
        Peak(f"violation of {signal}", "", f"how far {{}} is {where} at worst", of, size=beyond),
        Integral(f"time of violation of {signal}", "s", f"time in which {{}} is {where}", outside, _whole, signal=of),
    )


def _limit(side: str, values: Numbers | None, none: float) -> Array:
    call = f"violation({side}=...)"
    limit = np.atleast_1d(numbers(call, none if values is None else values).squeeze())
    if limit.ndim > 1:
        raise refusal(call, "a number, or a vector of them", values)
    return limit


@check_arguments
def total_variation(sample: float, signal: str | None = None, after: float = 0.0) -> TotalVariation:
    """Total variation divided by time, of `signal`, by default of each input of the plant, on a grid of `sample` s.

    With `after` it is taken from `after` s on, when the transient is over; its name is then 'late TV'.

    Examples
    --------
    >>> law = wb.PID(wb.DCMotor().outputs, wb.DCMotor().inputs, Kp=100.0, Ki=200.0)
    >>> loop = wb.ClosedLoop(wb.DCMotor(), controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    >>> wb.measure(loop.ode(), [wb.total_variation(1e-3)], until=5.0, h=1e-3).score("TV").value.round(3)
    array([34.388])
    """
    sample = seconds("total_variation(sample=...)", sample)
    after = finite("total_variation(after=...)", after, " of seconds", low=0)
    late, since = ("late TV", f" from {after:g} s on") if after else ("TV", "")
    about = f"total variation of {{}} per second{since}, sampled every {1000 * sample:g} ms"
    return TotalVariation(_name_of(late, signal), "", about, SignalChoice("input", signal), sample, after)


@check_arguments
def overshoot(signal: str | None = None) -> Overshoot:
    """Largest excursion beyond the new level after a jump of the reference, in percent of the jump.

    Examples
    --------
    >>> law = wb.PID(wb.DCMotor().outputs, wb.DCMotor().inputs, Kp=100.0, Ki=200.0)
    >>> loop = wb.ClosedLoop(wb.DCMotor(), controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    >>> wb.measure(loop.ode(), [wb.overshoot()], until=5.0, h=1e-3).score("overshoot").value.round(3)
    array([30.491])
    """
    about = "largest excursion beyond a new level, in percent of the jump"
    return Overshoot(_name_of("overshoot", signal), "%", about, SignalChoice("level", signal))


@check_arguments
def settling_time(signal: str | None = None, band: float = 0.02) -> SettlingTime:
    """Longest time after a jump of the reference until the error stays within `band` of the jump.

    Examples
    --------
    >>> law = wb.PID(wb.DCMotor().outputs, wb.DCMotor().inputs, Kp=100.0, Ki=200.0)
    >>> loop = wb.ClosedLoop(wb.DCMotor(), controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    >>> wb.measure(loop.ode(), [wb.settling_time()], until=5.0, h=1e-3).score("settling time").value.round(3)
    array([0.774])
    """
    band = positive("settling_time(band=...)", band)
    about = f"longest time after a jump until the error stays within {100 * band:g} % of the jump"
    return SettlingTime(_name_of("settling time", signal), "s", about, band, SignalChoice("level", signal))

"""First-order models with a delay: from a plant by the half rule, or from a step response by its areas."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array, finite, numbers
from workbench.core.validation.signatures import check_arguments
from workbench.design.matrices import DesignError
from workbench.design.pid_design.pi_optimum import checked_process
from workbench.design.pid_design.process import Process

if TYPE_CHECKING:
    import control

REAL = 1e-6  # the imaginary part, over the size, below which a pole or zero counts as real


@dataclass(frozen=True)
@show
class StepModel:
    """The model K exp(-L s) / ((T s + 1) (T2 s + 1)), or K exp(-L s) / (s (T2 s + 1)) with `integrating`.

    K is in the unit of the output over that of the input, and over s if the model integrates. T, T2 and L are in s.
    `error` is the largest distance from a recorded step response, as a part of its final change; it is None for the
    model of a plant.
    """

    K: float
    T: float
    L: float
    T2: float = 0.0
    integrating: bool = False
    error: float | None = None

    @property
    def slope(self) -> float:
        """The first slope K / T of the response, or K if the model integrates."""
        return self.K if self.integrating else self.K / self.T if self.T else math.inf


@check_arguments
def half_rule_model(
    plant: control.TransferFunction | control.StateSpace, delay: float = 0.0, order: int = 1
) -> StepModel:
    """The model of first or second order with a delay that the half rule makes from a stable or integrating plant.

    Of the largest lag that is left out, one half is added to the last lag of the model and one half to the delay.
    Smaller lags and the time constants of zeros in the right half-plane are added to the delay. Before that, zeros in
    the left half-plane cancel lags near them.

    Parameters
    ----------
    plant, delay
        As for `pi_optimum`; with real poles and zeros, at most one pole at the origin and none in the right half-plane.
    order
        1 or 2.

    Raises
    ------
    ValueError
        If `plant` is not such a system, or `order` is neither 1 nor 2.
    DesignError
        If the plant has a complex or unstable pole, or a complex zero.

    References
    ----------
    Skogestad (2003), Simple analytic rules for model reduction and PID controller tuning, J. Process Control 13.

    Examples
    --------
    >>> import control
    >>> model = wb.pid_design.half_rule_model(control.tf([1], [6.4e-5, 0.009984, 0.25792, 1.248, 1]))
    >>> round(model.T, 3), round(model.L, 3)
    (1.1, 0.148)
    """
    if order not in (1, 2):
        raise ValueError(f"`half_rule_model(order=...)` must be 1 or 2, as SIMC has no rule for more; got {order}.")
    process = checked_process("half_rule_model", plant, delay)
    lags, leads, inverse, integrating = _time_constants(process)
    gain = process.num[-1] / process.den[-1 if not integrating else -2]
    lags, gain, slow = _cancel_leads(lags, leads, gain)
    late = process.delay + sum(inverse) + slow
    kept = order - 1 if integrating else order
    first, rest = lags[:kept], lags[kept:]
    if rest:
        late += rest[0] / 2 + sum(rest[1:])
        if first:
            first[-1] += rest[0] / 2
    if integrating:
        return StepModel(float(gain), math.inf, late, first[0] if first else 0.0, True)
    first += [0.0] * (2 - len(first))
    return StepModel(float(gain), first[0], late, first[1])


def _time_constants(process: Process) -> tuple[list[float], list[float], list[float], bool]:
    """The lags, the leads, the times of inverse response, each the largest first, and if the plant integrates."""
    zeros, poles = process.roots
    size = max(float(np.abs(poles).max(initial=0)), 1e-300)
    origin = np.abs(poles) < 1e-12 * size if len(poles) > 1 else np.abs(poles) == 0
    for name, roots in (("pole", poles), ("zero", zeros)):
        odd = [r for r in roots if abs(r.imag) > REAL ** (1 / max(len(roots), 1)) * abs(r)]
        if odd:
            raise DesignError(
                f"`half_rule_model(plant)` takes real poles and zeros, as the half rule is for lags; the {name} "
                f"{odd[0]:.4g} is complex. Take `pi_optimum`, which takes any plant."
            )
    if (poles[~origin].real > 0).any() or origin.sum() > 1 or (zeros == 0).any():
        raise DesignError(
            "`half_rule_model(plant)` takes stable plants, with one pole at the origin at most; this one has a pole in "
            "the right half-plane, two at the origin, or a zero there. Take `pi_optimum`, which takes any plant."
        )
    lags = sorted((-1 / poles[~origin].real).tolist(), reverse=True)
    leads = sorted((-1 / zeros[zeros.real < 0].real).tolist(), reverse=True)
    inverse = sorted((1 / zeros[zeros.real > 0].real).tolist(), reverse=True)
    return lags, leads, inverse, bool(origin.any())


def _cancel_leads(lags: list[float], leads: list[float], gain: float) -> tuple[list[float], float, float]:
    """The lags and the gain after each lead, the largest first, has cancelled a lag near it (rules T1 to T3).

    A lead without a lag left takes its time from the delay.
    """
    lags, slow = list(lags), 0.0
    for lead in leads:
        larger = [lag for lag in lags if lag >= lead]
        smaller = [lag for lag in lags if lag < lead]
        if not lags:
            slow -= lead
            continue
        above, below = (larger[-1] if larger else None), (smaller[0] if smaller else None)
        if above is not None and (below is None or above / lead <= lead / below):
            lags.remove(above)
            lags = sorted([*lags, above - lead] if above > lead else lags, reverse=True)
        elif below is not None:
            lags.remove(below)
            gain *= lead / below
    return lags, gain, slow


@check_arguments
def step_model(t: Numbers, y: Numbers, step: float = 1.0) -> StepModel:
    """The model K exp(-L s) / (T s + 1) of a recorded step response, by the method of areas.

    The area between the response and its final value is K (L + T). T is e / K times the area below the response up to
    the time L + T. The response must have settled at the end of the record.

    Parameters
    ----------
    t
        (N,) times in s after the step, increasing, at least 20.
    y
        (N,) the response, of which the first value is the one before the step.
    step
        The height of the step of the input, in its unit.

    Raises
    ------
    ValueError
        If the record is not as above, or `step` is 0.
    DesignError
        If the response has not settled, or is not like that of a lag with a delay.

    References
    ----------
    Astrom and Hagglund (2006), Advanced PID Control.

    Examples
    --------
    >>> t = np.linspace(0.0, 20.0, 2001)
    >>> model = wb.pid_design.step_model(t, np.where(t > 1, 2 * (1 - np.exp(-(t - 1) / 2)), 0.0))
    >>> round(model.K, 2), round(model.T, 2), round(model.L, 2)
    (2.0, 2.0, 1.0)
    """
    t0, share, change, height = _checked_record(t, y, step)
    residence = float(np.trapezoid(1 - share, t0))
    inside = np.linspace(0, max(residence, 0.0), 2001)
    T = math.e * float(np.trapezoid(np.interp(inside, t0, share), inside))
    if not 0 < T <= 1.5 * residence:
        raise DesignError(
            "`step_model(t, y)` fits a lag with a delay, and the areas of this response belong to none: it overshoots, "
            "or goes the other way first. Fit a model of its own, and take `pi_optimum`."
        )
    L = max(residence - T, 0.0)
    model = np.where(t0 > L, 1 - np.exp(-np.maximum(t0 - L, 0) / T), 0.0)
    return StepModel(change / height, T, L, error=float(np.abs(model - share).max()))


def _checked_record(t: Numbers, y: Numbers, step: float) -> tuple[Array, Array, float, float]:
    """The times from the first, the response over its final change, that change, and the height of the step."""
    times, values = numbers("step_model(t=...)", t, 1), numbers("step_model(y=...)", y, 1)
    height = finite("step_model(step=...)", step)
    if len(times) < 20 or len(times) != len(values) or not (np.diff(times) > 0).all() or height == 0:
        raise ValueError(
            "`step_model(t, y, step)` needs at least 20 increasing times, a value for each, and a step that is not 0; "
            f"got {len(times)} times, {len(values)} values and a step of {height:g}."
        )
    last = max(len(times) // 20, 3)
    start, end = float(values[0]), float(values[-last:].mean())
    change = end - start
    if change == 0 or float(np.ptp(values[-2 * last :])) > 0.05 * abs(change):
        raise DesignError(
            "`step_model(t, y)` needs a response that has settled at the end of its record: in the last tenth this one "
            f"moves by {np.ptp(values[-2 * last :]):.3g} of {abs(change):.3g}. Record longer."
        )
    return times - times[0], (values - start) / change, change, height

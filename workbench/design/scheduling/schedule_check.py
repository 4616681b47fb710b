"""The check of a gain-scheduled loop: its linear model at the points of the design and between them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, is_dataclass, replace
from typing import Protocol, cast

import numpy as np

from workbench.core.equations import Loop
from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array, refusal, whole
from workbench.core.validation.signatures import check_arguments
from workbench.design.linear_loop.linear_loop import LinearLoop
from workbench.design.linear_loop.loop_linearization import linear_loop
from workbench.design.linear_loop.loop_remarks import decay_of
from workbench.design.matrices import DesignError

CALL = "check_schedule"
MUST = "a function that returns a `ClosedLoop` or `DigitalLoop` with this law"
BESIDE = 1e-6  # of an interval: how far beside a corner the loop is linearised


@dataclass(frozen=True, eq=False)
@show
class ScheduleCheck:
    """The linear models of a scheduled loop at N values of its scheduling signal: the m points, and values between.

    `decay_rates` (N,) are those of the slowest pole, in 1/s, or 1 - max |z| per period for a `DigitalLoop`; negative if
    the loop is not stable. `Ms` (N,) is the largest peak of the sensitivity over the channels of the cut, `inf` if the
    loop is not stable. `frozen_decay_rates` and `frozen_Ms` belong to the same loop with the numbers of the law held
    constant: they leave out the feedback by numbers that move with the signal (Rugh and Shamma 2000, "hidden
    coupling"). At a value without a linear model all are NaN, and `reasons` says why, by the index of the value.

    The check is a sample: it proves nothing for other values, and nothing for a signal that moves fast.
    """

    values: Array
    points: Array
    decay_rates: Array
    Ms: Array
    frozen_decay_rates: Array
    frozen_Ms: Array
    reasons: Mapping[int, str]

    @property
    def stable(self) -> bool:
        """True if the loop has a linear model at all values, and is stable at each."""
        return bool((self.decay_rates > 0).all())

    def __str__(self) -> str:
        known = np.isfinite(self.decay_rates)
        steady = int((self.decay_rates[known] > 0).sum())
        text = f"stable at {steady} of {len(self.values)} values"
        if known.any():
            slow, sharp = int(np.nanargmin(self.decay_rates)), int(np.nanargmax(self.Ms))
            text += (
                f"; the slowest decay is {self.decay_rates[slow]:.3g} at {self.values[slow]:g}, the largest Ms is "
                f"{self.Ms[sharp]:.3g} at {self.values[sharp]:g}"
            )
            text += f" (with held numbers {np.nanmin(self.frozen_decay_rates):.3g} and {np.nanmax(self.frozen_Ms):.3g})"
        if not known.all():
            text += f"; {(~known).sum()} without a linear model"
        return text


class Schedule(Protocol):
    """A law whose numbers are scheduled over a signal, such as a `ScheduledLaw`."""

    @property
    def points(self) -> Array:
        """The values (m,) of the signal for which the law was designed."""

    @property
    def corners(self) -> Array:
        """The values at which the slope of the numbers jumps."""

    def at(self, value: float) -> object:
        """The law with the numbers that hold at a value of the signal."""


@check_arguments
def check_schedule(law: Schedule, loop_at: Callable[[float], Loop], between: int = 3) -> ScheduleCheck:
    """The stability and the margins of a scheduled loop at the points of its design and between them.

    At each value the loop is linearised at its rest, by exact Jacobians that include the slopes of the scheduled
    numbers. Where a slope jumps, as at both ends, the loop is linearised beside the point, a millionth of the interval
    away.

    Parameters
    ----------
    law
        The scheduled law, a `ScheduledLaw`.
    loop_at
        A function that returns the `ClosedLoop` or `DigitalLoop` of this law that rests at a value of the scheduling
        signal. Only the reference and the initial state should depend on the value.
    between
        The number of values between two points, evenly spaced.

    Raises
    ------
    ValueError
        If the law is not scheduled, or `loop_at` returns no loop with this law.

    Examples
    --------
    >>> temperature, coolant = wb.layout(T="K"), wb.layout(T_c="K")
    >>> laws = [wb.PID(temperature, coolant, Kp=k, Ki=k / 30, u0=300.0) for k in (4.0, 6.0)]
    >>> law = wb.ScheduledLaw(laws, temperature, points=[335.0, 350.0])
    >>> def loop_at(T):
    ...     return wb.ClosedLoop(wb.StirredTank(T=T), controller=law, reference=wb.Constant("T", "K", T))
    >>> check = wb.scheduling.check_schedule(law, loop_at, between=1)
    >>> check.stable, check.values.round(3).tolist()
    (True, [335.0, 342.5, 350.0])
    """
    if not (callable(getattr(law, "at", None)) and hasattr(law, "corners")):
        raise refusal(f"{CALL}(law=...)", "a `ScheduledLaw`", law)
    values = _values(law, whole(f"{CALL}(between=...)", between, 0) + 1)
    scheduled, frozen, reasons = np.full((2, len(values)), np.nan), np.full((2, len(values)), np.nan), {}
    for i, value in enumerate(values.tolist()):
        loop = _loop(loop_at, value)
        held = _held(loop, law, value)
        if held is None:
            raise refusal(f"{CALL}(loop_at=...)", MUST, loop)
        try:
            scheduled[:, i] = _figures(linear_loop(loop))
            frozen[:, i] = _figures(linear_loop(held))
        except DesignError as refused:
            reasons[i] = str(refused)
    return ScheduleCheck(values, law.points, scheduled[0], scheduled[1], frozen[0], frozen[1], reasons)


def _loop(loop_at: Callable[[float], Loop], value: float) -> Loop:
    """The loop at a value; a function that takes no number is refused."""
    try:
        return loop_at(value)
    except TypeError as error:
        raise ValueError(f"`{CALL}(loop_at=...)` must be {MUST}; at {value:g} it failed: {error}.") from error


def _held(loop: object, law: Schedule, value: float) -> Loop | None:
    """The same loop with the numbers of one value of the signal held; None if it is no loop with this law."""
    if not is_dataclass(loop) or isinstance(loop, type):
        return None
    if getattr(loop, "controller", None) is law:
        return cast(Loop, replace(loop, controller=law.at(value)))
    inner = _held(getattr(loop, "loop", None), law, value)  # of a loop in a computer
    return None if inner is None else cast(Loop, replace(loop, loop=inner))


def _values(law: Schedule, count: int) -> Array:
    """The points and `count` - 1 values between two of them; a corner is replaced by the values beside it."""
    values = []
    for low, high in zip(law.points[:-1], law.points[1:], strict=True):
        inside = np.linspace(low, high, count + 1)
        for end, side in ((0, 1.0), (-1, -1.0)):
            if inside[end] in law.corners:
                inside[end] += side * BESIDE * (high - low)
        values.append(inside)
    return np.unique(np.concatenate(values))


def _figures(linear: LinearLoop) -> tuple[float, float]:
    """The decay rate of the slowest pole, and the largest Ms of the channels."""
    decay = min(decay_of(pole, linear.period is not None) for pole in linear.poles)
    if not linear.stable:
        return min(decay, -0.0), np.inf
    return decay, max(one.Ms.gain.value for one in linear.margins().values())

"""The largest setting of a loop, such as its sampling period or a delay, with which its runs keep stated limits."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from workbench.core import Ode, SampledSystem
from workbench.core.equations import Loop, equations_of
from workbench.core.validation.refusals import Array, known_name, numbers, refusal, seconds, several, whole
from workbench.core.validation.signatures import answer, check_arguments
from workbench.engine.metrics import AbstractMetric, measure
from workbench.study.evidence.threshold import Between, Threshold, search

T = TypeVar("T")
ROUNDING = 1e-9  # of a count of steps


@dataclass(frozen=True, eq=False)
@check_arguments
class LoopLimits:
    """Limits that a loop must keep at a setting: its run stays finite, and no number of a metric is above its limit.

    Attributes
    ----------
    loop
        A function from a setting to a loop, such as `lambda T: wb.DigitalLoop(loop, T)` for a sampling period T in s. A
        filter or a law that knows its period must be made anew for each T.
    metrics
        A function from a setting to the metrics, as a metric that samples may do so once a period.
    limits
        From the name of a metric to one number above zero, or to an array (k,) with one for each number of the metric.
    until
        Horizon in s; a run ends at the nearest multiple of its period or step.
    longest_step
        The longest step of the plant in s. A period is divided into the smallest number of equal steps that keep it.
    seed
        The seed of the noise.

    Raises
    ------
    ValueError
        If there is no limit, a limit is not a finite number above zero, or a time is not above zero.

    Examples
    --------
    >>> law = wb.PID(wb.DCMotor().outputs, wb.DCMotor().inputs, Kp=100.0, Ki=200.0)
    >>> loop = wb.ClosedLoop(wb.DCMotor(), controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    >>> kept = wb.LoopLimits(lambda T: wb.DigitalLoop(loop, T), lambda T: [wb.rmse()], {"RMSE": 0.25}, 2.0, 5e-3)
    >>> kept.at(0.05).keeps_limits, kept.at(0.1).keeps_limits
    (True, False)
    """

    loop: Callable[[float], Loop | Ode | SampledSystem]
    metrics: Callable[[float], Sequence[AbstractMetric]]
    limits: Mapping[str, float | Array]
    until: float
    longest_step: float
    seed: int = 0

    def __post_init__(self) -> None:
        for name in ("until", "longest_step"):
            seconds(f"LoopLimits({name}=...)", getattr(self, name))
        limits = {name: numbers("LoopLimits(limits=...)", limit) for name, limit in self.limits.items()}
        tiny = np.finfo(float).tiny
        if not limits or not all(((limit >= tiny) & (limit < np.inf)).all() for limit in limits.values()):
            raise refusal("LoopLimits(limits=...)", "finite numbers above zero by the names of metrics", self.limits)
        object.__setattr__(self, "limits", limits)

    @check_arguments
    def at(self, setting: float) -> LoopTrial:
        """The run at one setting.

        Raises
        ------
        LookupError
            If a limit names a metric that the run does not have.
        ValueError
            If `loop` gives no loop, `metrics` no metrics, or `measure` refuses.
        """
        loop = _given("LoopLimits(loop=...)", "give a loop or its equations", self.loop, setting)
        equation = equations_of(loop, "loop")
        metrics = _given("LoopLimits(metrics=...)", "give metrics", self.metrics, setting)
        metrics = several("LoopLimits(metrics=...)(setting)", metrics, AbstractMetric)
        for name in self.limits:
            known_name(name, [metric.name for metric in metrics], "metrics of the loop")
        span = equation.period if isinstance(equation, SampledSystem) else self.longest_step
        h = span / max(int(np.ceil(span / self.longest_step - ROUNDING)), 1)
        until = span * max(round(self.until / span), 1)
        found = measure(equation, metrics, until=until, every=until, h=h, seed=self.seed)
        shares, errors = {}, {}
        for name, given in self.limits.items():
            limit = np.asarray(given)
            value, error = np.array([one.pair for one in found.scores_of(name)]).T
            if limit.shape not in ((), value.shape):
                must = f"one number, or {len(value)}, as '{name}' has"
                raise refusal(f"LoopLimits(limits={{'{name}': ...}})", must, limit)
            with np.errstate(over="ignore"):  # a share may be infinite
                shares[name], errors[name] = value / limit, error / limit
        return LoopTrial(shares, errors)


def _given(call: str, must: str, function: Callable[[float], T], setting: float) -> T:
    """The result of a function of the user's own at a setting; its refusals pass."""
    given: T = answer(f"{call}({setting:g})", must, lambda: function(setting), lambda given: given, refuses=True)
    return given


@dataclass(frozen=True, eq=False)
@check_arguments
class LoopTrial:
    """A run compared with its limits: for each metric its numbers over their limits, (k,), and the errors of these.

    Both are NaN if the run diverged.
    """

    shares: Mapping[str, Array]
    errors: Mapping[str, Array]

    def __post_init__(self) -> None:
        shapes = [{name: array.shape for name, array in held.items()} for held in (self.shares, self.errors)]
        if shapes[0] != shapes[1]:
            raise refusal("LoopTrial(errors=...)", f"errors of the shapes of the shares, {shapes[0]}", shapes[1])

    @check_arguments
    def worst(self, metric: str) -> float:
        """The largest value of a metric as a share of its limit; infinite if the run diverged."""
        share = self.shares[known_name(metric, self.shares, "metrics with a limit")]
        return float("inf") if np.isnan(share).any() else float(share.max())

    @property
    def keeps_limits(self) -> bool:
        """True if no number is above its limit."""
        return all(self.worst(metric) <= 1 for metric in self.shares)

    @property
    def sure(self) -> bool:
        """True if the errors of the step cannot change `keeps_limits`; a run that diverged is sure."""
        with np.errstate(invalid="ignore"):  # where a share and its error are infinite
            high = all((self.shares[name] + error <= 1).all() for name, error in self.errors.items())
            low = any(not (self.shares[name] - error <= 1).all() for name, error in self.errors.items())
        return high or low


@dataclass(frozen=True, eq=False)
@check_arguments
class LargestSetting:
    """The bracket of the largest setting that keeps the limits, and the trials at each setting.

    A setting has one trial for each of several `LoopLimits`, up to the first that is not met.
    """

    threshold: Threshold
    trials: tuple[tuple[LoopTrial, ...], ...]

    @property
    def sure(self) -> bool:
        """True if the errors of the step cannot change the answer at either end of the bracket."""
        ends = (self.threshold.largest, self.threshold.next)
        at = [trials for value, trials in zip(self.threshold.values, self.trials, strict=True) if value in ends]
        return all(
            any(one.sure and not one.keeps_limits for one in trials) or all(t.sure for t in trials) for trials in at
        )

    @property
    def sentence(self) -> str:
        """The bracket, the settings that were tried, and a warning if an answer is within the error of the step."""
        doubt = "" if self.sure else "; the answer at an end is within the error of the step"
        return f"{self.threshold.sentence}{doubt}"

    @check_arguments
    def worst(self, metric: str, place: int = 0) -> Array:
        """The largest value of a metric as a share of its limit, at each setting that was tried, (N,).

        The limits are the `LoopLimits` at `place`. The share is infinite if the run diverged, and NaN without a run.
        """
        whole("LargestSetting.worst(place=...)", place, 0)
        return np.array([one[place].worst(metric) if place < len(one) else np.nan for one in self.trials])


@check_arguments
def largest_setting(
    limits: LoopLimits | tuple[LoopLimits, ...],
    settings: Sequence[float],
    *,
    ratio: float | None = 1.01,
    between: Between | None = None,
    patience: int | None = None,
) -> LargestSetting:
    """The largest setting, such as a sampling period, at which loops keep their limits: a scan, then a bisection.

    Parameters
    ----------
    limits
        The limits of one loop, or of several loops that must all keep theirs. They run in turn until one fails.
    settings, ratio, between, patience
        The `values` and options of `find_largest`. Only the scan can show that the limits are met again further up.

    Raises
    ------
    ValueError, LookupError
        As of `find_largest` and `LoopLimits.at`.

    Examples
    --------
    >>> law = wb.PID(wb.DCMotor().outputs, wb.DCMotor().inputs, Kp=100.0, Ki=200.0)
    >>> loop = wb.ClosedLoop(wb.DCMotor(), controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    >>> kept = wb.LoopLimits(lambda T: wb.DigitalLoop(loop, T), lambda T: [wb.rmse()], {"RMSE": 0.25}, 2.0, 5e-3)
    >>> found = wb.largest_setting(kept, (0.05, 0.1), ratio=1.2)
    >>> 0.05 <= found.threshold.largest < found.threshold.next < 0.06, found.sure
    (True, True)
    """
    each = limits if isinstance(limits, tuple) else (limits,)
    if not each:
        raise refusal("largest_setting(limits=...)", "at least one `LoopLimits`", limits)
    trials: dict[float, tuple[LoopTrial, ...]] = {}

    def keeps_limits(setting: float) -> bool:
        made: list[LoopTrial] = []
        for one in each:
            made.append(one.at(setting))
            if not made[-1].keeps_limits:
                break
        trials[setting] = tuple(made)
        return made[-1].keeps_limits

    found = search("largest_setting(settings=...)", keeps_limits, settings, ratio, between, patience)
    return LargestSetting(found, tuple(trials[setting] for setting in found.values))

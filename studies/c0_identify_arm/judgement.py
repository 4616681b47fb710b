"""Judgements of estimators by repeated logs, and of models by runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

import workbench as wb
from studies.c0_identify_arm.answers import DesignedLog, LawLog, RepeatedLogs
from studies.c0_identify_arm.arm import BASE, FREE, ODD, PLAYED, TRUTH, WORDS
from studies.c0_identify_arm.estimates import BASE_WORDS, CUTOFFS, RepeatedFits, base_numbers
from studies.c0_identify_arm.worth import EFFORT, RMSE, SETTLED, Trial

NORMAL, STUDENT = 1.96, 2.01  # 95 % quantiles, the latter for the mean of `DRAWS` runs
SURE = 3.29  # 99.9 %
USEFUL = 0.5  # of a number: a larger standard error tells nothing
SMALL = 0.02  # of a cost: less is no difference to an engineer
TOLD, PARTLY, MISLED, REFUSED = "told", "not all told", "misled", "refused"


def join_batches(parts: Sequence[RepeatedFits]) -> RepeatedFits:
    """Fits of several batches as one."""
    fields = ("theta", "errors", "distances", "worst_misfit", "has_warning")
    together = {name: np.concatenate([getattr(one, name) for one in parts]) for name in fields}
    return RepeatedFits(parts[0].names, **together, refusals=tuple(text for one in parts for text in one.refusals))


@dataclass(frozen=True)
class Evidence:
    """All answers of the study, sorted."""

    law: LawLog
    designed_log: DesignedLog
    blind: DesignedLog  # designed for the arm of the paper
    law_repeats: Mapping[str, RepeatedFits]  # by the name of the conditions
    designed_repeats: Mapping[str, RepeatedFits]
    regressions: Mapping[tuple[str, float], RepeatedFits]  # by log and cutoff
    samples: Mapping[Trial, wb.study.Sample]


def gather(results: wb.Results, trials: Sequence[Trial]) -> Evidence:
    """The evidence in the results of the study."""
    designed, blind = results.work("designed_log")
    batches: tuple[RepeatedLogs, ...] = results.work("law_logs")
    count = len(batches) - len(ODD)
    law_repeats = {BASE.name: join_batches([one.output_errors for one in batches[:count]])}
    law_repeats |= {case.name: one.output_errors for case, one in zip(ODD, batches[count:], strict=True)}
    names = [case.name for case in (BASE, *PLAYED)]
    regressions = {
        ("law", cutoff): join_batches([one.regressions[i] for one in batches[:count]])
        for i, cutoff in enumerate(CUTOFFS)
    }
    regressions |= {("designed", cutoff): designed.regressions[i] for i, cutoff in enumerate(CUTOFFS)}
    return Evidence(
        results.work("law_log")[0],
        designed,
        blind,
        law_repeats,
        dict(zip(names, designed.output_errors, strict=True)),
        regressions,
        {trial: results.sample(trial.name) for trial in trials},
    )


# Estimates


def verdict(repeats: RepeatedFits, truth: Sequence[float]) -> str:
    """The verdict on some logs of an arm: misled if they are too far from the truth for their own standard errors."""
    if not len(repeats.theta):
        return REFUSED
    count = sum(name in FREE for name in repeats.names)
    degrees = count * len(repeats.theta)
    # the sum is a chi-square number of so many degrees, nearly normal
    if repeats.distances.sum() > degrees + SURE * np.sqrt(2 * degrees):
        return MISLED
    share = (repeats.errors[:, :count] / np.abs(np.asarray(truth)[:count])).mean(axis=0)
    return PARTLY if (share > USEFUL).any() else TOLD


def words_of(repeats: RepeatedFits, truth: Sequence[float]) -> str:
    """The largest error and whether the fits warn, in words."""
    count = sum(name in FREE for name in repeats.names)
    if not len(repeats.theta):
        return "each fit is refused"
    off = np.abs(repeats.theta[:, :count].mean(axis=0) / np.asarray(truth)[:count] - 1)
    worst = int(np.argmax(off))
    count_of_warnings = int(repeats.has_warning.sum())
    return (
        f"{WORDS[repeats.names[worst]]} is off by {digits(100 * off[worst])} % in the mean of {len(repeats.theta)} "
        f"logs; {count_of_warnings} of the fits warn"
    )


def digits(value: float) -> str:
    """A number with two digits, or with all before the point."""
    return f"{value:.2g}" if abs(value) < 99.5 else f"{value:.0f}"


@dataclass(frozen=True)
class Accuracy:
    """Of an estimator over B logs: relative bias with its error, and shares of intervals that hold the truth."""

    bias: wb.Array  # (k,)
    bias_error: wb.Array  # (k,), 1.96 standard errors of the mean
    spread: wb.Array  # (k,), standard deviation of the estimates, relative
    mean_errors: wb.Array  # (k,), mean standard error, relative
    coverage: wb.Array  # (k,), of 95 % intervals
    count: int

    @property
    def is_unbiased(self) -> bool:
        """True if no mean is further from the truth than chance makes it in one of a thousand numbers."""
        return bool((np.abs(self.bias) <= SURE / NORMAL * self.bias_error).all())


def accuracy(estimates: wb.Array, errors: wb.Array, truth: wb.Array) -> Accuracy:
    """The accuracy of estimates (B, k) with standard errors (B, k)."""
    size, count = np.abs(truth), len(estimates)
    spread = estimates.std(axis=0, ddof=1) / size
    inside = np.abs(estimates - truth) <= NORMAL * errors
    return Accuracy(
        (estimates.mean(axis=0) - truth) / size,
        NORMAL * spread / np.sqrt(count),
        spread,
        errors.mean(axis=0) / size,
        inside.mean(axis=0),
        count,
    )


def of_output_errors(repeats: RepeatedFits) -> Accuracy:
    """The accuracy of fits by output errors, in the numbers of the arm."""
    return accuracy(repeats.theta, repeats.errors, np.array(TRUTH))


def of_base_numbers(repeats: RepeatedFits) -> Accuracy:
    """The same in base parameters, whose standard errors come from the spread of the fits."""
    base = base_numbers(repeats.theta)
    errors = np.tile(base.std(axis=0, ddof=1), (len(base), 1))
    return accuracy(base, errors, base_numbers(np.array([TRUTH]))[0])


def of_regressions(repeats: RepeatedFits) -> Accuracy:
    """The accuracy of regressions, in base parameters."""
    return accuracy(repeats.theta, repeats.errors, base_numbers(np.array([TRUTH]))[0])


BASE_NAMES = (*BASE_WORDS, *(WORDS[name] for name in FREE[4:]))


# Costs


def both(sample: wb.study.Sample, metric: str) -> wb.Array:
    """A metric of both joints together, the root of the sum of their squares, (N,)."""
    return np.asarray(np.hypot(*(sample.score(metric, joint).value for joint in (0, 1))))


@dataclass(frozen=True)
class Change:
    """The mean of a metric with one model less that with the true one, in parts of the latter, with its interval."""

    value: float
    low: float
    high: float

    @property
    def word(self) -> str:
        """Higher or lower by more than `SMALL`, no difference within it, or undecided."""
        if self.low > SMALL:
            return "higher"
        if self.high < -SMALL:
            return "lower"
        return "no difference" if max(abs(self.low), abs(self.high)) <= SMALL else "undecided"

    @property
    def percent(self) -> str:
        """The change in words, such as '+12 % (+10 to +14 %)'."""
        parts = (100 * one for one in (self.value, self.low, self.high))
        value, low, high = (f"{'−' if one < 0 else '+'}{digits(abs(one))}" for one in parts)
        return f"{value} % ({low} to {high} %)"


def change(evidence: Evidence, trial: Trial, reference: Trial, metric: str) -> Change:
    """The change of a metric between two trials, run by run with the same start and noise."""
    one, other = (both(evidence.samples[each], metric) for each in (trial, reference))
    gap, level = one - other, float(other.mean())
    half = STUDENT * float(gap.std(ddof=1)) / np.sqrt(len(gap))
    return Change(float(gap.mean()) / level, (float(gap.mean()) - half) / level, (float(gap.mean()) + half) / level)


METRICS = {
    SETTLED: "error from 2 s on",
    RMSE: "error of the whole run",
    EFFORT: "root mean square of the torque",
}

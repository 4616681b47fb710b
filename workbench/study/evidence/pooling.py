"""Pooling: one value of each draw from several scenarios, judged with all of them and with each one left out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, TypeAlias

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.study.evidence.estimands import Estimand, Mean
from workbench.study.evidence.judgement import LawJudgement
from workbench.study.evidence.paired_samples import PairedSamples, pair_samples
from workbench.study.evidence.pairwise_comparison import Comparison

MEAN = Mean()
Way: TypeAlias = Literal["geometric mean", "ratio to the best", "arithmetic mean"]
WAYS: Mapping[Way, str] = {
    "geometric mean": "the geometric mean over the scenarios, in which equal ratios count alike in every scenario",
    "ratio to the best": "the mean over the scenarios of the ratio to the least level in each",
    "arithmetic mean": "the arithmetic mean over the scenarios, in which the scenario with the largest values counts "
    "most",
}


@dataclass(frozen=True, eq=False)
@check_arguments
class PooledJudgement:
    """Laws judged over all scenarios together, and again with each scenario left out.

    A pooled value may rest on one scenario; `rests_on` names each scenario without which the answer changes.
    """

    way: Way
    members: Mapping[str, PairedSamples]  # by scenario
    whole: LawJudgement
    without: Mapping[str, LawJudgement]  # by the scenario that is left out

    def __post_init__(self) -> None:
        if set(self.members) != set(self.without):
            raise ValueError(
                f"`PooledJudgement(without=...)` must leave out each of {list(self.members)} once; got "
                f"{list(self.without)}."
            )

    @property
    def answer(self) -> str:
        """The best law over all scenarios, or the laws between which the runs do not decide."""
        return _asked(self.whole).answer

    @property
    def answers(self) -> dict[str, str]:
        """The answer without each scenario, by the scenario that is left out."""
        return {name: _asked(one).answer for name, one in self.without.items()}

    @property
    def rests_on(self) -> tuple[str, ...]:
        """The scenarios without which the answer changes."""
        return tuple(name for name, answer in self.answers.items() if answer != self.answer)

    @cached_property
    def shares(self) -> dict[str, dict[str, float]]:
        """By scenario and law, the part of the sum of a law's mean values that comes from the scenario.

        Laws with a failed run are left out.
        """
        means = {name: one.values.mean(axis=0) for name, one in self.members.items()}
        total = np.sum(list(means.values()), axis=0)
        laws = next(iter(self.members.values())).laws
        finite = [k for k in range(len(laws)) if np.isfinite(total[k])]
        return {name: {laws[k]: float(mean[k] / total[k]) for k in finite} for name, mean in means.items()}


@check_arguments
def pool(members: Mapping[str, PairedSamples], way: Way = "geometric mean", estimand: Estimand = MEAN) -> PairedSamples:
    """Pool several scenarios to one value for each draw and law; row k must be the same draw in all of them.

        geometric mean:     G_k = (prod_s y_sk)^(1/S),      error  G_k (1/S) sum_s e_sk / y_sk
        ratio to the best:  (1/S) sum_s y_sk / b_s,         error  (1/S) sum_s e_sk / b_s
        arithmetic mean:    (1/S) sum_s y_sk,               error  (1/S) sum_s e_sk

    Here b_s is the least mean over the draws of a law in scenario s, read from the same draws and then taken as exact;
    e_sk is the error of run k due to the step. It is known for draws that were repeated at h / 2 in all scenarios;
    without `step_errors`, every run has the largest error of its law. The error of the pooled values is the mean over
    these draws if `estimand` is a mean, and else the largest. A run that failed in one scenario counts as failed.

    Raises
    ------
    ValueError
        If there is no scenario, laws, metrics or numbers of draws differ between scenarios, or a value is not positive
        where ratios are taken.

    Examples
    --------
    >>> from workbench.study.evidence import Mean, judge, leave_one_out, pair_samples, pool
    >>> draws = np.random.default_rng(1).random(40)
    >>> errors = pair_samples({"PID": draws, "SMC": draws + 0.1}, metric="error", unit="rad")
    >>> both = {"step": errors, "ramp": errors}
    >>> pool(both, "arithmetic mean").laws
    ('PID', 'SMC')
    >>> leave_one_out(both, lambda one: judge(one, Mean(), resamples=100), "arithmetic mean").way
    'arithmetic mean'
    """
    _check_members(members)
    first = next(iter(members.values()))
    y = np.array([one.values for one in members.values()])
    if way != "arithmetic mean" and not (y > 0).all():
        raise ValueError(
            f"`pool(members, way={way!r})` takes ratios, so that values must be positive; the least is {y.min():g}."
        )
    values, off = _pooled(y, _errors(members), way)
    unit = "" if way == "ratio to the best" else first.unit
    return pair_samples(
        {law: np.where(np.isinf(column), np.nan, column) for law, column in zip(first.laws, values.T, strict=True)},
        metric=first.metric,
        unit=unit,
        errors=dict(zip(first.laws, (_over_draws(column, estimand) for column in off.T), strict=True)),
        note="; ".join(filter(None, (f"pooled over {len(members)} scenarios: {WAYS[way]}", first.note))),
    )


@check_arguments
def leave_one_out(
    members: Mapping[str, PairedSamples],
    judge: Callable[[PairedSamples], LawJudgement],
    way: Way = "geometric mean",
    estimand: Estimand = MEAN,
) -> PooledJudgement:
    """The judgement of the pooled values of all scenarios, and again with each scenario left out.

    Raises
    ------
    ValueError
        If there are fewer than two scenarios, or `pool` refuses them.
    """
    if len(members) < 2:
        raise ValueError(f"`leave_one_out(members)` needs two scenarios or more; got {list(members)}.")
    rest = {name: {other: one for other, one in members.items() if other != name} for name in members}
    return PooledJudgement(
        way,
        members,
        judge(pool(members, way, estimand)),
        {name: judge(pool(others, way, estimand)) for name, others in rest.items()},
    )


def _errors(members: Mapping[str, PairedSamples]) -> Array:
    """The errors of the runs by the step, (S, N, L), NaN where they are not known."""
    known = [one.step_errors for one in members.values() if one.step_errors is not None]
    if len(known) == len(members):
        return np.array(known)
    return np.array([np.broadcast_to(one.errors, one.values.shape) for one in members.values()])


def _pooled(y: Array, errors: Array, way: Way) -> tuple[Array, Array]:
    """The pooled values (N, L) of y (S, N, L), and how far off they are by errors (S, N, L)."""
    match way:
        case "geometric mean":
            values = np.exp(np.log(y).mean(axis=0))
            with np.errstate(invalid="ignore"):  # of a failed run, which is infinite whatever its error
                return values, np.where(np.isinf(values), 0.0, values * np.mean(errors / y, axis=0))
        case "ratio to the best":
            best = y.mean(axis=1).min(axis=1)[:, None, None]
            if not np.isfinite(best).all():
                raise ValueError(
                    "`pool(members, way='ratio to the best')` needs a law without failed runs in each scenario; there "
                    "is none in one of them, so that the geometric mean alone can be taken."
                )
            return np.mean(y / best, axis=0), np.mean(errors / best, axis=0)
    return np.mean(y, axis=0), np.mean(errors, axis=0)


def _over_draws(errors: Array, estimand: Estimand) -> float:
    """The error of an estimand by those of the draws in which it is known; NaN if there are none."""
    known = errors[~np.isnan(errors)]
    if not len(known):
        return float("nan")
    return float(known.mean() if isinstance(estimand, Mean) else known.max())


def _check_members(members: Mapping[str, PairedSamples]) -> None:
    kinds = {(one.laws, one.metric, one.unit, len(one)) for one in members.values()}
    if len(kinds) != 1:
        raise ValueError(
            "`pool(members)` must map one scenario or more to values of the same metric of the same laws in the same "
            f"draws; got {len(members)} scenarios with {len(kinds)} kinds of values."
        )


def _asked(judgement: LawJudgement) -> Comparison:
    return judgement.by[judgement.primary.words]

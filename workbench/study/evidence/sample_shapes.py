"""Shapes of samples: two groups of draws, a heavy tail, and the factor of the draws that predicts them."""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np

from workbench.core.validation.refusals import Array, Integers
from workbench.core.validation.refusals import seed as as_seed
from workbench.core.validation.signatures import door
from workbench.study.evidence.common_draws import Paired
from workbench.study.uncertainty.designs import uniforms
from workbench.study.uncertainty.outputs import Flags, t_quantile

RESAMPLES = 2000
BESIDE = 10  # draws on each side of a gap that are held against it
WORST = 0.1  # part of the draws whose part of the total tells a heavy tail
Kind = Literal["failures", "two groups", "heavy tail", "one group"]


@dataclass(frozen=True)
@door
class Predictor:
    """The factor, and its limit, that tell a group of draws from the others best."""

    factor: str
    side: Literal["above", "below"]
    limit: float
    area: float  # under the ROC: the probability that the factor is larger in a draw of the group than in another
    p: float  # that the area is as far from one half by chance, times the number of factors
    inside: int  # how many draws of the group are on that side of the limit
    outside: int  # and how many of the others


@dataclass(frozen=True, eq=False)
@door
class Shape:
    """The shape of the values of a law over the draws.

    Its kind is the first that holds: some runs failed; the values are in two groups, by a gap or by Hartigan's dip; the
    worst tenth carries more of the total than that of an exponential law would; or none of these.
    """

    law: str
    metric: str
    unit: str
    kind: Kind
    upper: Integers  # the numbers of the failed draws, of the upper group or of the worst tenth
    runs: int
    limit: float  # the least value of these
    ratio: float  # of the mean to the median, of finite values
    carried: float  # the part of their total that the worst tenth carries
    predictor: Predictor | None  # of `upper`; none if no factor tells them from the others with the confidence

    @property
    def sentence(self) -> str:
        """The finding in plain words, with its figures."""
        count, runs = int(self.upper.size), self.runs
        if self.kind == "one group":
            return f"{self.law}: its {self.metric} is one group without a heavy tail"
        above = f"{self.metric} of {self.limit:.3g} {self.unit}".strip() + " or more"
        said = {
            "failures": f"{count} of {runs} runs failed",
            "two groups": f"two groups: {100 * count / runs:.2g} % of the draws have a {above}",
            "heavy tail": f"heavy tail: the worst {100 * count / runs:.2g} % of the draws, with a {above}, carry "
            f"{100 * self.carried:.2g} % of the total, and the mean is {self.ratio:.3g} times the median",
        }[self.kind]
        one = self.predictor
        if one is None:
            return f"{self.law}: {said}; no factor predicts which"
        return (
            f"{self.law}: {said}; {one.inside} of {count} of them have {one.factor} {one.side} {one.limit:.3g}, as "
            f"have {one.outside} of the {runs - count} others"
        )


@door
def shapes(
    paired: Paired, drawn: Array, factors: Sequence[str], *, confidence: float = 0.95, seed: int = 0
) -> tuple[Shape, ...]:
    """The shape of each law's values over draws of factors (N, d), all with the confidence at once by Bonferroni.

    Examples
    --------
    >>> from workbench.study.evidence import paired, shapes
    >>> from workbench.study.uncertainty import MonteCarlo
    >>> points = MonteCarlo(2, 40).points()
    >>> errors = paired({"PID": points[:, 0], "SMC": points[:, 1]}, metric="error", unit="rad")
    >>> shapes(errors, points, ("k", "m"), confidence=0.9, seed=1)[0]
    Shape(law='PID', metric='error', unit='rad', kind='one group', upper=[], runs=40, limit=inf, ...)
    """
    t_quantile("shapes", confidence, 1)  # refuses what is no confidence
    as_seed("shapes(seed=...)", seed)
    if drawn.shape != (len(paired), len(factors)) or not np.isfinite(drawn).all():
        raise ValueError(
            f"`shapes(drawn=...)` must be {len(paired)} rows of {len(factors)} finite numbers, a row a draw and a "
            f"column a factor; got shape {drawn.shape}."
        )
    sure = 1 - (1 - confidence) / len(paired.laws)
    found = []
    for law, y in zip(paired.laws, paired.values.T, strict=True):
        ratio, carried = _weight(y[np.isfinite(y)])
        kind, upper = _group(y, carried, sure, seed)
        predictor = _predictor(upper, drawn, factors, 1 - sure)
        least = float(y[upper].min(initial=np.inf))
        group = (np.flatnonzero(upper), len(y), least)
        found.append(Shape(law, paired.metric, paired.unit, kind, *group, ratio, carried, predictor))
    return tuple(found)


def _group(y: Array, carried: float, sure: float, seed: int) -> tuple[Kind, Flags]:
    failed = np.isinf(y)
    if failed.any():
        return "failures", failed
    x = np.log(y) if y.min() > 0 else y  # one mode of a positive value is one of its logarithm for all usual laws
    chance, beyond = gap(x)
    if chance <= (1 - sure) / 2:
        return "two groups", x >= beyond
    if dip(x) > least_dip(len(y), (1 + sure) / 2, seed):
        return "two groups", x >= _between(x)
    if carried > _carried_by_exponential(len(y), sure, seed):
        return "heavy tail", y >= np.sort(y)[-round(WORST * len(y))]
    return "one group", np.zeros(len(y), bool)


def _between(x: Array) -> float:
    """The least value of the upper group, in the split into two parts with the least squares about their means."""
    ordered = np.sort(x)
    sums, lower = np.cumsum(ordered - x.mean())[:-1], np.arange(1, len(x))
    return float(ordered[1 + int(np.argmax(sums**2 / (lower * lower[::-1])))])


def _weight(y: Array) -> tuple[float, float]:
    """The mean over the median, and the part of the total in the worst tenth; NaN if not all are positive."""
    if not len(y) or y.min() <= 0:
        return np.nan, np.nan
    ordered = np.sort(y / y.max())
    return float(ordered.mean() / np.median(ordered)), float(ordered[-round(WORST * len(y)) :].sum() / ordered.sum())


@lru_cache(maxsize=8)
def _carried_by_exponential(runs: int, confidence: float, seed: int) -> float:
    """The quantile, at a confidence, of the part of the total in the worst tenth of exponential samples."""
    parts = np.sort([_weight(row)[1] for row in -np.log(uniforms(seed, 0, RESAMPLES, runs))])
    return float(parts[int(np.ceil(confidence * (RESAMPLES - 1)))])


def _predictor(upper: Flags, drawn: Array, factors: Sequence[str], most: float) -> Predictor | None:
    """The factor that tells a group best by the test of Mann and Whitney, if it is significant, and its best limit."""
    inside, outside = drawn[upper], drawn[~upper]
    n, m = len(inside), len(outside)
    if not (n and m and len(factors)):
        return None
    from scipy.stats import mannwhitneyu

    found = mannwhitneyu(inside, outside, use_continuity=False, method="asymptotic")
    areas = np.asarray(found.statistic) / (n * m)
    chances = len(factors) * np.nan_to_num(np.asarray(found.pvalue), nan=1.0)  # of a constant factor 1
    best = int(np.argmin(chances))
    if chances[best] > most:
        return None
    sign = 1 if areas[best] > 0.5 else -1
    a, b = np.sort(sign * inside[:, best]), np.sort(sign * outside[:, best])
    limits = np.unique(np.concatenate([a, b]))
    hit, false = n - np.searchsorted(a, limits), m - np.searchsorted(b, limits)
    at = int(np.argmax(hit / n - false / m))
    edge = (limits[at] + limits[at - 1]) / 2 if at else limits[at]
    side: Literal["above", "below"] = "above" if sign > 0 else "below"
    place = (factors[best], side, float(sign * edge), float(areas[best]), float(chances[best]))
    return Predictor(*place, int(hit[at]), int(false[at]))


def gap(values: Array) -> tuple[float, float]:
    """The probability that one mode has so wide a gap within the sample, at most, and the least value beyond it.

        P = N max ((s / (g + s))^9)    over the ten draws below the gap g and those above, which span s

    as away from its mode a density falls, and N is for all gaps (Bonferroni).
    """
    x = np.sort(values)
    wide = np.diff(x)
    spans = x[BESIDE - 1 :] - x[: 1 - BESIDE]
    here, below, above = wide[BESIDE - 1 : 1 - BESIDE], spans[:-BESIDE], spans[BESIDE:]
    span = np.maximum(below, above)
    chances = np.where(here > 0, (span / np.where(here > 0, here + span, 1)) ** (BESIDE - 1), 1.0)
    at = int(np.argmin(chances))
    return min(1.0, len(x) * float(chances[at])), float(x[BESIDE + at])


def dip(values: Array) -> float:
    """The least distance of the sample's distribution to one that is convex up to a mode and concave beyond it.

        dip = min_U sup_x |F(x) - U(x)|

    by the greatest convex minorant and the least concave majorant of F, between ends that move inwards.

    References
    ----------
    Hartigan, Hartigan, "The dip test of unimodality", Annals of Statistics 13 (1985), section 3.
    """
    x, counts = np.unique(values, return_counts=True)
    above = np.cumsum(counts).astype(float)
    below = above - counts.astype(float)
    low, high, twice = 0, len(x) - 1, 1.0
    while low < high:
        part = slice(low, high + 1)
        minorant, convex = _hull(x[part], below[part], operator.le)
        majorant, concave = _hull(x[part], above[part], operator.ge)
        gap = majorant - minorant
        k = int(np.argmax(gap))
        if gap[k] <= twice:
            break
        first, last = int(convex[convex <= k][-1]), int(concave[concave >= k][0])
        left = (above[part] - minorant)[: first + 1].max()
        right = (majorant - below[part])[last:].max()
        twice = max(twice, float(left), float(right))
        if (first, last) == (0, high - low):
            break
        low, high = low + first, low + last
    return twice / (2 * len(values))


@lru_cache(maxsize=8)
def least_dip(runs: int, confidence: float, seed: int) -> float:
    """The quantile, at a confidence, of the dip of uniform samples, the largest of all laws with one mode."""
    dips = np.sort([dip(row) for row in uniforms(seed, 0, RESAMPLES, runs)])
    return float(dips[int(np.ceil(confidence * (RESAMPLES - 1)))])


def _hull(x: Array, y: Array, turns: Callable[[float, float], bool]) -> tuple[Array, Integers]:
    """The convex or concave hull of points in order, at each of them, and the places of its corners."""
    corners: list[int] = []
    xs, ys = x.tolist(), y.tolist()
    for i in range(len(xs)):
        while len(corners) > 1:
            a, b = corners[-2:]
            if not turns((ys[i] - ys[b]) * (xs[b] - xs[a]), (ys[b] - ys[a]) * (xs[i] - xs[b])):
                break
            corners.pop()
        corners.append(i)
    return np.interp(x, x[corners], y[corners]), np.array(corners)

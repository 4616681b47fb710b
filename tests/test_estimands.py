"""Estimands: intervals that hold as often as they say, heavy tails and two groups of draws included."""

import numpy as np
from scipy import stats

from workbench.study.evidence import Mean, Median, Quantile, Success, Tail
from workbench.study.evidence.estimands import intervals

PAIRS = [(0, 1), (0, 2), (1, 2)]
SHARE = 0.9
Z = stats.norm.ppf(SHARE)
LIMIT = 5.0


class Lognormal:
    """exp(sigma z)."""

    def __init__(self, sigma):
        self.sigma = sigma

    def draw(self, z, rng):
        return np.exp(self.sigma * z)

    def truth(self, estimand):
        s = self.sigma
        match estimand:
            case Mean():
                return np.exp(s**2 / 2)
            case Median():
                return 1.0
            case Quantile():
                return np.exp(s * Z)
            case Tail():
                return np.exp(s**2 / 2) * stats.norm.cdf(s - Z) / (1 - SHARE)
        return stats.norm.sf(np.log(LIMIT) / s)


class TwoGroups:
    """About 3, and in a part of the draws about 20."""

    def __init__(self, part):
        self.part = part

    def draw(self, z, rng):
        return np.where(rng.random(len(z)) < self.part, 20 + 3 * z, 3 + 0.2 * z)

    def truth(self, estimand):
        p, low = self.part, 1 - self.part  # the groups do not overlap: 3 + 0.2 * 5 < 20 - 3 * 5 < LIMIT + 0.1
        match estimand:
            case Mean():
                return 20 * p + 3 * low
            case Median():
                return 3 + 0.2 * stats.norm.ppf(0.5 / low)
            case Quantile() if p > 0.1:
                return 20 + 3 * stats.norm.isf(0.1 / p)
            case Quantile():
                return 3 + 0.2 * stats.norm.ppf(0.9 / low)
            case Tail() if p > 0.1:
                return 20 + 3 * stats.norm.pdf(stats.norm.isf(0.1 / p)) / (0.1 / p)
            case Tail():
                z = stats.norm.ppf(0.9 / low)
                return 10 * (20 * p + 3 * (0.1 - p) + 0.2 * low * stats.norm.pdf(z))
        return p


def held(estimand, laws, samples=300, runs=160, confidence=0.9, resamples=400):
    """How often all levels hold the truth, and how often all differences do."""
    rng = np.random.default_rng(3)
    truth = np.array([law.truth(estimand) for law in laws])
    apart = np.array([truth[i] - truth[j] for i, j in PAIRS])
    found = []
    for seed in range(samples):
        common = rng.normal(size=runs)  # a draw makes all laws' runs harder or easier together
        zs = [0.8 * common + 0.6 * rng.normal(size=runs) for _ in laws]
        values = np.column_stack([law.draw(z, rng) for law, z in zip(laws, zs, strict=True)])
        ends = intervals(estimand, values, PAIRS, confidence, resamples, seed)
        found.append([((e.low <= t) & (t <= e.high)).all() for e, t in zip(ends, (truth, apart), strict=True)])
    return np.mean(found, axis=0)


ESTIMANDS = [Mean(), Median(), Quantile(SHARE), Tail(SHARE), Success(LIMIT)]
SMOOTH = (Lognormal(0.5), Lognormal(0.6), Lognormal(1.0))

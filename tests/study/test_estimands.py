"""Estimands: intervals that hold as often as they say, heavy tails and two groups of draws included."""

from functools import cache

import numpy as np
import pytest
from scipy import stats

from workbench.study.evidence import Mean, Median, Quantile, Success, Tail
from workbench.study.evidence.bootstrap import likely_quantiles, percentiles, resampled_tails
from workbench.study.evidence.estimands import intervals

PAIRS = [(0, 1), (0, 2), (1, 2)]
SHARE = 0.9
Z = stats.norm.ppf(SHARE)
LIMIT = 5.0
SAMPLES = 160


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


@cache
def held(estimand, laws, samples=SAMPLES, runs=160, confidence=0.9, resamples=200):
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
ROUND_THE_QUANTILE = (TwoGroups(0.095), Lognormal(0.5), TwoGroups(0.105))  # the quantile jumps between the groups
GROUPS = (TwoGroups(0.16), Lognormal(0.5), TwoGroups(0.08))


@pytest.mark.parametrize(
    "laws", [SMOOTH, *(pytest.param(laws, marks=pytest.mark.heavy) for laws in (ROUND_THE_QUANTILE, GROUPS))]
)
@pytest.mark.parametrize("estimand", ESTIMANDS, ids=lambda one: one.words)
def test_all_intervals_hold_the_truth_as_often_as_they_say(estimand, laws):
    # 0.9 less three standard errors of a share over so many samples; Bonferroni and whole draws make some wider
    assert (held(estimand, laws) >= 0.9 - 3 * (0.9 * 0.1 / SAMPLES) ** 0.5).all()


@pytest.mark.parametrize("estimand", ESTIMANDS[:4], ids=lambda one: one.words)
def test_no_interval_of_smooth_laws_is_wide_enough_to_hold_the_truth_always(estimand):
    assert (held(estimand, SMOOTH) <= 0.97).all()


def test_a_draw_less_than_a_whole_share_costs_no_coverage():
    assert held(Quantile(SHARE), SMOOTH, runs=111)[0] >= 0.9 - 3 * (0.9 * 0.1 / SAMPLES) ** 0.5


RNG = np.random.default_rng(11)


def test_a_single_tail_has_the_percentile_interval_of_scipy():
    y = RNG.exponential(size=160)

    def worst(x, axis):
        return np.sort(x, axis=axis)[..., -16:].mean(axis=axis)

    exact = stats.bootstrap((y,), worst, method="percentile", n_resamples=20_000, rng=1).confidence_interval
    resampled = resampled_tails(y[:, None], 0.9, 20_000, 2)
    found = percentiles(np.sort(y)[-16:].mean(keepdims=True), resampled, 0.95)
    width = exact.high - exact.low
    # a quantile of 20,000 resamples is known to 2 % of the width
    assert found.low[0] == pytest.approx(exact.low, abs=0.03 * width)
    assert found.high[0] == pytest.approx(exact.high, abs=0.03 * width)


@pytest.mark.parametrize("share", [0.5, 0.9])
def test_where_a_quantile_may_lie_follows_the_binomial_law(share):
    y = np.arange(1.0, 161)[:, None]
    places = likely_quantiles(y, share, 20_000, 3)[:, 0] - 0.5
    for q in (0.05, 0.5, 0.95):
        # ranks are whole, and the bootstrap's share may stand on either side of a step
        assert abs(np.quantile(places, q) - stats.binom.ppf(q, 160, share)) <= 1


def test_laws_that_differ_by_a_constant_differ_by_it_in_every_statistic():
    y = RNG.lognormal(size=160)
    values = np.column_stack([y, y + 0.5])
    for estimand in ESTIMANDS[:4]:
        _, apart = intervals(estimand, values, [(0, 1)], 0.95, 400, 1)
        np.testing.assert_allclose([apart.low[0], apart.high[0]], -0.5, rtol=1e-9)


def test_what_varies_in_few_draws_is_not_bounded_and_widens_nothing_else():
    y = RNG.normal(size=(160, 2))
    rare = np.where(np.arange(160) < 2, 1.0, 0.0)
    alone, _ = intervals(Mean(), y, [], 0.95, 400, 1)
    found, _ = intervals(Mean(), np.column_stack([y, rare]), [], 0.95, 400, 1)
    assert found.high[2] == np.inf
    assert found.low[2] > -np.inf  # a mean of what is rare and large is bounded from below
    np.testing.assert_allclose(found.high[:2], alone.high, rtol=0.1)  # of five sides instead of four


def test_success_has_the_exact_interval_and_a_pair_is_significant_no_sooner_than_by_the_sign_test():
    runs = 160
    for lost in range(30):
        first = (np.arange(runs) < lost) * 10.0
        level, apart = intervals(Success(5), np.column_stack([first, 0 * first]), [(0, 1)], 0.95, 100, 0)
        exact = stats.binomtest(lost, runs).proportion_ci(0.975, "exact")  # of two at once
        np.testing.assert_allclose([level.low[0], level.high[0]], exact, atol=1e-12)
        if apart.low[0] > 0:
            assert stats.binomtest(lost, lost).pvalue < 0.05
    assert apart.low[0] > 0


@pytest.mark.parametrize(
    ("made", "why"),
    [
        (lambda: Quantile(1.0), r"`Quantile\(share=...\)` must be a share of the draws between 0 and 1; got 1.0"),
        (lambda: Tail(0.0), r"`Tail\(share=...\)` must be a share"),
        (lambda: Success(np.nan), r"`Success\(limit=...\)` must be"),
    ],
)
def test_an_estimand_that_means_nothing_is_refused(made, why):
    with pytest.raises(ValueError, match=why):
        made()

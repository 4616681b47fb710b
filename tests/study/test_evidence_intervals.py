"""The intervals of a comparison hold the truth as often as they say, alone and all at once."""

import numpy as np
import pytest
from scipy import stats

from workbench.study.evidence.bootstrap import means, order_statistics

RNG = np.random.default_rng(7)


def coverage(summary, draw, truth, runs: int) -> float:
    """How often all intervals at once hold the truth, over 400 samples."""
    rng = np.random.default_rng(1)
    held = []
    for seed in range(400):
        found = summary(draw(rng, runs), confidence=0.9, resamples=400, seed=seed)
        held.append(((found.low <= truth) & (truth <= found.high)).all())
    return float(np.mean(held))


def exact_means(columns, confidence, resamples, seed):
    return means(columns, np.zeros(columns.shape[1]), confidence, resamples, seed)


def medians(columns, confidence, resamples, seed):
    return order_statistics(columns, 0.5, confidence, resamples, seed)


NOISE = np.array([[1.0, 0.8, 0.0], [0.0, 0.6, 0.0], [0.0, 0.0, 1.0]])


def normal(rng, runs):
    return np.array([1.0, -1.0, 0.0]) + rng.normal(size=(runs, 3)) @ NOISE


def skewed(rng, runs):
    return rng.exponential(size=(runs, 3)) @ NOISE


def test_a_column_with_a_heavy_tail_widens_no_other():
    """Beside eight columns in which one of fifty draws is a hundred times as large; Bonferroni for nine is 1.24."""
    rng = np.random.default_rng(7)
    plain = rng.normal(size=(160, 1))
    heavy = rng.normal(size=(160, 8)) * np.where(rng.uniform(size=(160, 8)) < 0.02, 100.0, 1.0)
    alone, beside = (exact_means(y, 0.995, 4000, 3) for y in (plain, np.hstack([plain, heavy])))
    wider = (beside.high - beside.low)[0] / (alone.high - alone.low)[0]
    assert 1 <= wider < 1.6


# 0.9 within three standard errors of a share over 400 samples, 0.045; a median's steps are whole draws, and so wider
@pytest.mark.parametrize(
    ("summary", "draw", "truth", "low", "high"),
    [
        (exact_means, normal, [1.0, -1.0, 0.0], 0.855, 0.945),
        (exact_means, skewed, [1.0, 1.4, 1.0], 0.855, 0.945),
        (medians, normal, [1.0, -1.0, 0.0], 0.855, 0.99),
    ],
)
def test_all_intervals_at_once_hold_the_truth_as_often_as_they_say(summary, draw, truth, low, high):
    assert low <= coverage(summary, draw, np.array(truth), 60) <= high


def test_one_interval_at_a_time_would_miss_some_of_many_more_often():
    rng, truth = np.random.default_rng(2), np.zeros(10)
    together, alone = [], []
    for seed in range(200):
        y = rng.normal(size=(40, 10))
        found = exact_means(y, 0.9, 300, seed)
        together.append(((found.low <= truth) & (truth <= found.high)).all())
        half = stats.t.ppf(0.95, 39) * y.std(axis=0, ddof=1) / 40**0.5
        alone.append((np.abs(y.mean(axis=0)) <= half).all())
    # ten independent intervals of 90 % hold together in 35 %
    assert np.mean(alone) < 0.5 < 0.84 < np.mean(together)


def test_a_single_mean_has_students_interval():
    y = RNG.normal(size=(400, 1))
    found = exact_means(y, 0.95, 6000, 3)
    half = stats.t.ppf(0.975, 399) * y.std(ddof=1) / 400**0.5
    # the quantile of 6,000 resamples is known to 2.5 %, and 400 draws are not quite normal
    assert (found.high - found.low)[0] / 2 == pytest.approx(half, rel=0.05)


@pytest.mark.parametrize("runs", [50, 51])
def test_a_single_median_has_the_interval_of_the_sign_test(runs):
    y = np.arange(1.0, runs + 1)[:, None]
    found = medians(RNG.permutation(y), 0.95, 6000, 4)
    exact = stats.binom.ppf([0.025, 0.975], runs, 0.5)
    # order statistics are whole draws: the bootstrap may end one further out
    assert abs(found.low[0] - exact[0]) <= 1
    assert abs(found.high[0] - (exact[1] + 1)) <= 1

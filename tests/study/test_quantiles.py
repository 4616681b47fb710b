"""Quantiles and shares: what their intervals hold, with failed runs and without."""

import numpy as np
import pytest
from scipy import stats

from workbench.study.uncertainty import LatinHypercube, MonteCarlo, SobolDesign, quantiles, share


def test_intervals_are_the_order_statistics_of_the_printed_table():
    # 95 % for the median of 10: the second and the ninth, with probability 0.979 (David and Nagaraja, section 7.1)
    found = quantiles(MonteCarlo(1, 10), np.arange(10.0)[::-1], levels=[0.5])
    assert (found.low[0, 0], found.value[0, 0], found.high[0, 0]) == (1.0, 4.0, 8.0)


@pytest.mark.parametrize("level", [0.05, 0.5, 0.9])
def test_the_interval_is_the_narrowest_pair_of_tails_of_the_binomial_law(level):
    n = 200
    found = quantiles(MonteCarlo(1, n), np.arange(1.0, n + 1), levels=[level], confidence=0.9)
    low, high = found.low[0, 0], found.high[0, 0]
    law = stats.binom(n, level)
    assert law.cdf(low - 1) <= 0.05 < law.cdf(low)
    assert law.sf(high - 1) <= 0.05 < law.sf(high - 2)


@pytest.mark.parametrize("make", [MonteCarlo, LatinHypercube])
def test_intervals_hold_the_quantile_of_a_function_at_least_as_often_as_they_say(make):
    held = []
    for seed in range(300):
        design = make(2, 80, seed)
        found = quantiles(design, np.exp(design.points()[:, 0]), levels=[0.1, 0.5])
        held.append((found.low[0] <= np.exp([0.1, 0.5])) & (np.exp([0.1, 0.5]) <= found.high[0]))
    # three standard errors below 95 % over 300 designs
    assert (np.mean(held, axis=0) > 0.95 - 3 * (0.95 * 0.05 / 300) ** 0.5).all()


def test_too_few_runs_leave_an_end_open():
    found = quantiles(MonteCarlo(1, 5), np.arange(5.0), levels=[0.01, 0.99])
    assert found.low[0, 0] == -np.inf
    assert found.high[0, 1] == np.inf
    assert np.isfinite(found.value).all()


def test_failed_runs_widen_the_interval_to_all_that_they_could_have_been():
    rng = np.random.default_rng(3)
    design = MonteCarlo(1, 100)
    y = rng.normal(size=100)
    failed = np.where(np.arange(100) < 7, np.nan, y)
    found = quantiles(design, np.stack([failed, y], axis=1), ["failed", "all"])
    assert found.failures.tolist() == [7, 0]
    assert np.isnan(found.value[0]).all()
    for stand_in in (-np.inf, np.inf, 0.3):
        other = quantiles(design, np.where(np.isnan(failed), stand_in, failed))
        assert (found.low[0] <= other.low[0]).all()
        assert (other.high[0] <= found.high[0]).all()
    # the ends are reached: by all failed runs below, and by all above
    np.testing.assert_array_equal(found.low[0], quantiles(design, np.nan_to_num(failed, nan=-np.inf)).low[0])
    np.testing.assert_array_equal(found.high[0], quantiles(design, np.nan_to_num(failed, nan=np.inf)).high[0])
    np.testing.assert_array_equal(found.low[1], quantiles(design, y).low[0])


def test_runs_that_all_failed_bound_nothing():
    found = quantiles(MonteCarlo(1, 50), np.full(50, np.nan), levels=[0.5])
    assert (found.low[0, 0], found.high[0, 0], found.failures[0]) == (-np.inf, np.inf, 50)


def test_an_infinite_output_is_an_output():
    y = np.where(np.arange(100) < 60, np.inf, np.arange(100.0))
    found = quantiles(MonteCarlo(1, 100), y, levels=[0.1, 0.9])
    assert np.isfinite(found.value[0, 0])
    assert found.value[0, 1] == np.inf
    assert found.failures[0] == 0


def test_a_share_has_the_interval_of_clopper_and_pearson():
    for yes, runs in ((3, 20), (0, 15), (15, 15), (470, 1000)):
        found = share(np.arange(runs) < yes)
        want = stats.binomtest(yes, runs).proportion_ci(0.95, method="exact")
        assert found.value == yes / runs
        assert (found.low, found.high) == pytest.approx((want.low, want.high), rel=1e-9)  # two roads to one root


def test_failed_runs_of_a_share_could_have_gone_either_way():
    flags = np.array([1.0] * 8 + [0.0] * 10 + [np.nan] * 2)
    found = share(flags)
    assert np.isnan(found.value)
    assert (found.runs, found.failures) == (20, 2)
    assert found.low == share(np.nan_to_num(flags, nan=0.0)).low
    assert found.high == share(np.nan_to_num(flags, nan=1.0)).high


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (
            lambda: quantiles(SobolDesign(1, 8), np.zeros(24)),
            "must be a `MonteCarlo` or a `LatinHypercube`; got a `SobolDesign`",
        ),
        (lambda: quantiles(MonteCarlo(1, 9), np.zeros(8)), "a row for each of the 9 runs"),
        (lambda: quantiles(MonteCarlo(1, 9), np.zeros(9), levels=[0.0]), r"between 0 and 1.*got \(0.0,\)"),
        (lambda: quantiles(MonteCarlo(1, 9), np.zeros(9), levels=[95]), r"between 0 and 1.*got \(95.0,\)"),
        (lambda: quantiles(MonteCarlo(1, 9), np.zeros(9), levels=[np.nan]), "between 0 and 1.*nan"),
        (lambda: quantiles(MonteCarlo(1, 9), np.zeros(9), levels=[]), "at least one"),
        (lambda: quantiles(MonteCarlo(1, 9), np.zeros(9), confidence=0.0), "between 0 and 1; got 0.0"),
        (lambda: quantiles(MonteCarlo(1, 9), np.zeros(9), levels=0.5), "a tuple of `float`; got 0.5: one alone"),
        (lambda: quantiles(MonteCarlo(1, 9), np.zeros(9), levels="a"), "a tuple of `float`; got 'a'"),
        (lambda: share("abc"), "one 0, 1 or NaN a run, at least one; got 'abc'"),
        (lambda: share([True, None]), "one 0, 1 or NaN a run"),
        (lambda: share([]), "one 0, 1 or NaN a run"),
        (lambda: share([0.5]), "one 0, 1 or NaN a run"),
        (lambda: share([[1.0]]), "one 0, 1 or NaN a run"),
    ],
)
def test_what_has_no_quantile_is_refused_in_a_sentence(call, said):
    with pytest.raises(ValueError, match=said):
        call()

"""Distributions against SciPy's, and what is no distribution."""

import numpy as np
import pytest
from scipy import stats

from workbench.engine.distributions import LogNormal, LogUniform, Normal, Triangular, Uniform

U = np.array([1e-9, 1e-4, 0.03, 0.25, 0.5, 0.77, 0.999, 1 - 1e-9])
CASES = [
    (Uniform(-2.0, 3.0), stats.uniform(-2, 5)),
    (LogUniform(0.01, 100.0), stats.loguniform(0.01, 100)),
    (Triangular(0.0, 0.75, 1.0), stats.triang(0.75)),
    (Triangular(2.0, 2.0, 5.0), stats.triang(0.0, 2, 3)),
    (Triangular(2.0, 5.0, 5.0), stats.triang(1.0, 2, 3)),
    (Normal(1.0, 0.3), stats.norm(1, 0.3)),
    (Normal(1.0, 2.0, 0.0, 4.0), stats.truncnorm(-0.5, 1.5, 1, 2)),
    (Normal(0.0, 1.0, 4.0), stats.truncnorm(4, np.inf)),
    (Normal(0.0, 1.0, high=-4.0), stats.truncnorm(-np.inf, -4)),
    (LogNormal(2.0, 0.5), stats.lognorm(0.5, scale=2)),
]


@pytest.mark.parametrize(("ours", "theirs"), CASES, ids=[str(ours) for ours, _ in CASES])
def test_a_quantile_is_scipys(ours, theirs):
    # 1e-7: 1 - u has an absolute error of 1e-16, which is 1e-7 of what is left at the end
    np.testing.assert_allclose(ours.quantile(U), theirs.ppf(U), rtol=1e-7, atol=1e-9)


@pytest.mark.parametrize(("ours", "theirs"), CASES, ids=[str(ours) for ours, _ in CASES])
def test_the_ends_of_the_cube_are_the_ends_of_the_range(ours, theirs):
    least, largest = ours.quantile(np.array([0.0, 1.0]))
    assert least == (0.0 if isinstance(ours, LogNormal) else ours.low)
    assert largest == ours.high


def test_a_lognormal_number_between_cuts_is_the_exponential_of_a_normal_one_between_theirs():
    cut, log = LogNormal(2.0, 0.5, 1.0, 5.0), Normal(np.log(2.0), 0.5, 0.0, np.log(5.0))
    np.testing.assert_allclose(cut.quantile(U), np.exp(log.quantile(U)), rtol=1e-12)  # some rounding


def test_no_design_draws_beyond_the_reach_of_a_bell_and_none_reaches_its_open_ends():
    low, high = Normal(1.0, 0.1).reach()
    assert (low, high) == pytest.approx((1 - 0.62, 1 + 0.62), abs=0.01)  # 6.2 deviations lie beyond 2^-31
    assert LogNormal(1.0, 1.0).reach()[0] > 0
    assert Normal(1.0, 0.1, low=0.5).reach() == (0.5, pytest.approx(high, rel=1e-6))  # the cut takes 3e-7 of the bell
    assert LogUniform(0.1, 10.0).reach() == (0.1, 10.0)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Uniform(2.0, 1.0), r"`Uniform\(low=..., high=...\)` .* low < high; got 2 and 1: a reversed range"),
        (lambda: Uniform(1.0, 1.0), "an empty range, which varies nothing"),
        (lambda: Uniform(0.0, np.inf), r"`Uniform\(high=...\)` must be a finite number; got inf"),
        (lambda: Uniform(np.nan, 1.0), r"`Uniform\(low=...\)` must be a finite number; got nan"),
        (lambda: Uniform(-1.5e308, 1.5e308), "too wide"),
        (lambda: LogUniform(0.0, 1.0), r"`LogUniform\(low=...\)` must be a positive, finite number; got 0"),
        (lambda: LogUniform(3.0, 1.0), "a reversed range"),
        (
            lambda: Triangular(0.0, 2.0, 1.0),
            r"`Triangular\(mode=...\)` .* at least 0, at most 1; got 2",
        ),
        (lambda: Uniform(0.0, 1.0).quantile(1.5), "takes probabilities from 0 to 1"),
        (lambda: Uniform(0.0, 1.0).quantile("x"), "must be a number or an array of numbers; got 'x'"),
        (lambda: Triangular(0.0, np.nan, 1.0), "finite number; got nan"),
        (lambda: Normal(0.0, 0.0), r"`Normal\(deviation=...\)` must be a positive, finite number; got 0"),
        (lambda: Normal(0.0, -1.0), "must be a positive"),
        (lambda: Normal(np.inf, 1.0), "must be a finite number; got inf"),
        (lambda: Normal(0.0, 1.0, 2.0, 1.0), "a reversed range"),
        (lambda: Normal(0.0, 1.0, np.inf), "must be a finite number; got inf"),
        (lambda: Normal(0.0, 1.0, 7.0), "must keep at least 1e-09 of the bell"),
        (lambda: LogNormal(-1.0, 1.0), r"`LogNormal\(median=...\)` must be a positive"),
        (lambda: LogNormal(1.0, 1.0, low=0.0), r"`LogNormal\(low=...\)` must be a positive"),
        (lambda: LogNormal(1.0, 1.0, 2.0, 2.0), "an empty range"),
    ],
)
def test_what_is_no_distribution_is_refused_in_a_sentence(make, said):
    with pytest.raises(ValueError, match=said):
        make()

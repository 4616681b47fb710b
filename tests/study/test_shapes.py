"""Shapes: groups of draws and heavy tails, how often they are seen where there are none, and what predicts them."""

import numpy as np
import pytest
from scipy import stats
from scipy.optimize import linprog

from workbench.study.evidence import paired, shapes
from workbench.study.evidence.sample_shapes import _predictor, dip, gap

RUNS = 160
RNG = np.random.default_rng(8)
FACTORS = ("first mass", "second mass", "friction")
DRAWN = RNG.uniform(0.7, 1.3, size=(RUNS, 3))
STEADY = 3.3 + 0.1 * RNG.normal(size=RUNS)


def shape(y, drawn=DRAWN, **options):
    """The shape of one law beside a steady one."""
    return shapes(paired({"law": y, "steady": STEADY}, metric="cost"), drawn, FACTORS, **options)[0]


@pytest.mark.parametrize(
    "draw",
    [
        lambda rng: 20 + rng.normal(size=RUNS),
        pytest.param(lambda rng: rng.lognormal(size=RUNS), marks=pytest.mark.heavy),
        pytest.param(lambda rng: rng.exponential(size=RUNS), marks=pytest.mark.heavy),
        pytest.param(lambda rng: rng.uniform(size=RUNS), marks=pytest.mark.heavy),
        pytest.param(lambda rng: rng.pareto(1.5, size=RUNS) + 1, marks=pytest.mark.heavy),
        lambda rng: rng.standard_t(2, size=RUNS),
    ],
)
def test_one_mode_is_taken_for_two_groups_no_more_often_than_said(draw):
    rng = np.random.default_rng(4)
    kinds = [shape(draw(rng)).kind for _ in range(200)]
    assert kinds.count("two groups") / 200 <= 0.05  # the confidence, which both laws share


def test_an_exponential_law_is_seldom_taken_for_a_heavy_tail_and_a_heavier_one_mostly():
    rng = np.random.default_rng(4)
    found = [[shape(y).kind for y in rng.exponential(size=(200, RUNS)) ** power] for power in (1, 2)]
    # one in forty, within three standard errors of a share over 200 samples
    assert found[0].count("heavy tail") / 200 <= 0.025 + 3 * (0.025 * 0.975 / 200) ** 0.5
    assert found[1].count("heavy tail") / 200 > 0.9


def test_draws_apart_are_found_with_the_factor_that_predicts_them():
    light = DRAWN[:, 1] < 0.8
    found = shape(np.where(light, 18 + 3 * RNG.normal(size=RUNS), STEADY))
    assert found.kind == "two groups"
    np.testing.assert_array_equal(found.upper, np.flatnonzero(light))
    assert (found.predictor.factor, found.predictor.side) == ("second mass", "below")
    assert DRAWN[light, 1].max() < found.predictor.limit < DRAWN[~light, 1].min()
    count = light.sum()
    assert found.sentence == (
        f"law: two groups: {100 * count / RUNS:.2g} % of the draws have a cost of {found.limit:.3g} or more; "
        f"{count} of {count} of them have second mass below {found.predictor.limit:.3g}, as have 0 of the "
        f"{RUNS - count} others"
    )


def test_two_equal_groups_that_overlap_are_found_by_the_dip():
    rng = np.random.default_rng(4)
    y = np.exp(np.where(np.arange(RUNS) < 80, 0.0, 4.0) + rng.normal(size=RUNS))
    assert gap(np.log(y))[0] > 0.05
    found = shape(y)
    assert found.kind == "two groups"
    assert np.isin(np.arange(80, RUNS), found.upper).mean() > 0.9


def test_failed_runs_are_a_group_of_their_own():
    found = shape(np.where(DRAWN[:, 2] > 1.25, np.nan, STEADY))
    assert found.kind == "failures"
    assert (found.predictor.factor, found.predictor.side, found.predictor.outside) == ("friction", "above", 0)
    assert "runs failed" in found.sentence


def test_no_predictor_is_named_where_none_is_significant():
    y = RNG.permutation(np.where(np.arange(RUNS) < 25, 18.0, 3.0) * np.exp(0.05 * RNG.normal(size=RUNS)))
    named = [shape(y, np.random.default_rng(k).uniform(size=(RUNS, 3))).predictor for k in range(200)]
    # one in forty, for all factors together
    assert sum(one is not None for one in named) / 200 <= 0.025 + 3 * (0.025 * 0.975 / 200) ** 0.5
    none = next(k for k, one in enumerate(named) if one is None)
    assert "no factor predicts which" in shape(y, np.random.default_rng(none).uniform(size=(RUNS, 3))).sentence


def test_the_chance_of_a_predictor_is_that_of_mann_and_whitney_times_the_factors():
    drawn = np.round(DRAWN, 1)  # with ties
    upper = np.arange(RUNS) < 20
    found = _predictor(upper, drawn, FACTORS, 10.0)
    chances = [
        stats.mannwhitneyu(a, b, method="asymptotic", use_continuity=False)
        for a, b in zip(drawn[upper].T, drawn[~upper].T, strict=True)
    ]
    best = min(chances, key=lambda one: one.pvalue)
    assert found.p == pytest.approx(3 * best.pvalue, rel=1e-9)
    assert found.area == pytest.approx(best.statistic / (20 * 140), rel=1e-12)


def nearest_of_one_mode(x):
    """The distance of a sample to the laws of one mode, by a linear program for each place of the mode."""
    x, n = np.sort(x), len(x)
    reached, before = np.arange(1, n + 1) / n, np.arange(n) / n
    best = 1.0
    for mode in range(n):
        rows, ends = [], []
        left = [i if i <= mode else i + 1 for i in range(n)]  # the law's value on the left of a point, and on its right
        right = [i if i < mode else i + 1 for i in range(n)]

        def at_most(end, rows=rows, ends=ends, **terms):
            row = np.zeros(n + 2)
            for place, size in terms.items():
                row[int(place[1:])] += size
            rows.append(row)
            ends.append(end)

        for i in range(n):
            for place, value in ((right[i], reached[i]), (left[i], before[i])):
                at_most(value, **{f"v{place}": 1, f"v{n + 1}": -1})
                at_most(-value, **{f"v{place}": -1, f"v{n + 1}": -1})
            at_most(0, **{f"v{i}": 1, f"v{i + 1}": -1})
        for i in range(1, n - 1):
            if i != mode:
                a, b = 1 / (x[i] - x[i - 1]), 1 / (x[i + 1] - x[i])
                places, sign = (left[i - 1 : i + 2], 1) if i < mode else (right[i - 1 : i + 2], -1)
                at_most(0, **{f"v{places[0]}": -sign * a, f"v{places[1]}": sign * (a + b), f"v{places[2]}": -sign * b})
        found = linprog(np.eye(n + 2)[-1], A_ub=np.array(rows), b_ub=ends, bounds=[(0, 1)] * (n + 1) + [(0, None)])
        best = min(best, found.fun)
    return best


def test_the_dip_is_the_distance_to_the_nearest_law_of_one_mode():
    rng = np.random.default_rng(2)
    for k in range(4):
        x = rng.normal(size=14) + (k % 2) * 4 * (rng.random(14) < 0.4)
        assert dip(x) == pytest.approx(nearest_of_one_mode(x), abs=1e-9)
    assert dip(np.repeat([0.0, 1.0], 5)) == 0.25


def test_a_gap_in_a_uniform_sample_is_as_probable_as_it_says():
    rng = np.random.default_rng(2)
    chances = np.array([gap(rng.uniform(size=40))[0] for _ in range(2000)])
    assert np.mean(chances <= 0.2) <= 0.2
    assert (chances <= 0.9).any()


@pytest.mark.parametrize(
    ("drawn", "why"),
    [
        (np.ones((RUNS, 2)), r"160 rows of 3 finite numbers.*got shape \(160, 2\)"),
        (np.full((RUNS, 3), np.nan), "finite"),
    ],
)
def test_draws_that_fit_no_run_are_refused(drawn, why):
    with pytest.raises(ValueError, match=why):
        shape(STEADY, drawn)

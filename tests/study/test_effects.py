"""Morris's effects and tornadoes against closed forms, full enumeration and SALib."""

import itertools

import numpy as np
import pytest
from SALib.analyze import morris as salib

from tests.support.sensitivity_functions import ishigami, linear, over
from workbench.study.uncertainty import MorrisDesign, OneAtATime, morris, tornado

C = np.array([1.0, -2.0, 3.0, 0.0])


def every_effect(function, d: int, levels: int) -> list[np.ndarray]:
    """All elementary effects there are on the grid, factor by factor."""
    delta = levels / (2 * (levels - 1))
    grid = np.arange(levels) / (levels - 1)
    found = []
    for i in range(d):
        axes = [grid[: levels // 2] if k == i else grid for k in range(d)]
        low = np.array(list(itertools.product(*axes)))
        found.append((function(low + delta * np.eye(d)[i]) - function(low)) / delta)
    return found


def test_effects_of_a_linear_function_are_its_slopes_without_scatter():
    design = MorrisDesign(4, 10, seed=2)
    found = morris(design, over(design, linear, C), ["y"])["y"]
    np.testing.assert_allclose(found.mu.value, C, atol=1e-12)
    np.testing.assert_allclose(found.mu_star.value, np.abs(C), atol=1e-12)
    np.testing.assert_allclose(found.sigma.value, 0, atol=1e-12)
    np.testing.assert_allclose(found.mu.half, 0, atol=1e-12)


@pytest.mark.parametrize("levels", [4, 6])
def test_moments_are_those_of_all_effects_there_are(levels):
    r = 400
    design = MorrisDesign(3, r, levels, seed=3)
    found = morris(design, over(design, ishigami))["output 1"]
    for i, effects in enumerate(every_effect(ishigami, 3, levels)):
        # 4.5 standard errors of a mean; a deviation of few discrete effects is known less well
        limit = 4.5 * effects.std() / r**0.5 + 1e-9
        assert abs(found.mu.value[i] - effects.mean()) < limit
        assert abs(found.mu_star.value[i] - np.abs(effects).mean()) < limit
        assert found.sigma.value[i] == pytest.approx(effects.std(), rel=0.2)


def test_salib_finds_the_same_moments_in_the_same_runs():
    design = MorrisDesign(3, 50, seed=1)
    points, y = design.points(), over(design, ishigami)
    problem = {"num_vars": 3, "names": ["a", "b", "c"], "bounds": [[0, 1]] * 3}
    theirs = salib.analyze(problem, points, y, num_levels=4, seed=1)
    found = morris(design, y)["output 1"]
    for ours, name in ((found.mu, "mu"), (found.mu_star, "mu_star"), (found.sigma, "sigma")):
        np.testing.assert_allclose(ours.value, np.asarray(theirs[name], dtype=float), rtol=1e-10)


def test_intervals_of_means_hold_the_truth_as_often_as_they_say():
    exact = every_effect(ishigami, 3, 4)
    held = []
    for seed in range(100):
        design = MorrisDesign(3, 50, seed=seed)
        found = morris(design, over(design, ishigami))["output 1"]
        held.append(np.abs(found.mu.value - [e.mean() for e in exact]) <= found.mu.half + 1e-9)
        held.append(np.abs(found.mu_star.value - [np.abs(e).mean() for e in exact]) <= found.mu_star.half + 1e-9)
    assert 0.90 <= np.mean(held) <= 0.995


def test_the_interval_of_sigma_is_the_jackknifes():
    rng = np.random.default_rng(5)
    design = MorrisDesign(1, 30, seed=4)
    y = rng.normal(size=design.size)
    found = morris(design, y)["output 1"]
    moves = np.sign(np.diff(design.points().reshape(30, 2), axis=1)[:, 0])
    effects = moves * np.diff(y.reshape(30, 2), axis=1)[:, 0] / design.delta
    without = np.array([np.delete(effects, k).std(ddof=1) for k in range(30)])
    # Student's quantile with 29 degrees of freedom: 2.0452
    want = 2.0452 * np.sqrt(29 / 30 * ((without - without.mean()) ** 2).sum())
    assert found.sigma.half[0] == pytest.approx(want, rel=1e-4)


def test_few_trajectories_are_told_of():
    few, enough = MorrisDesign(3, 49), MorrisDesign(3, 50)
    assert morris(few, over(few, ishigami)).remarks[0].startswith("49 trajectories are few: the intervals")
    assert morris(enough, over(enough, ishigami)).remarks == ()


def test_two_trajectories_leave_the_interval_of_sigma_open():
    design = MorrisDesign(2, 2)
    assert np.isinf(morris(design, np.arange(6.0) ** 3)["output 1"].sigma.half).all()


def test_effects_of_outputs_that_failed_are_refused_and_others_are_not():
    design = MorrisDesign(3, 10)
    y = over(design, ishigami)
    bad = np.where(np.arange(len(y)) == 5, np.nan, y)
    both = morris(design, np.stack([y, bad], axis=1), ["good", "bad"])
    assert "1 of 40 runs failed" in both.refusals["bad"]
    assert np.isnan(both.mu_star.value[1]).all()
    np.testing.assert_allclose(both["good"].mu.value, morris(design, y).mu.value[0], rtol=1e-12)
    with pytest.raises(ValueError, match="no result for 'bad'"):
        both["bad"]
    with pytest.raises(ValueError, match="got none: 'output 1': 1 of 40 runs failed"):
        morris(design, bad)


def test_a_tornado_shows_each_factor_by_itself_the_widest_bar_first():
    design = OneAtATime(4, (0.0, 1.0))
    found = tornado(design, over(design, linear, C), ["y"], factors=["a", "b", "c", "d"])["y"]
    assert found.base == pytest.approx(C.sum() / 2)
    np.testing.assert_allclose(found.moved_outputs - found.base, np.outer(C, [-0.5, 0.5]), atol=1e-15)
    np.testing.assert_allclose(found.swing, np.abs(C), atol=1e-15)
    assert [found.factors[i] for i in found.order] == ["c", "b", "a", "d"]


def test_a_bar_to_one_side_begins_at_the_base():
    design = OneAtATime(1, (0.0, 1.0))
    assert tornado(design, np.array([0.0, 3.0, 2.0])).swing.tolist() == [[3.0]]


def test_the_bars_of_a_tornado_are_the_outputs_bit_for_bit():
    design = OneAtATime(3)
    y = 1e3 + over(design, ishigami)
    np.testing.assert_array_equal(tornado(design, y).moved_outputs[0].ravel(), y[1:])


def test_a_tornado_with_a_failed_run_is_refused():
    y = np.array([1.0, 2.0, np.nan])
    with pytest.raises(ValueError, match="1 of 3 runs failed"):
        tornado(OneAtATime(1), y)


def test_a_design_of_another_kind_is_refused():
    with pytest.raises(ValueError, match="must be a `MorrisDesign`; got an `OneAtATime`"):
        morris(OneAtATime(1), np.zeros(3))
    with pytest.raises(ValueError, match="must be an `OneAtATime`; got a `MorrisDesign`"):
        tornado(MorrisDesign(1, 2), np.zeros(4))

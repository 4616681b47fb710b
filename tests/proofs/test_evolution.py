"""Differential evolution: it finds known optima, keeps constraints, and repeats itself."""

import numpy as np
import pytest
from scipy.optimize import differential_evolution

from workbench.proofs.differential_evolution import TrialValues, evolve


def free(value):
    return TrialValues(value, np.zeros(len(value)))


def sphere(u):
    return free(-((u - 0.3) ** 2).sum(axis=1))


def rastrigin(u):
    x = 10 * (u - 0.62)
    return free(-(10 + x**2 - 10 * np.cos(2 * np.pi * x)).sum(axis=1))


def best(judge, dimensions, seed=1, population=64, generations=80):
    u, worth = evolve(judge, dimensions, population, generations, np.random.default_rng(seed))
    return u[worth.best()], worth.value[worth.best()]


@pytest.mark.parametrize("seed", range(5))
def test_the_top_of_a_hill_is_found(seed):
    u, value = best(sphere, 5, seed)
    np.testing.assert_allclose(u, 0.3, atol=1e-3)
    assert value > -1e-6


def test_the_highest_of_many_hills_is_found():
    found = [best(rastrigin, 2, seed)[0] for seed in range(5)]
    # five starts: with hundreds of hills one may end on a lower one, most do not
    assert sum(np.abs(u - 0.62).max() < 1e-3 for u in found) >= 4


def test_a_constraint_moves_the_optimum_to_its_edge():
    def judge(u):
        return TrialValues(-((u - 0.3) ** 2).sum(axis=1), 0.5 - u[:, 0])  # u_0 >= 0.5

    u, _ = best(judge, 3)
    np.testing.assert_allclose(u, [0.5, 0.3, 0.3], atol=2e-3)


def test_an_inadmissible_start_is_led_to_what_is_admissible():
    def judge(u):
        return TrialValues(u[:, 0], np.abs(u - 0.9).max(axis=1) - 0.02)  # 0.04^3 of the cube

    u, _ = best(judge, 3)
    assert np.abs(u - 0.9).max() <= 0.02


def test_the_same_seed_gives_the_same_search_and_another_seed_another():
    np.testing.assert_array_equal(best(sphere, 3, 7)[0], best(sphere, 3, 7)[0])
    assert (best(sphere, 3, 7, generations=3)[0] != best(sphere, 3, 8, generations=3)[0]).any()


def test_no_trial_leaves_the_cube():
    seen = []

    def judge(u):
        seen.append(u)
        return free(u.sum(axis=1))

    best(judge, 4)
    assert np.min(seen) >= 0
    assert np.max(seen) <= 1


def test_the_first_population_has_one_point_in_every_slice_of_every_axis():
    first = []
    evolve(lambda u: first.append(u) or free(u.sum(axis=1)), 3, 16, 0, np.random.default_rng(0))
    np.testing.assert_array_equal(np.sort((first[0] * 16).astype(int), axis=0), np.tile(np.arange(16)[:, None], (1, 3)))


def test_the_first_population_is_drawn_from_a_box_which_later_trials_leave():
    seen = []

    def judge(u):
        seen.append(u)
        return sphere(u)

    low, high = np.array([0.7, 0.8]), np.array([0.75, 0.9])  # the top is at 0.3
    u, worth = evolve(judge, 2, 16, 40, np.random.default_rng(1), (low, high))
    slices = ((seen[0] - low) / (high - low) * 16).astype(int)
    np.testing.assert_array_equal(np.sort(slices, axis=0), np.tile(np.arange(16)[:, None], (1, 2)))
    np.testing.assert_allclose(u[worth.best()], 0.3, atol=1e-3)


def test_the_whole_cube_as_a_box_changes_no_bit():
    cube = (np.zeros(3), np.ones(3))
    one, other = (evolve(sphere, 3, 8, 5, np.random.default_rng(2), *start)[0] for start in ((), (cube,)))
    assert one.tobytes() == other.tobytes()


@pytest.mark.parametrize("start", [([0.5], [0.5]), ([-0.1], [1.0]), ([0.0], [1.1]), ([0.0, 0.0], [1.0, 1.0])])
def test_a_box_that_is_none_in_the_cube_is_refused(start):
    with pytest.raises(ValueError, match=r"`evolve\(start=...\)` must be the low and the high ends \(1,\) of a box"):
        evolve(sphere, 1, 4, 1, np.random.default_rng(0), start)


def test_a_search_that_is_over_asks_no_more():
    asked = []
    u, _ = evolve(
        lambda u: asked.append(u) or sphere(u), 2, 8, 20, np.random.default_rng(0), None, lambda: len(asked) > 4
    )
    assert len(asked) == 5
    np.testing.assert_array_equal(u, evolve(sphere, 2, 8, 4, np.random.default_rng(0))[0])


def test_trials_from_the_best_alone_climb_one_hill_faster():
    def left(seed, mixed):
        worth = evolve(sphere, 6, 24, 25, np.random.default_rng(seed), mix_strategies=mixed)[1]
        return -worth.value.max()

    # over twenty seeds, as one may be lucky
    keen, mixed = (np.median([left(seed, way) for seed in range(20)]) for way in (False, True))
    assert keen < mixed / 3


@pytest.mark.parametrize(("dimensions", "population"), [(4, 16), (8, 24), (12, 32)])
def test_a_long_hill_is_climbed_no_slower_than_by_scipy(dimensions, population):
    top, budget = np.linspace(0.35, 0.65, dimensions), 100 * dimensions
    weights = np.logspace(0, 2, dimensions)  # a hundred times as steep along the last axis as along the first

    def below(u):
        """How far below the top."""
        return (weights * (u - top) ** 2).sum(axis=1)

    def ours(seed):
        rng = np.random.default_rng(seed)
        return -evolve(
            lambda u: free(-below(u)), dimensions, population, budget // population - 1, rng, mix_strategies=False
        )[1].value.max()

    def theirs(seed):
        asked = {"maxiter": budget // population - 1, "popsize": population, "init": starts(seed), "polish": False}
        asked |= {"vectorized": True, "updating": "deferred", "tol": 0.0, "rng": seed}
        return differential_evolution(lambda u: below(u.T), [(0.0, 1.0)] * dimensions, **asked).fun

    def starts(seed):
        return np.random.default_rng(seed).random((population, dimensions))

    # medians, as one may be lucky; SciPy's default is DE/best/1 with the crossover 0.7 and weights from 0.5 to 1
    assert np.median([ours(seed) for seed in range(9)]) < np.median([theirs(seed) for seed in range(9)])


def test_infinity_is_best_and_minus_infinity_worst():
    judged = free(np.array([1.0, np.inf, -np.inf]))
    assert judged.best() == 1
    assert judged.beats(free(np.zeros(3))).tolist() == [True, True, False]


def test_an_admissible_trial_beats_any_other():
    a, b = TrialValues(np.array([-5.0]), np.array([0.0])), TrialValues(np.array([9.0]), np.array([0.1]))
    assert a.beats(b).all()
    assert not b.beats(a).any()

"""Designs: the same points whatever the chunks, in the places their definitions say."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some
from scipy.stats import qmc

from workbench.study.uncertainty import LatinHypercube, ListedPoints, MonteCarlo, MorrisDesign, OneAtATime, SobolDesign
from workbench.study.uncertainty.sobol_design import MOST_DIMENSIONS

DESIGNS = [
    SobolDesign(3, 64, second_order=True, seed=5),
    SobolDesign(5, 32),
    SobolDesign(1, 8),
    MorrisDesign(4, 10, seed=1),
    MorrisDesign(1, 3, levels=2),
    LatinHypercube(3, 50, seed=2),
    MonteCarlo(5, 40, seed=3),
    OneAtATime(4, (0.1, 0.5, 0.9)),
]


@pytest.mark.parametrize("design", DESIGNS, ids=str)
@given(data=some.data())
def test_a_chunk_holds_the_points_of_the_whole_bit_for_bit(design, data):
    first = data.draw(some.integers(0, design.size))
    last = data.draw(some.integers(first, design.size))
    np.testing.assert_array_equal(design.points(first, last), design.points()[first:last])


@pytest.mark.parametrize("design", DESIGNS, ids=str)
def test_all_points_lie_in_the_unit_cube_one_a_run(design):
    points = design.points()
    assert points.shape == (design.size, design.dimensions)
    assert ((points >= 0) & (points <= 1)).all()


@pytest.mark.parametrize("make", [lambda s: SobolDesign(2, 8, seed=s), lambda s: MorrisDesign(6, 4, seed=s)])
def test_seeds_make_different_points_and_one_seed_the_same(make):
    assert not np.array_equal(make(0).points(), make(1).points())
    np.testing.assert_array_equal(make(2**64 - 1).points(), make(2**64 - 1).points())


@pytest.mark.parametrize("second_order", [False, True])
def test_a_block_of_saltelli_swaps_one_coordinate_at_a_time(second_order):
    design = SobolDesign(4, 16, second_order, seed=9)
    blocks = design.points().reshape(16, design.block, 4)
    A, B = blocks[:, 0], blocks[:, -1]
    for i in range(4):
        np.testing.assert_array_equal(blocks[:, 1 + i], np.where(np.arange(4) == i, B, A))
        if second_order:
            np.testing.assert_array_equal(blocks[:, 5 + i], np.where(np.arange(4) == i, A, B))
    assert design.size == 16 * (10 if second_order else 6)


def test_there_are_as_many_factors_as_scipy_has_pairs_of_direction_numbers():
    assert MOST_DIMENSIONS == qmc.Sobol.MAXDIM // 2


def test_each_scramble_is_a_net_with_one_point_in_every_slice_of_every_axis():
    design = SobolDesign(3, 64, seed=4)
    blocks = design.points().reshape(4, 16, design.block, 3)
    for net in blocks:
        for points in (net[:, 0], net[:, -1]):
            np.testing.assert_array_equal(
                np.sort(np.floor(points * 16), axis=0), np.arange(16)[:, np.newaxis] + [0] * 3
            )


def test_scrambles_share_no_point():
    A = SobolDesign(2, 64, seed=4).points().reshape(64, 4, 2)[:, 0]
    assert len(np.unique(A, axis=0)) == 64


def test_a_latin_hypercube_has_one_point_in_every_slice_of_every_axis():
    points = LatinHypercube(4, 37, seed=8).points()
    np.testing.assert_array_equal(np.sort(np.floor(points * 37), axis=0), np.arange(37)[:, np.newaxis] + [0] * 4)


def test_a_longer_monte_carlo_design_begins_with_the_points_of_a_shorter_one():
    np.testing.assert_array_equal(MonteCarlo(3, 1000, 7).points(0, 10), MonteCarlo(3, 10, 7).points())


def test_monte_carlo_points_are_uniform_and_independent_of_one_another():
    points = MonteCarlo(6, 20_000, seed=1).points()
    # 5 standard errors of a correlation over 20,000 points, and of a mean of uniform numbers
    assert np.abs(np.corrcoef(points.T) - np.eye(6)).max() < 5 / 20_000**0.5
    assert np.abs(points.mean(axis=0) - 0.5).max() < 5 / (12 * 20_000) ** 0.5
    lagged = np.corrcoef(points[:-1, 0], points[1:, 0])[0, 1]
    assert abs(lagged) < 5 / 20_000**0.5


def test_every_factor_moves_once_in_a_trajectory_of_morris_by_delta():
    design = MorrisDesign(5, 400, levels=6, seed=3)
    paths = design.points().reshape(400, 6, 5)
    moves = np.diff(paths, axis=1)
    np.testing.assert_array_equal((moves != 0).sum(axis=1), 1)
    np.testing.assert_array_equal((moves != 0).sum(axis=2), 1)
    np.testing.assert_allclose(np.abs(moves[moves != 0]), 6 / 10, rtol=1e-12)
    np.testing.assert_allclose(paths * 5, np.round(paths * 5), atol=1e-12)


def test_morris_visits_every_level_order_and_direction_alike():
    design = MorrisDesign(3, 6000, levels=4, seed=2)
    paths = design.points().reshape(6000, 4, 3)
    moves = np.diff(paths, axis=1)
    # 5 standard errors of a binomial share over 6000 trajectories
    error = 5 * 0.5 / 6000**0.5
    levels = [(np.round(paths[:, 0] * 3) == level).mean(axis=0) for level in range(4)]
    np.testing.assert_allclose(levels, 1 / 4, atol=error)
    np.testing.assert_allclose((moves.sum(axis=1) > 0).mean(axis=0), 1 / 2, atol=error)
    np.testing.assert_allclose((moves != 0).mean(axis=0), 1 / 3, atol=error)


def test_one_at_a_time_moves_one_factor_from_the_base():
    points = OneAtATime(2, (0.0, 1.0)).points()
    np.testing.assert_array_equal(points, [[0.5, 0.5], [0.0, 0.5], [1.0, 0.5], [0.5, 0.0], [0.5, 1.0]])


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: SobolDesign(3, 1000), "must be a power of two.*got 1000. The nearest are 512 and 1024"),
        (lambda: SobolDesign(3, 0), "of pairs of points from 8 to 536870912; got 0"),
        (lambda: SobolDesign(3, 4), "from 8 to 536870912; got 4"),
        (lambda: SobolDesign(0, 8), "whole number of factors from 1 to 10600; got 0"),
        (lambda: SobolDesign(10_601, 8), "factors from 1 to 10600; got 10601"),
        (lambda: SobolDesign(3, 64.0), "got 64.0"),
        (lambda: SobolDesign(3, 64, seed=-1), "from 0 to 2.64 - 1.*got -1"),
        (lambda: SobolDesign(3, 64, seed=True), "got True"),
        (lambda: MorrisDesign(3, 1), "at least 2; got 1"),
        (lambda: MorrisDesign(3, 10, levels=5), "must be even.*got 5"),
        (lambda: MorrisDesign(3, 10, levels=0), "at least 2; got 0"),
        (lambda: MonteCarlo(3, 0), r"`MonteCarlo\(runs=...\)` must be a positive whole number; got 0"),
        (lambda: LatinHypercube(3, -5), r"`LatinHypercube\(runs=...\)`.*got -5"),
        (lambda: OneAtATime(3, ()), "at least one; got"),
        (lambda: OneAtATime(3, (0.1, 0.1)), "different quantiles"),
        (lambda: OneAtATime(3, (0.1, 1.1)), "a quantile, at least 0, at most 1; got 1.1"),
        (lambda: OneAtATime(3, (0.1, np.nan)), "a quantile, at least 0, at most 1; got nan"),
        (lambda: OneAtATime(3, base=2.0), r"`OneAtATime\(levels=..., base=...\)`"),
        (lambda: MonteCarlo(3, 10).points(5, 11), r"`points\(last=...\)` must be a whole number from 5 to 10; got 11"),
        (lambda: MonteCarlo(3, 10).points(6, 5), "from 6 to 10; got 5"),
        (lambda: SobolDesign(3, 8).points(-1, 5), "from 0 to 40; got -1"),
    ],
)
def test_what_is_no_design_is_refused_in_a_sentence(make, said):
    with pytest.raises(ValueError, match=said):
        make()


WHOLE = [int, np.int8, np.uint8, np.int64, np.uint64, lambda value: np.array(value, dtype=np.int16)]


@pytest.mark.parametrize("whole", WHOLE)
@pytest.mark.parametrize(
    ("kind", "numbers"),
    [
        (MonteCarlo, {"dimensions": 2, "runs": 64, "seed": 3}),
        (LatinHypercube, {"dimensions": 2, "runs": 64, "seed": 3}),
        (SobolDesign, {"dimensions": 2, "base": 64, "seed": 3}),
        (MorrisDesign, {"dimensions": 2, "trajectories": 64, "levels": 4, "seed": 3}),
        (OneAtATime, {"dimensions": 100}),
    ],
)
def test_whole_numbers_of_any_kind_make_the_same_design(kind, numbers, whole):
    design, plain = kind(**{name: whole(value) for name, value in numbers.items()}), kind(**numbers)
    assert design == plain
    assert {type(getattr(design, name)) for name in numbers} == {int}
    assert design.size == plain.size  # where an int8 would wrap
    np.testing.assert_array_equal(design.points(whole(0), whole(4)), plain.points(0, 4))


def test_listed_points_come_as_they_are_given():
    design = ListedPoints([[0.0, 0.5], [1.0, 0.25], [0.5, 0.5]])
    assert (design.dimensions, design.size) == (2, 3)
    assert design.points(1, 3).tolist() == [[1.0, 0.25], [0.5, 0.5]]


@pytest.mark.parametrize("wrong", [[], [0.5], [[]], [[1.5]], [[np.nan]], "no", [[0.1], [0.2, 0.3]]])
def test_what_is_no_list_of_points_is_refused(wrong):
    with pytest.raises(ValueError, match=r"`ListedPoints\(listed_points.*\)` must be"):
        ListedPoints(wrong)

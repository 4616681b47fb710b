"""Factors over the numbers of a loop: what they move, and what they may not."""

import numpy as np
import pytest

from workbench.core.layout import Entry, Layout
from workbench.core.numbers import Bounds
from workbench.engine.distributions import LogNormal, LogUniform, Normal, Uniform
from workbench.engine.factors import Factor, Space
from workbench.study.provenance import assumed_entry, stated_entry
from workbench.study.uncertainty import factor_table

PARAMETERS = Layout(
    (
        Entry("plant.mass", np.array([2.0, 3.0]), "kg", Bounds(0, np.inf, strict=True)),
        Entry("controller.K", np.diag([5.0, 4.0]), "N m", Bounds(symmetric=True, definite="positive")),
        Entry("controller.phi", np.array(0.1), "rad/s", Bounds(0, 1)),
        Entry("controller.offset", np.array(0.0), "rad"),
    )
)
STATES = Layout((Entry("plant.q", np.array([0.5, -0.5]), "rad"),))


def space(*factors: Factor) -> Space:
    return Space(factors, PARAMETERS, STATES)


def unpacked(one: Space, points):
    p, x0 = one.rows(np.array(points, dtype=float))
    return PARAMETERS.unpack(p) | STATES.unpack(x0)


def test_a_factor_sets_its_number_and_leaves_all_others_at_their_defaults():
    found = unpacked(space(Factor("phi", ("controller.phi",), Uniform(0.2, 0.4))), [[0.0], [0.5], [1.0]])
    np.testing.assert_allclose(found["controller.phi"], [0.2, 0.3, 0.4], rtol=1e-15)
    np.testing.assert_array_equal(found["plant.mass"], [[2.0, 3.0]] * 3)
    np.testing.assert_array_equal(found["plant.q"], [[0.5, -0.5]] * 3)


def test_paths_of_one_factor_move_together_over_parameters_and_initial_states():
    moved = Factor("x", ("plant.mass[0]", "plant.q[1]"), LogUniform(1.0, 100.0))
    found = unpacked(space(moved), [[0.5]])
    np.testing.assert_allclose(found["plant.mass"], [[10.0, 3.0]], rtol=1e-14)
    np.testing.assert_allclose(found["plant.q"], [[0.5, 10.0]], rtol=1e-14)


def test_a_share_keeps_the_proportions_of_vectors_and_matrices():
    shares = (
        Factor("masses", ("plant.mass",), Uniform(0.5, 1.5), share=True),
        Factor("gains", ("controller.K",), Uniform(1.0, 2.0), share=True),
    )
    found = unpacked(space(*shares), [[0.0, 1.0], [1.0, 0.5]])
    np.testing.assert_allclose(found["plant.mass"], [[1.0, 1.5], [3.0, 4.5]], rtol=1e-15)
    np.testing.assert_allclose(found["controller.K"], [np.diag([10.0, 8.0]), np.diag([7.5, 6.0])], rtol=1e-15)


def test_both_halves_of_a_symmetric_matrix_are_one_factor():
    both = Factor("k12", ("controller.K[0,1]", "controller.K[1,0]"), Uniform(-1.0, 1.0))
    np.testing.assert_allclose(unpacked(space(both), [[1.0]])["controller.K"], [[[5.0, 1.0], [1.0, 4.0]]])
    with pytest.raises(ValueError, match="'k12' goes from -1 to 1, too far: 'controller.K' must be symmetric"):
        space(Factor("k12", ("controller.K[0,1]",), Uniform(-1.0, 1.0)))


def test_factors_that_are_allowed_alone_and_not_together_are_refused_in_the_row():
    diagonal = Factor("k1", ("controller.K[0,0]",), Uniform(0.5, 5.0))
    beside = Factor("k12", ("controller.K[0,1]", "controller.K[1,0]"), Uniform(0.0, 4.0))
    together = space(diagonal, beside)
    with pytest.raises(ValueError, match="'controller.K' must be positive definite"):
        together.rows(np.array([[0.0, 1.0]]))


def test_the_values_of_the_factors_are_their_quantiles():
    one = space(Factor("masses", ("plant.mass",), Uniform(0.5, 1.5), share=True))
    np.testing.assert_allclose(one.values(np.array([[0.25]])), [[0.75]])


def test_a_number_on_a_card_becomes_a_factor_with_its_range_and_mark():
    factor = assumed_entry("phi", 0.1, "rad/s", "not stated", 0.01, 1.0).factor(("controller.phi",), log_scale=True)
    assert (factor.name, factor.origin, factor.distribution) == ("phi", "assumed", LogUniform(0.01, 1.0))
    with pytest.raises(ValueError, match="needs a range to vary 'phi', which is stated"):
        stated_entry("phi", 0.1, "rad/s", "section 5").factor(("controller.phi",))


def test_a_table_says_what_each_factor_moves_how_far_and_by_whose_word():
    drawn = space(
        Factor("m", ("plant.mass[0]", "plant.mass[1]"), Uniform(0.5, 4.0), "derived"),
        Factor("K", ("controller.K",), LogUniform(0.5, 2.0), share=True),
        Factor("q", ("plant.q[0]",), Normal(0.5, 0.1, 0.0)),
        Factor("o", ("controller.offset", "controller.phi"), LogNormal(0.1, 0.2, high=1.0), "stated"),
    )
    table = factor_table(drawn, "factors", "What is varied.")
    assert table.rows == (
        ("m", "plant.mass[0], plant.mass[1]", "uniform, 0.5 to 4", "kg", "derived"),
        ("K", "controller.K", "share of the value: log-uniform, 0.5 to 2", None, "assumed"),
        ("q", "plant.q[0]", "normal, mean 0.5, deviation 0.1, from 0 on", "rad", "assumed"),
        ("o", "controller.offset, controller.phi", "lognormal, median 0.1, sigma 0.2, up to 1", "rad, rad/s", "stated"),
    )


def test_a_path_that_is_not_there_is_answered_with_the_nearest():
    with pytest.raises(LookupError, match=r"no 'plant.mas', which 'm' varies.*Did you mean 'plant.mass'\?"):
        space(Factor("m", ("plant.mas",), Uniform(1.0, 2.0)))
    with pytest.raises(LookupError, match=r"Did you mean 'plant.mass\[1\]'\?"):
        space(Factor("m", ("plant.mass[2]",), Uniform(1.0, 2.0)))


@pytest.mark.parametrize(
    ("factors", "said"),
    [
        (
            [Factor("m", ("plant.mass",), Uniform(0.0, 1.0))],
            r"'m' goes from 0 to 1, too far: 'plant.mass\[0\]' must be",
        ),
        ([Factor("m", ("plant.mass[1]",), Normal(1.0, 0.5))], "'m' goes from -2.06.* to 4.06.*, too far"),
        ([Factor("p", ("controller.phi",), Uniform(5.0, 20.0), share=True)], "from 5 to 20 of its own value, too far"),
        ([Factor("o", ("controller.offset",), Uniform(0.5, 2.0), share=True)], "any share of zero is zero"),
        ([Factor("K", ("controller.K",), Uniform(1.0, 2.0))], r"all 4 numbers of the matrix 'controller.K' one value"),
        ([Factor("a", ("plant.q",), Uniform(1.0, 2.0))] * 2, "each of another name"),
        (
            [Factor("a", ("plant.q",), Uniform(1.0, 2.0)), Factor("b", ("plant.q[1]",), Uniform(1.0, 2.0))],
            r"'a' and 'b' both move 'plant.q\[1\]'",
        ),
    ],
)
def test_factors_that_cannot_be_are_refused_in_a_sentence(factors, said):
    with pytest.raises(ValueError, match=said):
        space(*factors)


def test_a_bell_far_from_a_bound_needs_no_cut():
    positive = [Factor("a", ("plant.mass[0]",), Normal(2.0, 0.1)), Factor("b", ("plant.mass[1]",), LogNormal(1.0, 1.0))]
    p, _ = space(*positive).rows(np.array([[2.0**-31] * 2, [1 - 2.0**-31] * 2]))
    assert (p[:, :2] > 0).all()


def test_a_bell_without_a_cut_is_refused_where_a_design_goes_to_its_ends():
    with pytest.raises(ValueError, match="'a' has none: cut it off by `low` and `high`"):
        space(Factor("a", ("plant.q",), Normal(0.0, 1.0))).rows(np.array([[1.0]]))


@pytest.mark.parametrize("points", [[[0.5, 0.5]], [0.5], [[1.5]], [[np.nan]]])
def test_only_points_of_the_unit_cube_become_rows(points):
    with pytest.raises(ValueError, match="takes points .* of the unit cube"):
        space(Factor("a", ("plant.q",), Uniform(0.0, 1.0))).rows(np.array(points))


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Factor("", ("a",), Uniform(0.0, 1.0)), "needs a name"),
        (lambda: Factor("a", (), Uniform(0.0, 1.0)), "at least one path"),
        (lambda: Factor("a", ("b", "b"), Uniform(0.0, 1.0)), "each once"),
        (lambda: Factor("a", "b", Uniform(0.0, 1.0)), r"a tuple of `str`; got 'b': one alone is written `\(...,\)`"),
        (lambda: Factor("a", ("b",), Uniform(0.0, 1.0), "guessed"), "one of 'stated', .*got 'guessed'"),
    ],
)
def test_what_is_no_factor_is_refused_in_a_sentence(make, said):
    with pytest.raises(ValueError, match=said):
        make()

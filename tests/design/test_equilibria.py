"""Rest points: found, certified, and proved to be all."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from tests.support.equations import decay
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.blocks.loop import open_loop
from workbench.core import Entry, Layout, Ode
from workbench.design.linear import equilibria

BOX = {"q": (-1.0, 4.0), "qd": (-1.0, 1.0)}


def arm():
    return open_loop(Manipulator(paper_arm(), q=[0.4, -0.3]))


def of(rates, name="made"):
    """x' = rates(x) for a function of the vector x."""
    x = ca.SX.sym("x", rates(ca.SX.sym("x", 9)).numel())
    states = Layout((Entry("x", np.zeros(x.numel())),))
    symbols = states.symbols()
    return Ode.of(name, states, Layout(), (ca.SX.sym("t"), symbols, ca.SX(0, 1)), {"x": rates(symbols)}, {})


def test_the_arm_rests_hanging_folded_and_upright_and_nowhere_else():
    found = equilibria(arm(), BOX)
    angles = sorted(tuple(np.round(point.x[:2] / np.pi, 12) + 0.0) for point in found.points)
    assert angles == [(0, 0), (0, 1), (1, 0), (1, 1)]
    assert found.complete
    assert "4 rest points in the box, and no other: proved by intervals" in str(found)


def test_each_point_is_as_near_to_the_true_one_as_its_radius_says():
    for point in equilibria(arm(), BOX).points:
        assert point.radius is not None
        # pi itself is known no better than its double, 1.2e-16 away
        assert np.abs(point.x[:2] - np.pi * np.round(point.x[:2] / np.pi)).max() <= point.radius + 1.3e-16
        assert np.abs(point.x[2:]).max() <= point.radius < 1e-14


def test_the_hanging_arm_swings_with_the_frequencies_of_its_pencil():
    hanging = equilibria(arm(), BOX).points[0]
    M, K = np.array([[5.0, 2.0], [2.0, 1.0]]), 9.81 * np.array([[3.0, 1.0], [1.0, 1.0]])
    squares = np.linalg.eigvals(np.linalg.solve(M, K))
    np.testing.assert_allclose(sorted(np.abs(hanging.poles)), sorted(np.repeat(np.sqrt(squares), 2)), rtol=1e-12)
    np.testing.assert_allclose(hanging.poles.real, 0, atol=1e-12)


@pytest.mark.heavy
def test_a_torque_above_all_gravity_leaves_no_rest_point_and_that_is_proved():
    found = equilibria(arm(), BOX, u=[40.0, 0.0], starts=4)  # gravity holds at most 29.4 N m at joint 1
    assert (found.points, found.complete) == ((), True)
    assert str(found).startswith("no rest point in the box, and no other: proved")


def test_a_box_whose_speeds_exclude_zero_holds_no_rest_point():
    found = equilibria(arm(), {"q": (-1, 1), "qd": (0.5, 1)}, starts=4)
    assert (found.points, found.complete) == ((), True)


def test_all_six_rest_points_of_a_polynomial_field_are_found_and_proved():
    field = of(lambda x: ca.vertcat(x[0] * (x[0] - 1) * (x[0] + 2), (x[1] - 0.5) * (x[1] + 1.5)))
    found = equilibria(field, {"x": (-3, 3)})
    roots = sorted((a, b) for a in (-2.0, 0.0, 1.0) for b in (-1.5, 0.5))
    np.testing.assert_allclose([point.x for point in found.points], roots, atol=1e-14)
    assert found.complete
    for (a, b), point in zip(roots, found.points, strict=True):
        np.testing.assert_allclose(sorted(point.poles.real), sorted((3 * a * a + 2 * a - 2, 2 * b + 1)), atol=1e-12)


@pytest.mark.heavy
def test_a_double_root_is_found_and_called_neither_isolated_nor_proved():
    found = equilibria(of(lambda x: x[0] ** 2), {"x": (-1, 1)}, boxes=2000)
    assert found.points
    assert all(not point.is_isolated and point.radius is None for point in found.points)
    assert not found.complete
    assert "that there is no other is not proved" in str(found)


def test_what_lies_outside_of_the_box_is_left_out():
    found = equilibria(of(lambda x: (x[0] - 5) * (x[0] - 0.5)), {"x": (0, 1)})
    assert [round(point.x.item(), 12) for point in found.points] == [0.5]


def test_a_rate_that_jumps_gets_no_proof_of_existence():
    relay = of(lambda x: 0.5 - x[0] + 0 * ca.sign(x[0]) + ca.sign(x[0] - 3))
    found = equilibria(relay, {"x": (-2, 2)})
    (point,) = found.points
    assert point.x.item() == pytest.approx(-0.5, abs=1e-14)
    assert point.radius is None


@pytest.mark.heavy
def test_the_same_seed_gives_the_same_answer():
    first, again = (equilibria(arm(), BOX, seed=3, boxes=0) for _ in range(2))
    np.testing.assert_array_equal([p.x for p in first.points], [p.x for p in again.points])
    assert not first.complete


@pytest.mark.parametrize(
    ("box", "options", "message"),
    [
        ({"q": (-1, 1)}, {}, r"must bound every state.*'qd\[0\]' has no bounds"),
        ({"q": (1, -1), "qd": (-1, 1)}, {}, r"'q' must be \(low, high\), low < high"),
        ({"q": 3, "qd": (-1, 1)}, {}, r"must be a mapping .*; got 3 at"),
        ({"q": (-np.inf, 1), "qd": (-1, 1)}, {}, "finite; got"),
        (BOX, {"starts": 0}, r"`equilibria\(starts=...\)` must be a whole number from 1 to 100000; got 0"),
        (BOX, {"u": [1.0]}, "`u` must be 2 finite numbers"),
    ],
)
def test_what_is_no_box_is_refused(box, options, message):
    with pytest.raises(ValueError, match=message):
        equilibria(arm(), box, **options)


def test_a_name_that_is_no_states_is_refused():
    with pytest.raises(LookupError, match="no 'qdd'"):
        equilibria(arm(), BOX | {"qdd": (0, 1)})


def test_a_rate_that_depends_on_time_has_no_rest_point():
    ode = decay()
    with pytest.raises(ValueError, match="does not depend on time"):
        equilibria(replace(ode, rate=ode.rate + ode.t), {"x": (-1, 1)})


def test_a_rate_that_is_small_but_never_zero_has_no_rest_point():
    found = equilibria(of(lambda x: 1e-10 + 0 * x[0]), {"x": (-2.0, 2.0)})
    assert found.complete
    assert not found.points


def test_starts_where_the_rate_is_not_defined_are_left_out():
    (point,) = equilibria(of(lambda x: ca.sqrt(x[0]) - 1), {"x": (-2.0, 2.0)}).points
    assert point.x == pytest.approx([1.0])

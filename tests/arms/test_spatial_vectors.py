"""Turns, cross products and spatial transforms as matrices."""

import casadi as ca
import numpy as np
import pytest

from workbench.arms.mechanics import spatial_vectors


def numbers(expression) -> np.ndarray:
    return np.array(ca.evalf(ca.densify(expression)))


def test_skew_is_the_cross_product():
    v, w = np.array([0.3, -2.0, 1.5]), np.array([-1.0, 0.7, 0.2])
    np.testing.assert_array_equal(numbers(spatial_vectors.skew(ca.SX(v))) @ w, np.cross(v, w))


@pytest.mark.parametrize(("axis", "start", "end"), [(0, 1, 2), (1, 2, 0), (2, 0, 1)])
def test_a_quarter_turn_is_counter_clockwise_about_its_axis(axis, start, end):
    R = numbers(spatial_vectors.turn(np.eye(3)[axis], ca.SX(np.pi / 2)))
    np.testing.assert_allclose(R @ np.eye(3)[start], np.eye(3)[end], atol=1e-16)
    roll_pitch_yaw = spatial_vectors.from_angles(*(np.pi / 2 * np.eye(3)[axis]))
    np.testing.assert_allclose(roll_pitch_yaw, R, atol=1e-16)


def test_a_turn_about_any_axis_keeps_the_axis_and_all_lengths():
    axis = np.array([2.0, -1.0, 2.0]) / 3
    R = numbers(spatial_vectors.turn(axis, ca.SX(0.7)))
    np.testing.assert_allclose(R @ axis, axis, atol=1e-15)
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-15)
    assert np.trace(R) == pytest.approx(1 + 2 * np.cos(0.7), rel=1e-15)


def test_a_turn_about_a_coordinate_axis_costs_one_sine_and_one_cosine():
    angle = ca.SX.sym("q")
    R = spatial_vectors.turn(np.array([0.0, 0.0, 1.0]), angle)
    assert R.nnz() == 5
    assert float(R[2, 2]) == 1.0


def test_roll_pitch_and_yaw_are_about_the_fixed_axes_one_after_the_other():
    roll, pitch, yaw = ((0.3, 0, 0), (0, -0.5, 0), (0, 0, 1.1))
    one_by_one = (
        spatial_vectors.from_angles(*yaw) @ spatial_vectors.from_angles(*pitch) @ spatial_vectors.from_angles(*roll)
    )
    np.testing.assert_allclose(spatial_vectors.from_angles(0.3, -0.5, 1.1), one_by_one, rtol=0, atol=1e-16)


def test_a_transform_gives_the_velocity_of_the_point_it_is_moved_to():
    R, p = spatial_vectors.from_angles(0.4, -1.0, 2.0), np.array([0.3, -0.2, 0.9])
    omega, v = np.array([1.0, -2.0, 0.5]), np.array([0.1, 0.2, -0.3])
    moved = numbers(spatial_vectors.transform(ca.SX(R), ca.SX(p)) @ np.concatenate([omega, v])).ravel()
    np.testing.assert_allclose(moved, np.concatenate([R.T @ omega, R.T @ (v + np.cross(omega, p))]), atol=1e-15)


def test_the_cross_product_of_motions_and_its_swapped_one_are_those_of_their_parts():
    rng = np.random.default_rng(1)
    (a, b), (c, d), (n, f) = rng.normal(size=(3, 2, 3))
    v, w, force = np.concatenate([a, b]), np.concatenate([c, d]), np.concatenate([n, f])
    of_motions = numbers(spatial_vectors.cross(ca.SX(v))) @ w
    np.testing.assert_allclose(
        of_motions, np.concatenate([np.cross(a, c), np.cross(a, d) + np.cross(b, c)]), atol=1e-15
    )
    of_forces = -numbers(spatial_vectors.cross(ca.SX(v))).T @ force
    np.testing.assert_allclose(of_forces, np.concatenate([np.cross(a, n) + np.cross(b, f), np.cross(a, f)]), atol=1e-15)
    np.testing.assert_allclose(numbers(spatial_vectors.swapped_cross(ca.SX(force))) @ v, of_forces, atol=1e-15)

"""Planar arms: what they may be, and their energies."""

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.arms import moving_arms
from workbench.arms.dynamics import Dynamics
from workbench.arms.mechanics import Link, PlanarArm
from workbench.arms.mechanics.planar_arm import PointMass, turns, waves


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: Link(0.0, 1.0, 0.5), r"`Link\(mass=...\)` must be finite, with 0 < value \[kg\]; got 0"),
        (lambda: Link(1.0, -1.0, 0.5), r"`Link\(length=...\)`"),
        (lambda: Link(1.0, 1.0, 0.5, 0.0, -0.1), r"`Link\(inertia=...\)`"),
        (lambda: Link(1.0, 1.0, np.nan), r"`Link\(com=...\)` must be finite \[m\]; got nan"),
        (lambda: Link("heavy", 1.0, 0.5), "must be a number"),
        (lambda: PlanarArm(()), "at least one `Link` or `PointMass`"),
        (lambda: PlanarArm([]), "at least one `Link` or `PointMass`"),
        (lambda: PlanarArm((PointMass(1.0, 1.0),), gravity=-9.81), r"0 <= value \[m/s\^2\]"),
        (lambda: PlanarArm((PointMass(1.0, 1.0),), zero="north"), "one of 'down', 'right', 'up'"),
    ],
)
def test_an_arm_that_cannot_be_is_refused(make, says):
    with pytest.raises(ValueError, match=says):
        make()


def test_a_point_mass_is_a_link_with_all_its_mass_at_the_end():
    point = Dynamics.of(PlanarArm((PointMass(1.5, 0.7), PointMass(0.8, 0.9))))
    link = Dynamics.of(PlanarArm((Link(1.5, 0.7, 0.7), Link(0.8, 0.9, 0.9))))
    q, qd = np.array([0.4, -1.1]), np.array([2.0, -3.0])
    for ours, theirs in zip(point.matrices(q, qd), link.matrices(q, qd), strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-14, atol=1e-14)  # the same sums in another order


def test_an_arm_without_gravity_has_no_gravity_vector():
    assert ca.evalf(PlanarArm((Link(1.0, 1.0, 0.5),), gravity=0.0).gravity_vector(ca.SX([0.3]))).is_zero()


def test_the_zero_of_the_first_angle_turns_the_gravity_vector_only():
    links = (Link(1.5, 0.7, 0.3, 0.1, 0.05), Link(0.8, 0.9, 0.5, -0.1, 0.02))
    down, right, up = (Dynamics.of(PlanarArm(links, 9.81, zero)) for zero in ("down", "right", "up"))
    q, qd = np.array([0.4, -1.1]), np.array([2.0, -3.0])
    turned = {right: np.pi / 2, up: np.pi}
    for other, angle in turned.items():
        M, C, G = other.matrices(q, qd)
        same = down.matrices(q + [angle, 0], qd)
        for ours, theirs in zip((M, C, G), same, strict=True):
            np.testing.assert_allclose(ours, theirs, atol=1e-14 * 30)  # pi is rounded; terms up to 30


@pytest.mark.parametrize(("zero", "com"), [("down", (0.2, -0.5)), ("right", (0.5, 0.2)), ("up", (-0.2, 0.5))])
def test_a_straight_arm_points_where_its_zero_says_and_the_offset_lies_to_the_left(zero, com):
    arm = PlanarArm((Link(1.0, 1.0, 0.5, 0.2, 0.0), PointMass(1.0, 1.0)), zero=zero)
    first, second = arm.centres_of_mass(ca.SX([0, 0]))
    np.testing.assert_array_equal(numbers(first).ravel(), com)
    np.testing.assert_array_equal(
        numbers(second).ravel(), np.multiply(2, {"down": (0, -1), "right": (1, 0), "up": (0, 1)}[zero])
    )


def test_angles_are_counted_counter_clockwise_from_the_link_before():
    tip = numbers(PlanarArm((PointMass(1.0, 1.0),) * 2).centres_of_mass(ca.SX([np.pi / 2, np.pi / 2]))[1]).ravel()
    np.testing.assert_allclose(tip, [1, 1], atol=1e-15)  # out to the right, then up


def numbers(expression) -> np.ndarray:
    return np.array(ca.evalf(ca.densify(expression)))


@settings(max_examples=15)
@given(moving_arms())
def test_the_kinetic_energy_is_that_of_the_bodies_velocities(drawn):
    arm, q, qd = drawn
    angle = ca.SX.sym("q", arm.dof)
    energy = 0.0
    for k, link in enumerate(arm.links):
        com = arm.centres_of_mass(angle)[k]
        v = numbers(ca.substitute(ca.jacobian(com, angle), angle, ca.SX(q))) @ qd
        energy += link.mass * v @ v / 2 + link.inertia * qd[: k + 1].sum() ** 2 / 2
    # two roads to one sum of squares: no more than a hundred roundings of the largest term
    assert float(arm.kinetic_energy(ca.SX(q), ca.SX(qd))) == pytest.approx(energy, rel=1e-12, abs=1e-12)


@given(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6))
def test_an_arm_that_has_turned_many_times_is_as_exact_as_one_that_has_not(a, b):
    rounded = a + b
    part = rounded - a
    lost = (a - (rounded - part)) + (b - part)  # what the sum of two doubles drops, exactly (Knuth)
    c, s = (float(number) for number in turns(waves(ca.SX([a, b])))[-1])
    # lost is below 1e-10, so the next term of the series is below rounding; a few roundings are left
    np.testing.assert_allclose(c, np.cos(rounded) - lost * np.sin(rounded), rtol=0, atol=1e-15)
    np.testing.assert_allclose(s, np.sin(rounded) + lost * np.cos(rounded), rtol=0, atol=1e-15)

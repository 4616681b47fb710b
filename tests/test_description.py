"""What an arm may be."""

import casadi as ca
import numpy as np
import pytest

from workbench.core import Dynamics
from workbench.robots import Link, PlanarArm
from workbench.robots.description import PointMass


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
        (lambda: PlanarArm(3), "must be a tuple"),
        (lambda: PlanarArm((1.0, 2.0)), "must be a tuple"),
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

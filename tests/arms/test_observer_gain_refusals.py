"""What the analysis of observer gains refuses: gains, regions, paths, arms and states that are none."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from workbench.arms.dynamics import Dynamics
from workbench.arms.mechanics import paper_arm
from workbench.arms.mechanics.planar_arm import PlanarArm, PointMass
from workbench.arms.observer_gains import (
    Gains,
    Mismatch,
    Region,
    audit,
    by_poles,
    frozen_poles_along,
    frozen_poles_over,
)

I, ZERO = np.eye(2), np.zeros((1, 2))
PAPER = Gains(30 * I, 50 * I)
BOX = Region([5.0, 5.0], [30.0, 30.0])
DYNAMICS = Dynamics.of(paper_arm())
MISMATCH = Mismatch.of(DYNAMICS)


@pytest.mark.parametrize(
    ("L1", "L2", "words"),
    [
        (-30 * I, 50 * I, "sign"),
        (30 * I, -50 * I, "sign"),
        (np.ones((2, 3)), 50 * I, "square"),
        (30 * I, 50 * np.eye(3), "one size"),
        (30 * I, np.diag([50.0, np.nan]), r"\[1, 1\] is nan"),
        ("many", 50 * I, "must be numbers, in an array"),
    ],
)
def test_gains_that_are_none_are_refused(L1, L2, words):
    with pytest.raises(ValueError, match=words):
        Gains(L1, L2)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"speed": [-1.0, 1.0], "torque": [1.0, 1.0]}, "negative"),
        ({"speed": [1.0, 1.0], "torque": [1.0]}, "one finite number a joint"),
        ({"speed": [1.0, np.nan], "torque": [1.0, 1.0]}, "finite"),
        ({"speed": [1.0], "torque": [1.0], "low": [1.0], "high": [0.0]}, "low < high"),
        ({"speed": [1.0], "torque": [1.0], "low": [1.0]}, "both sides"),
    ],
)
def test_a_region_that_is_none_is_refused(given, words):
    with pytest.raises(ValueError, match=words):
        Region(**given)


def test_a_path_that_leaves_the_region_is_refused_with_its_row():
    q, qd, tau = np.zeros((4, 2)), np.zeros((4, 2)), np.zeros((4, 2))
    assert frozen_poles_along(MISMATCH, PAPER, BOX, q, qd, tau).unstable == 0
    qd[2, 1] = 6.0
    with pytest.raises(ValueError, match="row 2 leaves it"):
        frozen_poles_along(MISMATCH, PAPER, BOX, q, qd, tau)
    qd[2, 1] = np.nan
    with pytest.raises(ValueError, match="finite"):
        frozen_poles_along(MISMATCH, PAPER, BOX, q, qd, tau)


def test_gains_of_another_arm_are_refused():
    with pytest.raises(ValueError, match="2 joints"):
        frozen_poles_over(MISMATCH, by_poles(3, -1, -1), BOX)


@pytest.mark.parametrize(("inner", "rate", "words"), [(1.0, 0.1, "share"), (0.0, 0.1, "positive"), (0.8, -1.0, "rate")])
def test_an_audit_of_a_share_or_rate_that_is_none_is_refused(inner, rate, words):
    with pytest.raises(ValueError, match=words):
        audit(DYNAMICS, PAPER, BOX, inner, rate)


def test_arms_whose_acceleration_is_not_quadratic_in_the_velocities_are_refused():
    smooth = Dynamics.of(paper_arm())
    drag = replace(smooth, recursion=(smooth.qdd, smooth.tau + 0.1 * smooth.qd**3))
    with pytest.raises(ValueError, match="quadratic in the velocities"):
        Mismatch.of(drag)


def test_arms_with_a_relay_of_friction_are_refused():
    smooth = Dynamics.of(paper_arm())
    rough = replace(smooth, recursion=(smooth.qdd, smooth.tau + ca.sign(smooth.qd)))
    with pytest.raises(ValueError, match="SIGN"):
        Mismatch.of(rough)


class Bent(PlanarArm):
    """A pendulum whose force bends where a state passes zero: |qd| qd of air, or |q| of a spring."""

    def coriolis_matrix(self, q, qd):
        return -50 * ca.fabs(qd) if self.zero == "down" else ca.SX(1, 1)

    def gravity_vector(self, q):
        return -50 * ca.fabs(q) if self.zero == "up" else ca.SX(1, 1)


@pytest.mark.parametrize("zero", ["down", "up"])
def test_an_acceleration_that_bends_is_refused_as_no_polynomial_bounds_its_jacobian(zero):
    with pytest.raises(ValueError, match="needs a smooth acceleration"):
        Mismatch.of(Dynamics.of(Bent((PointMass(1.0, 1.0),), 9.81, zero), symbolic=False))


def test_complex_numbers_are_refused_and_not_cut():
    with pytest.raises(ValueError, match="must be numbers, in an array"):
        Gains(np.array([[30 + 5j]]), [[50.0]])
    with pytest.raises(ValueError, match="must be numbers, in an array"):
        Region(np.array([1 + 1j]), [1.0])

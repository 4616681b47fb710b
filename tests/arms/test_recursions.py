"""The recursion of Newton and Euler against Lagrange's equation of the energies."""

import casadi as ca
import numpy as np
import pytest

from tests.support.arms import random_tree
from workbench.arms.mechanics import CATALOGUE, SpatialArm, SpatialLink, energies, recursions, robot

SPATIAL = [name for name in CATALOGUE if isinstance(robot(name), SpatialArm)]
ROUNDING = 1e-12  # a few hundred terms of a double each, relative to the largest


def states(arm, rng, count=20):
    return rng.uniform(-3, 3, (count, 3, arm.dof))


@pytest.mark.parametrize("joints", [1, 2, 3, 5, 8])
@pytest.mark.parametrize("seed", range(3))
def test_the_recursion_and_the_energies_give_one_torque(joints, seed):
    rng = np.random.default_rng([joints, seed])
    arm = random_tree(joints, rng)
    assert energies.difference(energies.torque_functions(arm), states(arm, rng)).max() < ROUNDING


@pytest.mark.parametrize("name", SPATIAL)
def test_both_roads_agree_for_the_arms_of_the_catalogue(name):
    arm = robot(name)
    assert energies.difference(energies.torque_functions(arm), states(arm, np.random.default_rng(5))).max() < ROUNDING


def test_both_energies_are_one():
    rng = np.random.default_rng(3)
    arm = random_tree(5, rng)
    q, qd = (ca.SX.sym(letter, 5) for letter in ("q", "qd"))
    from_motions = recursions.kinetic_energy(arm.bodies(q), qd)
    from_poses = energies.kinetic_energy(arm.links, q, qd)
    both = ca.Function("T", [q, qd], [from_motions, from_poses])
    for state in states(arm, rng):
        ours, theirs = both(*state[:2])
        assert float(ours) == pytest.approx(float(theirs), rel=ROUNDING)


def test_an_arm_whose_roads_differ_is_refused_when_it_is_made(monkeypatch):
    cross = recursions.cross
    monkeypatch.setattr(recursions, "cross", lambda v: cross(v) * 1.000001)  # a wrong Coriolis term
    with pytest.raises(ValueError, match=r"recursion and Lagrange's equation must give one torque; they differ by"):
        robot("scara")


def test_an_arm_whose_m_belongs_to_another_is_refused_when_it_is_made(monkeypatch):
    M = recursions.mass_matrix
    monkeypatch.setattr(recursions, "mass_matrix", lambda bodies: 1.000001 * M(bodies))
    with pytest.raises(ValueError, match=r"must give one torque; they differ by"):
        robot("scara")


def test_a_joint_that_moves_no_mass_is_refused_by_name():
    point = SpatialLink("spin", 1.0, (0.0, 0.0, 0.4), np.zeros(6))
    with pytest.raises(ValueError, match=r"M must be positive definite.*joint 'spin' moves least"):
        SpatialArm((point,))


def test_two_slides_along_one_line_are_refused():
    heavy = {"mass": 1.0, "com": np.zeros(3), "inertia": (1.0, 0, 0, 1.0, 0, 1.0), "joint": "prismatic"}
    light = {**heavy, "mass": 1e-16}
    with pytest.raises(ValueError, match="M must be positive definite"):
        SpatialArm((SpatialLink("near", **light), SpatialLink("far", parent=0, **heavy)))


def test_gravity_alone_is_the_torque_at_rest_and_motion_alone_needs_no_weight():
    arm = random_tree(4, np.random.default_rng(9))
    q, qd, none = ca.SX.sym("q", 4), ca.SX.sym("qd", 4), ca.SX.zeros(4)
    parts = arm.gravity_vector(q) + arm.coriolis_force(q, qd)
    gap = ca.Function("gap", [q, qd], [arm.torque(q, qd, none) - parts, parts])
    for state in states(arm, np.random.default_rng(1)):
        difference, size = gap(*state[:2])
        assert np.abs(np.array(difference)).max() < ROUNDING * np.abs(np.array(size)).max()

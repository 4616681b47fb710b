"""Bodies and joints by name, put together to an arm."""

import numpy as np
import pytest

from workbench.arms.dynamics import Dynamics
from workbench.arms.mechanics.joint_tree import Joint, Solid, arm_of
from workbench.arms.mechanics.spatial_vectors import Lump, merge_lumps

BALL = np.array([0.1, 0.0, 0.0, 0.1, 0.0, 0.1])


def solid(name, mass=1.0, inertia=BALL):
    return Solid(name, mass, np.array([0.1, 0.2, 0.3]), inertia)


def test_a_body_in_two_halves_is_the_body():
    rng = np.random.default_rng(1)
    points, masses = rng.normal(size=(20, 3)), rng.uniform(0.1, 1.0, 20)

    def lump(chosen):
        m, r = masses[chosen], points[chosen]
        com = m @ r / m.sum()
        d = r - com
        return Lump(m.sum(), com, np.einsum("i,ij,ij", m, d, d) * np.eye(3) - np.einsum("i,ij,ik->jk", m, d, d))

    whole, halves = lump(slice(None)), merge_lumps([lump(slice(0, 7)), lump(slice(7, None))])
    for ours, theirs in zip(halves, whole, strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-13, atol=1e-13)


def test_a_fixed_joint_in_between_changes_no_equation():
    seat = {"position": np.array([0.1, 0.0, 0.2]), "rotation": np.eye(3)}
    direct = arm_of([Solid("base"), solid("arm")], [Joint("turn", "base", "arm", "revolute", **seat)])
    parts = [Solid("base"), Solid("flange"), solid("arm")]
    joints = [Joint("turn", "flange", "arm", "revolute"), Joint("bolt", "base", "flange", "fixed", **seat)]
    right, found = (Dynamics.of(arm).matrices([0.3], [1.0]) for arm in (direct, arm_of(parts, joints)))
    for ours, theirs in zip(found, right, strict=True):
        np.testing.assert_array_equal(ours, theirs)


@pytest.mark.parametrize(
    ("body", "says"),
    [
        (solid("arm", mass=-1.0), "mass of link 'arm' must be finite and not negative; got -1 kg"),
        (solid("arm", mass=np.nan), "got nan kg"),
        (solid("arm", inertia=BALL * np.nan), "inertia of link 'arm' must be finite"),
        (solid("arm", mass=0.0), "belongs to no mass"),
        (solid("arm", inertia=np.array([0.1, 0.0, 0.0, 0.1, 0.0, 0.3])), "belongs to no body"),
    ],
)
def test_a_body_that_cannot_be_is_refused_even_where_it_does_not_move(body, says):
    joints = [Joint("turn", "base", "moved", "revolute"), Joint("bolt", "base", "arm", "fixed")]
    with pytest.raises(ValueError, match=says):
        arm_of([Solid("base"), solid("moved"), body], joints)


ABOUT_X, ABOUT_Y = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])


def test_the_cross_of_a_universal_joint_needs_no_mass():
    joints = [
        Joint("roll", "base", "cross", "revolute", axis=ABOUT_X),
        Joint("pitch", "cross", "arm", "revolute", axis=ABOUT_Y),
    ]
    arm = Dynamics.of(arm_of([Solid("base"), Solid("cross"), solid("arm")], joints))
    # The limit of crosses that weigh ever less; what 1e-9 kg add is that times 0.03 m^2 or g 0.1 m.
    light = Solid("cross", 1e-9, np.array([0.1, 0.1, 0.1]))
    near = Dynamics.of(arm_of([Solid("base"), light, solid("arm")], joints))
    state = ([0.3, -0.7], [1.0, 2.0])
    for ours, theirs in zip(arm.matrices(*state), near.matrices(*state), strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-8)


@pytest.mark.parametrize(
    ("second", "says"),
    [
        (Joint("again", "cross", "arm", "revolute", axis=ABOUT_X), "there is a motion that moves none"),
        (Joint("bolt", "base", "arm", "fixed"), "'cross' is moved by joint 'turn' and has no mass"),
    ],
)
def test_a_massless_body_is_refused_where_m_would_be_singular(second, says):
    joints = [Joint("turn", "base", "cross", "revolute", axis=ABOUT_X), second]
    with pytest.raises(ValueError, match=says):
        arm_of([Solid("base"), Solid("cross"), solid("arm")], joints)


def test_a_massless_body_may_be_moved_by_a_drive_that_has_inertia():
    drive = Joint("turn", "base", "disc", "revolute", rotor=0.1, gear=2.0)
    M, _, _ = Dynamics.of(arm_of([Solid("base"), Solid("disc")], [drive])).matrices([0.3], [1.0])
    np.testing.assert_allclose(M, 0.4, rtol=1e-15)


def test_drives_and_friction_come_through():
    drive = {"viscous": 0.1, "coulomb": 0.2, "rotor": 1e-4, "gear": 50.0}
    (link,) = arm_of([Solid("base"), solid("arm")], [Joint("turn", "base", "arm", "continuous", **drive)]).links
    assert {name: getattr(link, name) for name in drive} == drive
    assert link.joint == "continuous"

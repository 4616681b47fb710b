"""Spatial arms: what they may be, and that their matrices have the structure that the mechanics promises."""

import casadi as ca
import numpy as np
import pytest

from tests.support.arms import random_arm, random_tree
from workbench.arms.dynamics import Dynamics
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import SpatialArm, SpatialLink, lagrange, robot
from workbench.arms.mechanics.planar_arm import DIRECTIONS
from workbench.blocks.loop import open_loop
from workbench.core import lift, rk4
from workbench.engine import simulate

ROUNDING = 1e-12  # a few hundred terms of a double each, relative to the largest
BODY = {"mass": 1.0, "com": (0.1, 0.0, 0.0), "inertia": (0.1, 0.0, 0.0, 0.1, 0.0, 0.1)}


def link(**changes) -> SpatialLink:
    return SpatialLink(**{"name": "elbow", **BODY, **changes})


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"mass": -1.0}, r"`SpatialLink\(mass=...\)` must be finite, with 0 <= value \[kg\]; got -1"),
        ({"mass": 0.0}, "inertia of link 'elbow' belongs to no mass"),
        ({"com": (0.0, 0.0)}, r"`SpatialLink\(com=...\)` must be an array of shape \(3\); got shape \(2,\)"),
        ({"com": (0.0, np.nan, 0.0)}, r"`SpatialLink\(com=...\)` must be finite"),
        ({"inertia": np.eye(3)}, r"`SpatialLink\(inertia=...\)` must be an array of shape \(6\); got shape \(3, 3\)"),
        ({"inertia": (-1, 0, 0, 1, 0, 1)}, r"link 'elbow' must be positive definite.*-1, 1 and 1 kg m\^2"),
        ({"inertia": (1, 0, 0, 1, 0, 2.1)}, r"link 'elbow' belongs to no body: .*2.1 kg m\^2.* 1 \+ 1"),
        ({"inertia": (1, 5, 0, 1, 0, 1)}, "must be positive definite"),
        ({"axis": (0, 0, 2)}, r"'elbow', axis=.*must be a unit vector.*got length 2"),
        ({"axis": (0, 0, 0)}, r"'elbow', axis=.*must be a unit vector.*got length 0"),
        ({"axis": "z"}, r"`SpatialLink\('elbow', axis=...\)` must be a vector of numbers"),
        ({"rotation": np.diag([1, 1, -1])}, "orthonormal and right-handed.*det R -1"),
        ({"rotation": 2 * np.eye(3)}, "orthonormal and right-handed.*3 off the identity"),
        ({"joint": "ball"}, "one of 'revolute', 'continuous', 'prismatic'; got 'ball'"),
        ({"viscous": -1.0}, r"`SpatialLink\(viscous=...\)`"),
        ({"gear": 100.0}, r"`SpatialLink\('elbow', gear=...\)` has no effect without a `rotor`"),
    ],
)
def test_a_link_that_cannot_be_is_refused(change, says):
    with pytest.raises(ValueError, match=says):
        link(**change)


def test_the_limits_of_a_body_are_let_pass():
    for inertia in (np.zeros(6), (1, 0, 0, 1, 0, 0), (1, 0, 0, 1, 0, 2)):  # a point, a rod, a disc
        assert link(inertia=inertia).mass == 1.0


@pytest.mark.parametrize(
    ("links", "says"),
    [
        ((), "at least one `SpatialLink`; got none"),
        ((link(), link()), r"needs unique names; \['elbow'\] came more than once"),
        ((link(parent=0),), r"no loop; 'elbow' at \[0\] has parent 0"),
        ((link(), link(name="hand", parent=1)), r"'hand' at \[1\] has parent 1"),
        ((link(), link(name="hand", parent=-2)), r"'hand' at \[1\] has parent -2"),
    ],
)
def test_an_arm_that_cannot_be_is_refused(links, says):
    with pytest.raises(ValueError, match=says):
        SpatialArm(links)


def in_space(arm) -> SpatialArm:
    """A planar arm as a spatial one: the plane is x to the right, z upward; hinges turn from x to z, about -y."""
    right, up = DIRECTIONS[arm.zero]
    along, left = np.array([right, 0, up]), np.array([-up, 0, right])
    links, place = [], np.zeros(3)
    for i, body in enumerate(arm.links):
        com, I = body.com * along + body.offset * left, body.inertia
        moments = (I, 0, 0, I, 0, I)
        links.append(SpatialLink(f"j{i}", body.mass, com, moments, place, (0, -1, 0), parent=i - 1))
        place = body.length * along
    return SpatialArm(tuple(links), arm.gravity)


@pytest.mark.parametrize("seed", range(4))
def test_a_planar_arm_is_a_spatial_one_by_another_road(seed):
    rng = np.random.default_rng(seed)
    arm = random_arm(1 + seed, rng)
    planar, spatial = Dynamics.of(arm), Dynamics.of(in_space(arm))
    for _ in range(10):
        q, qd, tau = rng.uniform(-3, 3, (3, arm.dof))
        for ours, theirs in zip(spatial.matrices(q, qd), planar.matrices(q, qd), strict=True):
            np.testing.assert_allclose(ours, theirs, rtol=0, atol=ROUNDING * (1 + np.abs(theirs).max()))
        size = np.linalg.cond(planar.matrices(q, qd)[0])
        qdd = planar.acceleration(q, qd, tau)
        np.testing.assert_allclose(spatial.acceleration(q, qd, tau), qdd, atol=ROUNDING * size * np.abs(qdd).max())


@pytest.mark.parametrize("joints", [1, 3, 6])
def test_m_is_symmetric_and_definite_and_m_dot_minus_two_c_is_skew(joints):
    rng = np.random.default_rng(joints)
    d = Dynamics.of(random_tree(joints, rng))
    rate = ca.Function("rate", [d.q, d.qd, d.symbols], [d.mass_matrix_rate])
    for _ in range(10):
        q, qd = rng.uniform(-3, 3, (2, joints))
        M, C, _ = d.matrices(q, qd)
        np.testing.assert_array_equal(M, M.T)
        assert np.linalg.eigvalsh(M).min() > 0
        N = np.array(rate(q, qd, d.p.default)) - 2 * C
        assert np.abs(N + N.T).max() < ROUNDING * np.abs(M).max() * np.abs(qd).max()


def test_c_of_the_recursion_is_that_of_the_christoffel_symbols():
    rng = np.random.default_rng(11)
    arm = random_tree(5, rng)
    d = Dynamics.of(arm, symbolic=False)
    christoffel = lagrange.coriolis_matrix(arm.mass_matrix, d.q, d.qd)
    both = ca.Function("C", [d.q, d.qd], [d.C, christoffel, arm.coriolis_force(d.q, d.qd)])
    for _ in range(10):
        q, qd = rng.uniform(-3, 3, (2, 5))
        ours, theirs, force = map(np.array, both(q, qd))
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=ROUNDING * np.abs(theirs).max())
        np.testing.assert_allclose(ours @ qd, force.ravel(), rtol=0, atol=ROUNDING * np.abs(ours).max() * 3 * 5)


def test_the_five_derivatives_are_those_of_the_numbers():
    rng = np.random.default_rng(12)
    n = 4
    d = Dynamics.of(random_tree(n, rng, viscous=0.7, rotor=0.01, gear=10.0))
    q, qd, qdd, p, h = *rng.uniform(-1, 1, (3, n)), d.p.default, 1e-5
    tau = d.torque(q, qd, qdd)

    def differences(function, *state, by):
        columns = []
        for step in h * np.eye(n):
            ahead, back = ([x + sign * step if i == by else x for i, x in enumerate(state)] for sign in (1, -1))
            columns.append((function(*ahead) - function(*back)) / (2 * h))
        return np.array(columns).T

    _, by_q, by_qd = map(np.array, d.inverse_dynamics(q, qd, qdd, p))
    found, by_q2, by_qd2, by_tau = map(np.array, d.forward_dynamics(q, qd, tau, p))
    np.testing.assert_allclose(found.ravel(), qdd, atol=1e-11)  # the one undoes the other, M of condition below 1e3
    roads = [
        (by_q, differences(d.torque, q, qd, qdd, by=0)),
        (by_qd, differences(d.torque, q, qd, qdd, by=1)),
        (by_q2, differences(d.acceleration, q, qd, tau, by=0)),
        (by_qd2, differences(d.acceleration, q, qd, tau, by=1)),
        (by_tau, differences(d.acceleration, q, qd, tau, by=2)),
    ]
    for exact, difference in roads:
        # h^2 times a third derivative, 1e-10 of it, and rounding over h, 1e-11
        np.testing.assert_allclose(exact, difference, atol=1e-7 * np.abs(exact).max())


def test_forward_dynamics_solve_the_equation_of_motion_with_friction_and_drives():
    rng = np.random.default_rng(13)
    arm = random_tree(5, rng, viscous=0.3, coulomb=0.2, rotor=1e-3, gear=50.0)
    d = Dynamics.of(arm)
    for _ in range(10):
        q, qd, tau = rng.uniform(-2, 2, (3, 5))
        M, C, G = d.matrices(q, qd)
        friction = 0.3 * qd + 0.2 * np.sign(qd)
        qdd = d.acceleration(q, qd, tau)
        size = np.abs(M).max() * np.abs(qdd).max() + np.abs(C @ qd + G).max()
        np.testing.assert_allclose(M @ qdd + C @ qd + G + friction, tau, atol=1e-13 * 10 * size)
        by_block = np.array(ca.evalf(arm.acceleration(ca.SX(q), ca.SX(qd), ca.SX(tau)))).ravel()
        np.testing.assert_allclose(by_block, qdd, atol=ROUNDING * np.linalg.cond(M) * np.abs(qdd).max())


def test_a_rotor_stands_on_the_diagonal_of_m_with_the_square_of_its_gear():
    q, qd = np.zeros((2, 3))
    plain = Dynamics.of(random_tree(3, np.random.default_rng(1))).matrices(q, qd)
    driven = Dynamics.of(random_tree(3, np.random.default_rng(1), rotor=2e-4, gear=-100.0)).matrices(q, qd)
    np.testing.assert_allclose(driven[0] - plain[0], 2 * np.eye(3), atol=1e-14)
    np.testing.assert_array_equal(driven[1], plain[1])


def test_an_arm_without_friction_has_no_term_and_no_parameter_of_it():
    lifted = lift(robot("ur5"))
    assert not [name for name in lifted.layout.names if name.endswith(("viscous", "coulomb", "rotor", "gear"))]
    assert lifted.block.friction(ca.SX.sym("qd", 6)).nnz() == 0
    rough = lift(random_tree(2, np.random.default_rng(2), viscous=0.1))
    assert rough.layout["links[1].viscous"].default == 0.1


def test_parameters_move_the_matrices_and_the_shape_does_not_vary():
    arm = robot("panda")
    d = Dynamics.of(arm)
    heavy = d.p.pack({"links[6].mass": 3.0, "gravity": 0.0})[0]
    q, qd = np.full(7, 0.3), np.ones(7)
    (M, _, _), (M_heavy, _, G) = d.matrices(q, qd), d.matrices(q, qd, heavy)
    assert np.linalg.eigvalsh(M_heavy - M).min() > -1e-15  # more mass, more energy; a semidefinite part is rounded
    np.testing.assert_array_equal(G, 0)
    assert not [name for name in d.p.names if name.endswith(("axis", "rotation"))]
    numbers = Dynamics.of(arm, symbolic=False)
    assert numbers.p.size == 0
    np.testing.assert_allclose(numbers.matrices(q, qd)[0], M, rtol=0, atol=ROUNDING * np.abs(M).max())


def test_m_c_and_g_are_exact_after_many_turns():
    arm = robot("panda")
    d = Dynamics.of(arm, symbolic=False)
    q, qd = np.linspace(-1, 1, 7), np.linspace(2, -1, 7)
    far = q + 2 * np.pi * 10**6
    # the far angles are rounded, by 1e-9, and pi itself is: come back by exact sines and cosines
    near = np.arctan2(np.sin(far), np.cos(far))
    for ours, theirs in zip(d.matrices(far, qd), d.matrices(near, qd), strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-14 * np.abs(theirs).max())


def test_a_spatial_arm_swings_in_the_loop_without_gaining_energy():
    arm = robot("scara")
    plant = Manipulator(arm, q=[0.3, -0.4, 0.1, 0.2], qd=[1.0, -2.0, 0.0, 3.0])
    ode = open_loop(plant)
    run = simulate(rk4(ode, 1e-3), until=0.5, every=0.1)
    q, qd = ca.SX.sym("q", 4), ca.SX.sym("qd", 4)
    energy = ca.Function("E", [q, qd], [arm.kinetic_energy(q, qd) + arm.potential_energy(q)])
    energies = [float(energy(x[:4], x[4:])) for x in run.x[0]]
    # fourth order: (1e-3)^4 times a rate of energy of at most 1e3 over half a second
    np.testing.assert_allclose(energies, energies[0], rtol=0, atol=1e-8)

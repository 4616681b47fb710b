"""The matrices of one arm over symbols."""

import casadi as ca
import numpy as np
import pytest

from tests.support.arms import random_arm, random_tree
from workbench.arms.dynamics import Dynamics
from workbench.arms.mechanics import paper_arm, robot


def test_the_matrices_of_the_paper_arm_are_those_of_its_equations():
    q, qd = np.array([0.5, 1.0]), np.array([1.0, -1.0])
    M, C, G = Dynamics.of(paper_arm()).matrices(q, qd)
    c, s, g = np.cos(1.0), np.sin(1.0), 9.81
    # equations (2) to (4), C[1,2] repaired, with masses and lengths of 1; a few roundings apart
    np.testing.assert_allclose(M, [[3 + 2 * c, 1 + c], [1 + c, 1]], rtol=1e-15)
    np.testing.assert_allclose(C, [[s, -s * (1 - 1)], [s, 0]], rtol=1e-15)
    np.testing.assert_allclose(G, [2 * g * np.sin(0.5) + g * np.sin(1.5), g * np.sin(1.5)], rtol=1e-15)


def test_parameters_move_the_matrices():
    d = Dynamics.of(paper_arm())
    heavy = d.p.pack({"links[1].mass": 2.0, "gravity": 0.0})[0]
    M, _, G = d.matrices([0.0, 0.0], [0.0, 0.0], heavy)
    np.testing.assert_allclose(M, [[9, 4], [4, 2]], rtol=1e-15)
    np.testing.assert_array_equal(G, [0, 0])


def test_the_acceleration_solves_the_equation_of_motion_by_two_roads():
    rng = np.random.default_rng(3)
    for joints in (1, 2, 3, 4):
        arm = random_arm(joints, rng)
        d = Dynamics.of(arm)
        q, qd, tau = rng.uniform(-2, 2, (3, joints))
        by_solve = d.acceleration(q, qd, tau)
        by_factors = np.array(ca.evalf(arm.acceleration(ca.SX(q), ca.SX(qd), ca.SX(tau)))).ravel()
        M, C, G = d.matrices(q, qd)
        # backward stable both: residual of a few roundings of the largest torque
        size = np.abs(M).max() * np.abs(by_solve).max() + np.abs(C @ qd + G).max()
        np.testing.assert_allclose(M @ by_factors + C @ qd + G, tau, atol=1e-13 * size)
        np.testing.assert_allclose(M @ by_solve + C @ qd + G, tau, atol=1e-13 * size)


def test_the_rate_of_m_is_its_derivative_along_the_velocity():
    d = Dynamics.of(random_arm(3, np.random.default_rng(5)))
    rate = ca.Function("rate", [d.q, d.qd, d.symbols], [d.mass_matrix_rate])
    q, qd, h = np.array([0.3, -1.0, 0.6]), np.array([1.0, 2.0, -1.0]), 1e-5
    difference = (d.matrices(q + h * qd, qd)[0] - d.matrices(q - h * qd, qd)[0]) / (2 * h)
    # h^2 M''' / 6 is about 1e-9, eps M / h about 1e-10
    np.testing.assert_allclose(np.array(rate(q, qd, d.p.default)), difference, atol=1e-7)


def test_symbols_are_printed_with_the_letters_of_the_book():
    names = Dynamics.of(paper_arm()).names()
    assert names["q[0]"] == "q_1"
    assert names["links[1].length"] == "l_2"
    assert names["gravity"] == "g"


def test_the_dynamics_bear_the_name_of_their_arm():
    assert Dynamics.of(paper_arm()).name == "PlanarArm"
    assert Dynamics.of(paper_arm(), "paper arm").name == "paper arm"


def test_parameters_out_of_their_bounds_are_refused_by_name():
    d = Dynamics.of(paper_arm())
    with pytest.raises(ValueError, match=r"'links\[0\].mass' must be finite, with 0 < value \[kg\]; got -1"):
        d.p.pack({"links[0].mass": -1.0})


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"p": 2.0}, r"`Dynamics.acceleration\(p=...\)` must have shape \(5,\), one number for each of the parameters"),
        (
            {"q": 0.3},
            r"`Dynamics.acceleration\(q=...\)` must have shape \(2,\), one number for each of the joints; got \(\)",
        ),
        ({"q": np.ones((2, 3))}, r"got \(2, 3\)"),
        ({"qd": [1.0, 2.0, 3.0]}, r"`Dynamics.acceleration\(qd=...\)` must have shape"),
        ({"qd": None}, r"must be a vector of numbers; got None"),
        ({"tau": 1.0}, r"`Dynamics.acceleration\(tau=...\)` must have shape \(2,\)"),
    ],
)
def test_a_state_of_the_wrong_shape_is_refused_and_never_filled_up(change, says):
    dynamics = Dynamics.of(paper_arm())
    with pytest.raises(ValueError, match=says):
        dynamics.acceleration(**{"q": [0.1, 0.2], "qd": [0.0, 0.0], "tau": [1.0, 1.0], **change})


def test_torque_and_acceleration_undo_each_other():
    rng = np.random.default_rng(6)
    for arm in (random_arm(3, rng), random_tree(4, rng, viscous=0.2)):
        d = Dynamics.of(arm)
        q, qd, qdd = rng.uniform(-2, 2, (3, arm.dof))
        M, C, G = d.matrices(q, qd)
        tau = d.torque(q, qd, qdd)
        if arm.recursion(ca.SX(q), ca.SX(qd), ca.SX(qdd)) is None:
            np.testing.assert_allclose(tau, M @ qdd + C @ qd + G, rtol=0, atol=1e-13 * np.abs(tau).max())
        # solved with M, whose condition is below 1e4
        np.testing.assert_allclose(d.acceleration(q, qd, tau), qdd, rtol=0, atol=1e-11 * np.abs(qdd).max())


def test_the_equations_of_an_arm_of_seven_joints_share_their_terms():
    d = Dynamics.of(robot("panda"))
    assert [d.inverse_dynamics.n_out(), d.forward_dynamics.n_out()] == [3, 4]  # the derivatives with the values
    # by recursion some 13,000 and 17,000 steps; matrices written out per entry take hundreds of thousands
    assert d.inverse_dynamics.n_instructions() < 15_000
    assert d.forward_dynamics.n_instructions() < 20_000


def test_an_arm_of_numbers_has_no_parameters_and_the_same_matrices():
    arm = random_arm(3, np.random.default_rng(8))
    symbolic, plain = Dynamics.of(arm), Dynamics.of(arm, symbolic=False)
    assert plain.p.size == 0
    q, qd = np.array([0.3, -1.0, 0.6]), np.array([1.0, 2.0, -1.0])
    for ours, theirs in zip(plain.matrices(q, qd), symbolic.matrices(q, qd), strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-14 * (1 + np.abs(theirs).max()))  # other groupings

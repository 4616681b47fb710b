"""State feedback against a hand-written loop, and LQR by it: the cost it promises is the one it pays."""

import casadi as ca
import numpy as np
import pytest
from scipy.linalg import solve_continuous_are

from tests.support.oracles import closed_loop, integrate, matrices, worst_difference
from workbench.arms.laws import ArmStateFeedback
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import ArmFullState
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Constant, Sines, SineTorque
from workbench.core import rk4, with_quadrature
from workbench.engine import simulate

Kp, Kd = np.array([[60.0, 5.0], [2.0, 30.0]]), np.array([[15.0, 1.0], [3.0, 6.0]])


def loop(controller, q=(0.6, -0.8), reference=None, disturbance=None):
    return ClosedLoop(
        plant=Manipulator(paper_arm(), q=q, disturbance=disturbance),
        observer=ArmFullState(2),
        controller=controller,
        reference=reference or Sines("q", "rad", amplitude=[1.0, 0.5], frequency=[2.0, 3.0]),
    )


def shaken(controller):
    return loop(controller, disturbance=SineTorque(amplitude=[0.5, 0.4], frequency=[3.0, 4.0], phase=[0.0, np.pi / 2]))


def state_feedback(p, z, q, qd, d, ref):
    M, C, G = matrices(p, "controller.model", ref[0], ref[1])
    tau = M @ ref[2] + C @ ref[1] + G
    return tau - p["controller.Kp"] @ (q - ref[0]) - p["controller.Kd"] @ (qd - ref[1]), {}


def test_the_loop_is_the_one_written_by_hand():
    ode = shaken(ArmStateFeedback(paper_arm(), Kp, Kd)).ode()
    assert worst_difference(ode, closed_loop(state_feedback), np.random.default_rng(41)) < 1e-12  # rounding


def test_the_motion_is_that_of_another_integrator():
    ode = shaken(ArmStateFeedback(paper_arm(), Kp, Kd)).ode()
    ours = simulate(rk4(ode, 5e-5), until=0.5, every=0.5).x[0, -1]
    # RK4 at 0.05 ms on modes of about 60 1/s: (h lambda)^4 is 1e-10, and the error a fraction of it
    np.testing.assert_allclose(ours, integrate(ode, closed_loop(state_feedback), 0.5), rtol=0, atol=1e-10)


def test_from_the_reference_the_right_model_follows_it():
    start = {
        "q": (0.0, 0.0),
        "reference": Sines("q", "rad", amplitude=[1.0, 0.5], frequency=[2.0, 3.0], phase=[np.pi / 2] * 2),
    }
    ode = loop(ArmStateFeedback(paper_arm(), Kp, Kd), **(start | {"q": (1.0, 0.5)})).ode()
    run = simulate(rk4(ode, 1e-4), until=2.0, every=0.1)
    np.testing.assert_allclose(run["e"], 0, atol=1e-9)  # the error of RK4, which feedback holds down


def test_a_gain_in_one_piece_is_the_same_law():
    one, two = (
        loop(law).ode()
        for law in (ArmStateFeedback.of(paper_arm(), np.hstack([Kp, Kd])), ArmStateFeedback(paper_arm(), Kp, Kd))
    )
    assert one.fingerprint == two.fingerprint
    np.testing.assert_array_equal(one.parameters.default, two.parameters.default)


def linear_arm(q):
    """A, B of e'' = M^-1 (u - dG/dq e) at rest at q, by the derivative of a hand-written G."""
    m = {"a.links[0].mass": 1.0, "a.links[1].mass": 1.0, "a.links[0].length": 1.0, "a.links[1].length": 1.0}
    M = matrices(m | {"a.gravity": 9.81}, "a", q, np.zeros(2))[0]
    c1, c12 = np.cos(q[0]), np.cos(q[0] + q[1])
    stiffness = 9.81 * np.array([[2 * c1 + c12, c12], [c12, c12]])
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(M, stiffness), np.zeros((2, 2))]])
    return A, np.vstack([np.zeros((2, 2)), np.linalg.inv(M)])


@pytest.mark.parametrize("q", [(0.0, 0.0), (0.6, -0.8), (np.pi, 0.3)])
def test_near_rest_the_cost_of_the_lqr_is_x_p_x(q):
    A, B = linear_arm(q)
    Q, R = np.diag([40.0, 30.0, 2.0, 1.0]), np.diag([0.1, 0.2])
    P = solve_continuous_are(A, B, Q, R)
    law = ArmStateFeedback.of(paper_arm(), np.linalg.solve(R, B.T @ P))
    x0 = 1e-5 * np.array([1.0, -2.0, 0.0, 0.0])
    ode = loop(law, q=np.array(q) + x0[:2], reference=Constant("q", "rad", list(q))).ode()
    y = ode.outputs.view(ode.output)
    x, u = ca.vertcat(y["e"], y["ed"]), y["tau"] - ca.DM(weight(q))
    costly = with_quadrature(ode, {"J": (x.T @ Q @ x + u.T @ R @ u) / 1e-10})
    J = simulate(rk4(costly, 1e-3), until=30.0, every=30.0)["J"][0, -1]
    assert float(np.squeeze(J)) == pytest.approx(x0 @ P @ x0 / 1e-10, rel=2e-4)  # the arm's curvature over 1e-5 rad


def weight(q):
    """G of the paper's arm."""
    tip = 9.81 * np.sin(q[0] + q[1])
    return np.array([2 * 9.81 * np.sin(q[0]) + tip, tip])


def test_a_gain_of_another_shape_is_refused():
    with pytest.raises(
        ValueError, match=r"`ArmStateFeedback.of\(K=...\)` must have 2 rows.* and 4 columns.*shape \(4, 2\)"
    ):
        ArmStateFeedback.of(paper_arm(), np.ones((4, 2)))
    with pytest.raises(ValueError, match=r"`ArmStateFeedback.of\(K=...\)` must be a matrix of numbers"):
        ArmStateFeedback.of(paper_arm(), "fast")
    with pytest.raises(ValueError, match=r"`ArmStateFeedback\(Kp=...\)` must be an array of shape \(m, n = 2\)"):
        ArmStateFeedback(paper_arm(), [1.0, 2.0], Kd)


def test_a_gain_of_the_other_sign_is_refused():
    K = np.hstack([Kp, Kd])
    with pytest.raises(
        ValueError, match=r"(?s)`ArmStateFeedback\(Kd=...\)` must damp.* A gain of u = \+K x must change"
    ):
        ArmStateFeedback.of(paper_arm(), -K)
    ArmStateFeedback(paper_arm(), -Kp, Kd)  # gravity may hold what Kp pushes
    ArmStateFeedback(paper_arm(), Kp, 0 * Kd)  # friction may damp
    ArmStateFeedback(paper_arm(), Kp, np.diag([1.0, -0.1]))  # M may carry damping from joint to joint

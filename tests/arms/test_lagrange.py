"""M, C and G have the structure that the mechanics promises, for any planar arm."""

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings

from tests.support.arms import moving_arms, random_arm
from workbench.arms.dynamics import Dynamics
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import lagrange
from workbench.blocks.loop import open_loop
from workbench.blocks.signals import SineTorque
from workbench.core import rk4
from workbench.core.bounded_loop import bounded_loop, called_loop

ROUNDING = 1e-12  # a few hundred terms of a double each, relative to the largest


@settings(max_examples=8)
@given(moving_arms())
def test_m_is_symmetric_and_positive_definite(drawn):
    arm, q, qd = drawn
    M, _, _ = Dynamics.of(arm).matrices(q, qd)
    np.testing.assert_array_equal(M, M.T)
    eigenvalues = np.linalg.eigvalsh(M)
    assert eigenvalues.min() > 0


@settings(max_examples=8)
@given(moving_arms())
def test_m_dot_minus_two_c_is_skew(drawn):
    arm, q, qd = drawn
    d = Dynamics.of(arm)
    N = ca.Function("N", [d.q, d.qd, d.symbols], [d.mass_matrix_rate - 2 * d.C])
    skew = np.array(N(q, qd, d.p.default))
    M, _, _ = d.matrices(q, qd)
    scale = np.abs(M).max() * max(np.abs(qd).max(), 1e-300)
    np.testing.assert_allclose(skew + skew.T, 0, atol=ROUNDING * scale)


@settings(max_examples=8)
@given(moving_arms())
def test_m_and_c_do_not_know_the_first_angle(drawn):
    arm, q, qd = drawn
    d = Dynamics.of(arm)
    turned = q + np.eye(arm.dof)[0]
    np.testing.assert_array_equal(d.matrices(q, qd)[0], d.matrices(turned, qd)[0])
    np.testing.assert_array_equal(d.matrices(q, qd)[1], d.matrices(turned, qd)[1])


@settings(max_examples=8)
@given(moving_arms(most=3))
def test_the_energy_changes_by_the_work_of_torque_and_disturbance(drawn):
    arm, q, qd = drawn
    n = arm.dof
    plant = Manipulator(arm, q, qd, disturbance=SineTorque(np.arange(1.0, n + 1), np.full(n, 2.0)))
    t, tau, D = 0.3, np.linspace(-4, 5, n), np.arange(1.0, n + 1) * np.sin(0.6)
    ode = open_loop(plant)
    qdd = ode.rate_at(t, np.concatenate([q, qd]), ode.parameters.pack({"tau": tau})[0])[n:]
    x, v = ca.SX.sym("x", n), ca.SX.sym("v", n)
    energy = arm.kinetic_energy(x, v) + arm.potential_energy(x)
    parts = [ca.jtimes(energy, x, ca.SX(qd)), ca.jtimes(energy, v, ca.SX(qdd))]
    rates = np.array(ca.Function("E", [x, v], [ca.vertcat(*parts)])(q, qd)).ravel()
    d = Dynamics.of(arm)
    M, C, G = d.matrices(q, qd)
    scale = np.abs(qd) @ (np.abs(M) @ np.abs(qdd) + np.abs(C) @ np.abs(qd) + np.abs(G) + np.abs(tau) + np.abs(D))
    # qdd solves M qdd = ... with an error of cond(M) roundings, which M gives back to the balance
    assert rates.sum() == pytest.approx(qd @ (tau - D), abs=1e-13 * np.linalg.cond(M) * scale + 1e-13)


@pytest.mark.parametrize("joints", [1, 2, 3])
def test_the_energy_of_a_free_arm_is_kept_to_the_order_of_the_step(joints):
    arm = random_arm(joints, np.random.default_rng(joints))
    ode = open_loop(Manipulator(arm, q=np.full(joints, 1.0), qd=np.zeros(joints)))
    energy = ca.Function("E", [ode.x], [arm.kinetic_energy(*_halves(ode.x)) + arm.potential_energy(ode.x[:joints])])
    start, p = ode.states.default, ode.parameters.default
    drifts = []
    for h in (0.004, 0.002, 0.001):
        step, count = rk4(ode, h), round(1.0 / h)
        order = [step.rule.x, step.rule.k, step.rule.p]
        F = ca.Function("F", order, [step.F(*(order[i] for i in (1, 0, 2)), [])]).mapaccum(count)
        end = F(start, np.arange(count)[None], np.tile(p[:, None], (1, count)))[:, -1]
        drifts.append(abs(float(energy(end)) - float(energy(start))))
    orders = np.log2(np.array(drifts[:-1]) / drifts[1:])
    # the energy of a fourth-order step drifts as h^4, or as h^5 where the leading term happens to cancel
    assert (orders > 3.5).all(), (drifts, orders)
    assert drifts[-1] < 1e-6


def _halves(x):
    n = x.shape[0] // 2
    return x[:n], x[n:]


def test_c_follows_the_christoffel_symbols_as_the_book_writes_them():
    arm = random_arm(3, np.random.default_rng(7))
    d = Dynamics.of(arm)
    n = d.dof
    dM = [ca.jacobian(ca.vec(d.M), d.q[k]).reshape((n, n)) for k in range(n)]
    C = ca.SX.zeros(n, n)
    for i in range(n):
        for j in range(n):
            for k in range(n):
                C[i, j] += (dM[k][i, j] + dM[j][i, k] - dM[i][j, k]) / 2 * d.qd[k]
    f = ca.Function("gap", [d.q, d.qd, d.symbols], [C - d.C, C])
    gap, size = f([0.3, -1.0, 2.0], [1.0, -2.0, 0.5], d.p.default)
    assert np.abs(np.array(gap)).max() < ROUNDING * np.abs(np.array(size)).max()


def test_derivatives_are_taken_at_any_expression_of_the_state():
    x = ca.SX.sym("x", 2)
    made = lagrange.gravity_vector(lambda q: ca.sumsqr(q) * q[0], 3 * x)
    value = np.array(ca.Function("g", [x], [made])([1.0, 2.0])).ravel()
    np.testing.assert_array_equal(value, [3 * 9 + 36, 2 * 6 * 3])


def test_a_loop_that_gives_the_speed_is_not_differentiated():
    def mass(q):
        return ca.blockcat([[2 + ca.cos(q[1]), ca.sin(q[0])], [ca.sin(q[0]), 1 + q[0] ** 2]])

    x = ca.SX.sym("x", 4)
    (q,), (qd,) = (bounded_loop(2, lambda c, y=y: (c + y,), y) for y in (x[:2], x[2:]))
    pairs = (q, qd), (3 * x[:2], 3 * x[2:])
    loop, plain = (ca.Function("C", [x], [lagrange.coriolis_matrix(mass, *pair)]) for pair in pairs)
    at = [0.3, 0.4, 0.5, -0.6]
    np.testing.assert_allclose(np.array(loop(at)), np.array(plain(at)), rtol=0, atol=1e-14)  # 3 x by two sums
    calls = [loop.instructions_sx()[i] for i in range(loop.n_instructions()) if loop.instruction_id(i) == ca.OP_CALL]
    assert len(calls) == 2  # the two loops, and no derivative of them, which the batch engine would not know
    assert all(called_loop(call.which_function()) is not None for call in calls)

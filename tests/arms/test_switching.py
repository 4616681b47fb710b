"""Relays: as they chatter where they are sampled, and as backward Euler makes them stand still."""

import casadi as ca
import numpy as np
import pytest
from scipy.optimize import lsq_linear

from workbench.arms.laws import AdaptiveSlidingMode, AosmcRgs, FuzzyAsmc, RbfAsmc, SlidingMode, SuperTwisting
from workbench.arms.laws.sliding_surface import relay, saturation
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import ArmFullState
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Sines, SineTorque
from workbench.core import Entry, Layout, Ode, SampledSystem
from workbench.engine import simulate
from workbench.engine.metrics import measure, total_variation

ARM = paper_arm()


def solved(n, period):
    s, M, K = ca.SX.sym("s", n), ca.SX.sym("M", n, n), ca.SX.sym("K", n)
    return ca.Function("relay", [s, M, K], [relay(s, M, K, period)])


def drawn(n, rng):
    """s from deep in sliding to far outside, a mass matrix, and gains, one of them perhaps zero."""
    X = rng.normal(size=(n, n))
    K = rng.uniform(0, 5, n) * (rng.uniform(size=n) > 0.1)
    return rng.normal(size=n) * 10 ** rng.uniform(-5, 0), X @ X.T + 0.2 * np.eye(n), K


@pytest.mark.parametrize("n", [1, 2])
def test_for_one_joint_and_for_two_the_torque_is_the_solution_of_the_inclusion(n):
    """v_i in K_i Sgn(s_i+) put back into the equation, whatever saturates."""
    f, rng = solved(n, 1e-3), np.random.default_rng(7)
    kinds = set()
    for _ in range(300):
        s, M, K = drawn(n, rng)
        v = np.array(f(s, M, K)).ravel()
        after = s - 1e-3 * np.linalg.solve(M, v)
        size = np.abs(s).max() + 1e-3 * np.abs(np.linalg.inv(M) @ K).max()
        slides = np.abs(after) <= 1e-11 * size  # rounding, times the condition of M
        assert (np.abs(v) <= K).all()
        np.testing.assert_array_equal(v[~slides], (K * np.sign(after))[~slides])
        kinds.add(tuple(slides))
    assert len(kinds) == 2**n  # every case came up


@pytest.mark.parametrize("n", [2, 3, 6])
def test_the_torque_is_the_point_of_the_box_that_an_active_set_method_finds(n):
    f, rng = solved(n, 1e-3), np.random.default_rng(8)
    for _ in range(60):
        s, M, K = drawn(n, rng)
        K += 0.01  # theirs takes no empty interval
        root = np.sqrt(1e-3) * np.linalg.inv(np.linalg.cholesky(M))  # root^T root = h M^-1
        theirs = lsq_linear(root, np.linalg.solve(root.T, s), (-K, K), method="bvls", tol=1e-15).x
        np.testing.assert_allclose(np.array(f(s, M, K)).ravel(), theirs, rtol=0, atol=1e-10)  # rounding, cond(M) 1e3


def test_in_sliding_the_torque_is_exact_for_any_number_of_joints():
    f, rng = solved(7, 1e-3), np.random.default_rng(9)
    _, M, _ = drawn(7, rng)
    v = rng.uniform(-1, 1, 7)
    np.testing.assert_allclose(np.array(f(1e-3 * np.linalg.solve(M, v), M, np.ones(7))).ravel(), v, atol=1e-12)


# s' = -k u + d, with u in Sgn(s) at the instants


def scalar(kind, h, d=0.0, k=2.0, start=0.75):
    states = Layout((Entry("s", np.array(start)), Entry("u", np.array(0.0))))
    t, x, j = ca.SX.sym("t"), states.symbols(), ca.SX.sym("k")
    u = ca.sign(x[0]) if kind == "sign" else relay(x[0], ca.SX(1), ca.SX(k), h) / k
    flow = Ode.of("relay", states, Layout(), (t, x, ca.SX(0, 1)), {"s": -k * x[1] + d, "u": ca.SX(0)}, {"relay": x[1]})
    return simulate(SampledSystem(flow, h, j, ca.SX(0, 1), ca.vertcat(x[0], u)).step(), until=1.0)


@pytest.mark.parametrize("h", [0.01, 0.005])
def test_the_implicit_relay_comes_to_zero_in_finitely_many_steps_and_stays(h):
    run = scalar("implicit", h)
    there = int(np.ceil(0.75 / (2.0 * h)))
    assert np.abs(run["s"][0, :there]).min() > 1e-3
    assert np.abs(run["s"][0, there:]).max() < 1e-14  # rounding
    assert np.abs(run["relay"][0, there:, 0]).max() < 1e-12


@pytest.mark.parametrize("h", [0.01, 0.005])
def test_under_a_constant_push_the_implicit_relay_holds_still_and_answers_the_push_exactly(h):
    run = scalar("implicit", h, d=0.7)
    late = run.t > 0.8
    np.testing.assert_allclose(run["s"][0, late], 0.7 * h, rtol=1e-11)  # what one period of the push makes
    np.testing.assert_allclose(run["relay"][0, late, 0], 0.7 / 2.0, rtol=1e-11)


def test_the_explicit_relay_chatters_in_proportion_to_the_period_and_the_implicit_one_does_not():
    late, travel = {}, {}
    for kind in ("sign", "implicit"):
        for h in (0.01, 0.005, 0.0025):
            run = scalar(kind, h, d=0.7)
            settled = run.t > 0.8
            late[kind, h] = np.ptp(run["s"][0, settled])
            travel[kind, h] = np.abs(np.diff(run["relay"][0, :, 0])).sum()
    for h in (0.01, 0.005, 0.0025):
        assert 2.0 * h <= late["sign", h] <= 2 * 2.0 * h  # a step is (k - d) h one way, (k + d) h the other
    for h in (0.01, 0.005):
        assert travel["sign", h / 2] > 1.8 * travel["sign", h]
        assert late["implicit", h] < 1e-14
        assert travel["implicit", h / 2] == pytest.approx(travel["implicit", h], abs=1e-9)
    assert travel["implicit", 0.01] == pytest.approx(1 - 0.35)  # from 1 on the way to the push, once


# The laws


def law(saturation, kind=SlidingMode):
    numbers = {"model": ARM, "Lambda": [6.0, 5.0], "phi": 0.1, "saturation": saturation}
    if kind is SuperTwisting:
        return SuperTwisting(**numbers, k1=[8.0, 9.0], k2=[20.0, 25.0])
    if kind is SlidingMode:
        return SlidingMode(**numbers, K=[4.0, 3.0])
    numbers |= {"gamma": 0.5, "K": [4.0, 3.0]}
    if kind is FuzzyAsmc:
        return FuzzyAsmc(**numbers, lag=0.1)
    if kind is RbfAsmc:
        return RbfAsmc(**numbers, Gamma=1.0, sigma=0.1, centres=np.zeros((1, 4)), widths=np.ones(4))
    return AdaptiveSlidingMode(**numbers)


def loop(controller):
    push = SineTorque(amplitude=[0.5, 0.4], frequency=[3.0, 4.0], phase=[0.0, np.pi / 2])
    plant = Manipulator(ARM, q=[0.6, -0.8], disturbance=push)
    return ClosedLoop(plant, ArmFullState(2), controller, Sines("q", "rad", [1.0, 0.5], [2.0, 3.0]))


LAWS = [SlidingMode, AdaptiveSlidingMode, FuzzyAsmc, RbfAsmc, SuperTwisting]


@pytest.mark.heavy
def test_on_the_arm_the_torque_chatters_explicitly_and_not_implicitly():
    travel = {}
    for kind in ("sign", "implicit"):
        for h in (4e-3, 2e-3):
            score = measure(loop(law(kind)).digital(h), (total_variation(h),), until=2.0, h=h).score("TV")
            travel[kind, h] = score.value[0]
    assert (travel["sign", 2e-3] > 1.5 * travel["sign", 4e-3]).all()
    assert (travel["sign", 4e-3] > 10 * travel["implicit", 4e-3]).all()
    np.testing.assert_allclose(travel["implicit", 2e-3], travel["implicit", 4e-3], rtol=0.1)


@pytest.mark.parametrize("kind", [SlidingMode, SuperTwisting])
def test_in_sliding_s_is_what_the_push_of_one_period_makes(kind):
    """Each period takes back the s of the last, whatever the law: s+ = h times the push, of first order in h."""
    left = []
    for h in (4e-3, 2e-3):
        run = simulate(loop(law("implicit", kind)).digital(h).step(2), until=4.0)
        left.append(np.abs(run["s"][0, run.t > 2.0]).max(axis=0))
    np.testing.assert_allclose(left[0] / left[1], 2.0, rtol=0.05)


def test_the_implicit_super_twisting_solves_both_its_lines_at_the_end_of_the_period():
    """s+ = s + h (-k1 |s+|^(1/2) sign(s+) + w+), w+ = w - h k2 sign(s+), put back with the torque and w+ of the law."""
    h, k1, k2 = 5e-3, np.array([8.0, 9.0]), np.array([20.0, 25.0])
    step, rng = loop(law("implicit", SuperTwisting)).digital(h).step(), np.random.default_rng(10)
    kinds = set()
    arm = ca.Function(
        "M",
        [q := ca.SX.sym("q", 2), qd := ca.SX.sym("qd", 2)],
        [ARM.mass_matrix(q), ARM.coriolis_matrix(q, qd) @ qd + ARM.gravity_vector(q)],
    )
    for _ in range(100):
        x = step.states.default.copy()
        s = rng.normal(size=2) * 10 ** rng.uniform(-5, 0)
        w = rng.normal(size=2)
        q = rng.uniform(-1, 1, 2)
        Lambda, e = np.array([6.0, 5.0]), q  # at k = 0 the reference is 0 and its rate (2, 1.5)
        ed = s - Lambda * e
        x[step.states.slice("plant.q")], x[step.states.slice("plant.qd")] = q, ed + np.array([2.0, 1.5])
        x[step.states.slice("controller.w")] = w
        after = step.states.unpack(np.array(step.F(0, x, step.parameters.default, [])).ravel())
        M, bias = (np.array(part) for part in arm(q, ed + np.array([2.0, 1.5])))
        u = np.linalg.solve(M, after["hold.tau"] - bias.ravel()) + Lambda * ed  # qdd_ref = 0 at k = 0
        s_next, w_next = s + h * u, after["controller.w"]
        sigma = (w - w_next) / (h * k2)
        rest = np.abs(s_next) < 1e-10
        np.testing.assert_array_less(np.abs(sigma), 1 + 1e-9)
        np.testing.assert_allclose(sigma[~rest], np.sign(s_next)[~rest], atol=1e-9)
        expected = -k1 * np.sqrt(np.abs(np.where(rest, 0, s_next))) * sigma + w_next
        np.testing.assert_allclose(u, expected, atol=1e-8)  # rounding of torques of 50 N m over a root near zero
        kinds |= set(rest)
    assert kinds == {True, False}


@pytest.mark.parametrize("kind", LAWS)
def test_an_implicit_law_is_refused_in_continuous_time(kind):
    with pytest.raises(
        ValueError, match=rf"`{kind.__name__}\(saturation='implicit'\)` solves its relay over a sampling"
    ):
        loop(law("implicit", kind)).ode()


@pytest.mark.parametrize("kind", LAWS)
@pytest.mark.parametrize("saturation", ["sign", "implicit"])
def test_every_law_with_a_relay_is_near_the_one_with_a_thin_layer(kind, saturation):
    """Within a layer of 0.1 rad/s, with all of them below 1 % of the initial error in the end."""
    run = simulate(loop(law(saturation, kind)).digital(2e-3).step(2), until=3.0)
    assert np.abs(run["e"][0, -1]).max() < 1e-2


def test_a_sampled_law_is_told_its_period_and_the_block_is_left_as_it_was():
    controller = law("implicit")
    assert controller.run_every(0.01).period == 0.01
    assert controller.period is None
    loop(controller).digital(0.01).step()
    with pytest.raises(ValueError, match="continuous time has none of"):
        loop(controller).ode()


def test_a_law_whose_gain_is_a_matrix_has_no_implicit_relay():
    eye = np.eye(2)
    with pytest.raises(
        ValueError, match=r"`AosmcRgs\(saturation=...\)` is one of 'clip', 'tanh', 'sign'; got 'implicit'"
    ):
        AosmcRgs(ARM, [1.0, 1.0], 0.1, K=eye, P=eye, Q=eye, R=eye, saturation="implicit")


def test_the_sign_is_the_limit_of_a_thin_layer():
    s = ca.SX.sym("s")
    thin, sign = (ca.Function("f", [s], [saturation(s, 1e-12, kind)]) for kind in ("clip", "sign"))
    for value in (-2.0, -1e-9, 0.0, 1e-9, 3.0):
        assert float(thin(value)) == float(sign(value))

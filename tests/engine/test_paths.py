"""Linear models along a path: frozen, integrated, and in the long run."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from tests.support.equations import decay
from workbench.arms.laws import SlidingMode
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import ArmFullState
from workbench.blocks.loop import ClosedLoop, open_loop
from workbench.blocks.signals import Sines
from workbench.core import Entry, Layout, Ode, rk4
from workbench.design.linear import along, freeze, linearize, lyapunov_exponents
from workbench.engine import simulate


def arm():
    return open_loop(Manipulator(paper_arm(), q=[1.4, -0.3]))


def fall(until=1.0):
    run = simulate(rk4(arm(), 1e-3), arm().parameters.default[np.newaxis], until=until, every=0.1)
    return run.t, run.x[0]


def turning_decay():
    """x' = A(t) x whose frozen eigenvalues all decay at 1/2 while one solution grows as exp(t / 2) (Vinograd)."""
    states = Layout((Entry("x", np.array([1.0, 0.0])),))
    t, x = ca.SX.sym("t"), states.symbols()
    c, s, a = ca.cos(t), ca.sin(t), 1.5
    A = ca.vertcat(ca.horzcat(-1 + a * c**2, 1 - a * s * c), ca.horzcat(-1 - a * s * c, -1 + a * s**2))
    return Ode.of("vinograd", states, Layout(), (t, x, ca.SX(0, 1)), {"x": A @ x}, {})


def test_each_model_of_a_path_is_the_model_at_its_point():
    t, x = fall()
    path = along(arm(), t, x)
    for k in (0, 5, 10):
        G = linearize(arm(), t[k], x[k])
        for letter, matrices in zip("ABCD", (path.A, path.B, path.Cy, path.D), strict=True):
            np.testing.assert_array_equal(matrices[k], getattr(G, letter))
    assert path.states == ("q[0]", "q[1]", "qd[0]", "qd[1]")
    assert (path.inputs, path.outputs) == (("tau[0]", "tau[1]"), path.states)


def test_inputs_may_change_along_a_path():
    t, x = fall()
    rows = np.repeat(arm().parameters.default[np.newaxis], len(t), axis=0)
    rows[3, -2:] = [10.0, -4.0]
    path = along(arm(), t, x, rows)
    np.testing.assert_array_equal(path.A[3], linearize(arm(), t[3], x[3], u=[10.0, -4.0]).A)


@pytest.mark.parametrize(
    ("t", "x", "options", "message"),
    [
        ([0, 1], np.zeros((3, 4)), {}, r"N times and states \(N, 4\); got shapes \(2,\) and \(3, 4\)"),
        ([0, 0], np.zeros((2, 4)), {}, "times that increase"),
        ([0, 1], np.full((2, 4), np.nan), {}, "a run may have diverged"),
        ([0, 1], np.zeros((2, 4)), {"p": np.zeros((3, 7))}, "a row for each of the 2 times; got 3"),
    ],
)
def test_what_is_no_path_is_refused(t, x, options, message):
    with pytest.raises(ValueError, match=message):
        along(arm(), t, x, **options)


def test_frozen_eigenvalues_decay_while_the_system_grows():
    ode, t = turning_decay(), np.linspace(0, 6, 31)
    path = along(ode, t, np.ones((31, 2)))
    # trace -1/2, determinant 1/2: real part -1/4 at all times
    np.testing.assert_allclose(path.eigenvalues().real, -0.25, rtol=0, atol=1e-9)
    grown = simulate(rk4(ode, 1e-3), until=6.0, every=0.2)
    # the solution is exp(t / 2) (cos t, -sin t), by substitution
    np.testing.assert_allclose(grown.x[0], np.exp(t / 2)[:, None] * np.c_[np.cos(t), -np.sin(t)], atol=1e-7)


def test_an_equation_that_jumps_has_no_exponents_here():
    law = SlidingMode(paper_arm(), [6.0, 6.0], [5.0, 5.0], phi=0.5, saturation="sign")
    loop = ClosedLoop(
        Manipulator(paper_arm(), q=[0.3, -0.2]), ArmFullState(2), law, Sines("q", "rad", [1.0, 0.5], [2.0, 3.0])
    )
    with pytest.raises(ValueError, match="`lyapunov_exponents.*may jump where .* = 0.*`freeze`"):
        lyapunov_exponents(loop.ode(), 1.0, 0.005)


def test_the_exponents_of_a_constant_system_are_its_real_parts():
    states = Layout((Entry("x", np.ones(3)),))
    x = states.symbols()
    A = np.array([[-1.0, 5.0, 2.0], [0.0, -3.0, 1.0], [0.0, 0.0, 0.5]])
    ode = Ode.of("triangle", states, Layout(), (ca.SX.sym("t"), x, ca.SX(0, 1)), {"x": ca.DM(A) @ x}, {})
    found = lyapunov_exponents(ode, until=30.0, h=0.01, skip=10.0)
    np.testing.assert_allclose(found.values, [0.5, -1.0, -3.0], atol=1e-7)  # RK4 at 5 ms
    assert found.imbalance < 1e-7


def test_the_largest_exponent_of_vinograds_system_is_a_half():
    found = lyapunov_exponents(turning_decay(), until=20.0, h=0.01)
    assert (np.abs(found.values - [0.5, -1.0]) <= found.error + 1e-6).all()


@pytest.mark.heavy
def test_the_exponents_of_the_lorenz_attractor_lie_within_their_stated_errors():
    states = Layout((Entry("x", np.array([1.0, 1.0, 20.0])),))
    x = states.symbols()
    rates = ca.vertcat(10 * (x[1] - x[0]), x[0] * (28 - x[2]) - x[1], x[0] * x[1] - 8 / 3 * x[2])
    ode = Ode.of("lorenz", states, Layout(), (ca.SX.sym("t"), x, ca.SX(0, 1)), {"x": rates}, {})
    found = lyapunov_exponents(ode, until=120.0, h=0.01, skip=20.0)
    # published: 0.9056, 0, -14.5723 (Sprott 2003, Chaos and Time-Series Analysis, Lorenz attractor)
    assert (np.abs(found.values - [0.9056, 0.0, -14.5723]) <= found.error).all()
    assert found.error[0] < 0.5  # of a chaotic path of 100 s, taken with two steps that part
    assert abs(found.values.sum() + 41 / 3) < 1e-3  # the trace is constant


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"until": 1.0, "h": 0.3}, r"until - skip\)` must be a multiple of 200 steps"),
        ({"until": 4.0, "h": 0.01, "skip": 0.003}, "skip=.*20 steps"),
        ({"until": 4.0, "h": 0.01, "skip": float("nan")}, "skip=.*finite"),
        ({"until": 4.0, "h": 0.0}, "h=.*positive"),
    ],
)
def test_spans_that_do_not_fit_are_refused(options, message):
    with pytest.raises(ValueError, match=message):
        lyapunov_exponents(decay(), **options)


def test_an_escape_is_refused_with_its_time():
    ode = decay()
    ode = replace(ode, rate=ode.x**2)
    with pytest.raises(ValueError, match="not finite at t ="):
        lyapunov_exponents(ode, 4.0, 0.01)


def test_a_held_state_is_a_parameter_and_its_jacobian_is_the_block_that_is_left():
    ode = arm()
    fixed = freeze(ode, ["q"])
    assert fixed.states.names == ("qd",)
    assert fixed.parameters.names[-1] == "q"
    x = np.array([0.3, -0.4, 1.0, 2.0])
    whole, block = (
        np.array(o.A(0.0, s, p))
        for o, s, p in ((ode, x, ode.parameters.default), (fixed, x[2:], np.r_[ode.parameters.default, x[:2]]))
    )
    np.testing.assert_array_equal(block, whole[2:, 2:])


@pytest.mark.parametrize(
    ("names", "error"), [([], ValueError), ("q", ValueError), (["q", "qd"], ValueError), (["qq"], LookupError)]
)
def test_states_that_cannot_be_held_are_refused(names, error):
    with pytest.raises(error):
        freeze(arm(), names)

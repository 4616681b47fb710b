"""An Ode in python-control: the same numbers, the same names, exact Jacobians."""

from dataclasses import replace

import casadi as ca
import control
import mpmath
import numpy as np
import pytest

from tests.support.equations import decay, oscillator, root
from workbench.arms.laws import SlidingMode
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import ArmFullState
from workbench.blocks.loop import ClosedLoop, open_loop
from workbench.blocks.signals import Constant
from workbench.core import Entry, Layout, Ode, rk4
from workbench.design import linearize, to_control
from workbench.design.linear import operating_point
from workbench.engine import simulate

STATES = ["q[0]", "q[1]", "qd[0]", "qd[1]"]
TORQUES = ["tau[0]", "tau[1]"]


def arm():
    return open_loop(Manipulator(paper_arm(), q=[0.4, -0.3]))


def test_the_names_of_states_inputs_and_outputs_are_kept():
    for system in (to_control(arm(), name="arm"), linearize(arm(), 0.0, np.zeros(4))):
        assert list(system.state_labels) == STATES
        assert list(system.input_labels) == TORQUES
        assert list(system.output_labels) == STATES
    assert to_control(arm(), name="arm").name == "arm"
    assert to_control(arm()).name == "plant"


def test_python_control_evaluates_the_equations_themselves():
    ode, rng = arm(), np.random.default_rng(3)
    system = to_control(ode)
    for _ in range(5):
        x, u = rng.uniform(-1, 1, 4), rng.uniform(-3, 3, 2)
        p = ode.parameters.pack({"tau": u})[0]
        # the same CasADi function: the same bits
        np.testing.assert_array_equal(system.dynamics(0.0, x, u), ode.rate_at(0.0, x, p))
        np.testing.assert_array_equal(system.output(0.0, x, u), np.array(ode.h(0.0, x, p)).ravel())


def test_the_falling_arm_of_python_control_is_ours():
    ode, t = arm(), np.linspace(0, 1, 101)
    torque = np.array([2.0, -1.0])
    theirs = control.input_output_response(
        to_control(ode),
        t,
        np.repeat(torque[:, np.newaxis], len(t), axis=1),
        ode.states.default,
        solve_ivp_method="DOP853",
        solve_ivp_kwargs={"rtol": 1e-12, "atol": 1e-12},
    )
    ours = simulate(rk4(ode, 1e-3), ode.parameters.pack({"tau": torque}), until=1.0, every=1e-2)
    # RK4 at 1 ms on motions of a few rad/s: h^4 times the fifth derivatives, about 1e-10
    np.testing.assert_allclose(ours.x[0], theirs.states.T, rtol=0, atol=1e-9)


def test_the_linear_model_has_the_jacobians_of_the_equations():
    ode, rng = arm(), np.random.default_rng(4)
    system = to_control(ode)
    x, u, step = rng.uniform(-1, 1, 4), rng.uniform(-3, 3, 2), 1e-5
    linear = linearize(ode, 0.0, x, u=u)
    for function, A, B in ((system.dynamics, linear.A, linear.B), (system.output, linear.C, linear.D)):
        by_x = [(function(0, x + d, u) - function(0, x - d, u)) / (2 * step) for d in step * np.eye(4)]
        by_u = [(function(0, x, u + d) - function(0, x, u - d)) / (2 * step) for d in step * np.eye(2)]
        # a central difference: step^2 times third derivatives of about 100, and rounding 1e-16 / step
        np.testing.assert_allclose(A, np.transpose(by_x), atol=2e-8)
        np.testing.assert_allclose(B, np.transpose(by_u), atol=2e-8)


def test_parameters_other_than_the_nominal_are_taken():
    ode = oscillator_with_input()
    p = ode.parameters.pack({"omega": 5.0})[0]
    np.testing.assert_array_equal(to_control(ode, p).dynamics(0.0, [1.0, 0.0], [5.0]), [0.0, -25.0])
    # the frequency is here the input: x'' = -u^2 q, so d/du = -2 u q
    np.testing.assert_allclose(linearize(ode, 0.0, [1.0, 0.0], p).B, [[0.0], [-10.0]])
    np.testing.assert_allclose(linearize(ode, 0.0, [1.0, 0.0], p, u=[3.0]).B, [[0.0], [-6.0]])


def oscillator_with_input():
    return replace(oscillator(), inputs=("omega",))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"x": np.zeros(3)}, r"`x` must be 4 finite numbers: q\[0\]"),
        ({"x": [0, 0, 0, np.nan]}, "`x` must be 4 finite numbers"),
        ({"x": "here"}, "`x` must be 4 finite numbers.*got 'here'"),
        ({"x": np.zeros(4), "u": [1.0]}, r"`u` must be 2 finite numbers: tau\[0\], tau\[1\]"),
        ({"x": np.zeros(4), "p": np.zeros(3)}, "`p` must be 7 finite numbers"),
        ({"x": np.zeros(4), "p": np.full(7, -1.0)}, r"'arm.links\[0\].mass' must be .*got -1"),
        ({"x": np.zeros(4), "t": np.inf}, "`t` must be a finite number of seconds"),
    ],
)
def test_what_is_no_point_of_the_equations_is_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        linearize(arm(), **({"t": 0.0} | arguments))


def test_an_equation_without_inputs_is_refused_by_name():
    with pytest.raises(ValueError, match=r"at least one input.*'decay' has none.*ode\.A"):
        linearize(decay(), 0.0, [1.0])
    assert to_control(decay()).ninputs == 0


def test_a_bad_parameter_row_is_refused_by_python_controls_door_too():
    with pytest.raises(ValueError, match="`p` must be 7 finite numbers"):
        to_control(arm(), np.zeros(2))


def accelerations(x, u):
    """qdd of two point masses of 1 kg on rods of 1 m, hanging at zero, to as many digits as mpmath is told."""
    q1, q2, v1, v2 = x
    g, c, s = mpmath.mpf(9.81), mpmath.cos(q2), mpmath.sin(q2)
    M = mpmath.matrix([[3 + 2 * c, 1 + c], [1 + c, 1]])
    bias = mpmath.matrix([-s * v2 * (2 * v1 + v2), s * v1**2])
    G = g * mpmath.matrix([2 * mpmath.sin(q1) + mpmath.sin(q1 + q2), mpmath.sin(q1 + q2)])
    return mpmath.lu_solve(M, mpmath.matrix(u) - bias - G)


def reference_jacobian(x, u):
    """[A, B] by central differences in 60 digits: their error is h^2 = 1e-40, and rounding 1e-60 / h."""
    z, columns = [mpmath.mpf(float(v)) for v in (*x, *u)], []
    with mpmath.workdps(60):
        h = mpmath.mpf(10) ** -20
        for k in range(6):
            up, down = ([v + sign * h * (i == k) for i, v in enumerate(z)] for sign in (1, -1))
            change = (accelerations(up[:4], up[4:]) - accelerations(down[:4], down[4:])) / (2 * h)
            columns.append([float(k == 2), float(k == 3), float(change[0]), float(change[1])])
    return np.transpose(columns)


def test_ours_is_exact_where_python_controls_own_is_a_forward_difference():
    ode, rng = arm(), np.random.default_rng(8)
    system = to_control(ode)
    for _ in range(10):
        x, u = rng.uniform(-2, 2, 4), rng.uniform(-5, 5, 2)
        exact = reference_jacobian(x, u)
        scale = np.abs(exact).max()
        ours, theirs = (np.hstack([G.A, G.B]) for G in (linearize(ode, 0.0, x, u=u), control.linearize(system, x, u)))
        assert np.abs(ours - exact).max() < 1e-13 * scale  # rounding of some hundred operations
        assert 1e-8 * scale < np.abs(theirs - exact).max() < 1e-4 * scale


def test_a_rest_point_that_is_none_is_refused_with_the_rate_that_remains():
    linearize(arm(), 0.0, [0, np.pi, 0, 0], at_rest=True)
    with pytest.raises(
        ValueError, match=r"must be a rest point of 'plant'.*rate of 'qd\[1\]' is -2\.4.*operating_point"
    ):
        linearize(arm(), 0.0, [0.3, 0.2, 0, 0], at_rest=True)


def test_the_torque_that_holds_the_arm_is_its_gravity():
    q = np.array([0.3, 0.2])
    point = operating_point(arm(), {"q": q, "qd": [0, 0]})
    gravity = 9.81 * np.array([2 * np.sin(0.3) + np.sin(0.5), np.sin(0.5)])
    np.testing.assert_allclose(point.u, gravity, rtol=1e-14)  # rounding
    assert max(point.residual, point.error) < 1e-14
    linearize(arm(), 0.0, point.x, point.p, at_rest=True)


def test_states_that_are_not_wanted_are_found():
    # one joint is wanted, and the torque of the other too: gravity decides the angle
    point = operating_point(replace(arm(), inputs=()), {"q[0]": 0.0}, t=0.0)
    np.testing.assert_allclose(np.sin(point.x[1]), 0.0, atol=1e-12)


@pytest.mark.parametrize(
    ("wanted", "message"),
    [
        ({"q": [0.1, 0.2], "qd": [1.0, 0.0]}, r"found no .*tau.*'q\[0\]' still changes by 1 a second"),
        ({"q": [0.1]}, "'q' must be 2 finite numbers"),
        ({"q": "down"}, "'q' must be 2 finite numbers; got 'down'"),
        ({"q[0]": np.nan}, r"'q\[0\]' must be 1 finite numbers"),
    ],
)
def test_a_state_that_no_torque_holds_is_refused(wanted, message):
    with pytest.raises(ValueError, match=message):
        operating_point(arm(), wanted)


def test_a_wanted_state_that_is_none_is_refused_by_name():
    with pytest.raises(LookupError, match="no 'qq'"):
        operating_point(arm(), {"qq": [0, 0]})


def test_a_point_without_a_derivative_is_refused():
    ode = replace(root(), inputs=())
    with pytest.raises(ValueError, match="`operating_point.*A is not finite.*no derivative"):
        operating_point(ode, {})


def relay(saturation):
    """A sliding-mode loop at rest on its surface, cut at the torque."""
    law = SlidingMode(paper_arm(), [6.0, 6.0], [5.0, 5.0], phi=0.01, saturation=saturation)
    return ClosedLoop(Manipulator(paper_arm(), q=[0, 0]), ArmFullState(2), law, Constant("q", "rad", [0.0, 0.0])).cut()


def test_a_relay_on_its_surface_is_refused_and_a_saturation_is_not():
    # -K Lambda / phi + dG_1/dq_1
    assert linearize(relay("clip"), 0.0, np.zeros(4)).C[0, 0] == pytest.approx(-3000 + 3 * 9.81, rel=1e-12)
    with pytest.raises(ValueError, match=r"'tau\[0\]' jumps by 10 as .* at this state"):
        linearize(relay("sign"), 0.0, np.zeros(4))
    off = linearize(relay("sign"), 0.0, [0.1, 0.1, 0.0, 0.0])
    assert np.isfinite(off.C).all()


@pytest.mark.parametrize(
    ("rate", "x", "u"),
    [
        (lambda x, u: ca.floor(x) + u, 1.0, 0.0),
        (lambda x, u: ca.fmod(x, 1) + u, 1.0, 0.0),
        (lambda x, u: ca.copysign(1, x) + u, 0.0, 0.0),
        (lambda x, u: x + ca.sign(u), 0.3, 0.0),
        (lambda x, u: ca.sign(x * u), 0.0, 0.0),
    ],
)
def test_a_jump_of_any_kind_by_state_or_input_is_refused_where_it_is_and_nowhere_else(rate, x, u):
    states, parameters = Layout((Entry("x", 0.0),)), Layout((Entry("u", 0.0),))
    t, symbol, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
    ode = Ode.of("jumps", states, parameters, (t, symbol, p), {"x": rate(symbol, p)}, {"y": symbol})
    ode = replace(ode, inputs=("u",))
    with pytest.raises(ValueError, match="no linear model there"):
        linearize(ode, 0.0, [x], u=[u])
    linearize(ode, 0.0, [x + 0.01], u=[u + 0.01])

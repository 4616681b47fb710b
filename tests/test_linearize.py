"""An Ode in python-control: the same numbers, the same names, exact Jacobians."""

from dataclasses import replace

import control
import numpy as np
import pytest
from equations import decay, oscillator

from workbench.core import rk4
from workbench.design import linearize, to_control
from workbench.loop import open_loop
from workbench.plants import Manipulator
from workbench.robots import paper_arm
from workbench.simulate import simulate

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

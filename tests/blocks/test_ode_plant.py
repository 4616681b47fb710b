"""A plant of functions that are there already gives the numbers of the functions, and says what it cannot read."""

import math
import warnings
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import root

from tests.exams.plants import solve
from tests.support.cases import heavy_but
from workbench.blocks.loop import AbstractController, ClosedLoop, open_loop
from workbench.blocks.plants import OdePlant
from workbench.core import Layout, Signals, block, layout, lift, parameter, rk4
from workbench.core.block import Scalar, parameters
from workbench.design.linear import operating_point
from workbench.engine import simulate

STATES, INPUTS = ("i:A", "omega:rad/s"), ("v:V",)


def motor(t, x, u, p):
    i, omega = x
    return [(u[0] - p.R * i - 0.01 * omega) / 0.5, (0.01 * i - p.b * omega) / 0.01]


def pendulum(t, x, u, m):
    return [x[1], 9.81 * m.sin(x[0]) - m.sqrt(1 + x[1] ** 2) * x[1] + u[0] * m.exp(-t)]


NUMBERS = layout(R=("ohm", 1.0), b=("N m s/rad", 0.1))


@block
class Constant(AbstractController):
    """A constant voltage."""

    reads = layout()
    drives = layout(v="V")

    def command(self, t, z, est, ref):
        return {"v": 2.0}


def test_a_python_function_becomes_the_plant_whose_rates_it_gives():
    ode = open_loop(OdePlant.of(pendulum, ("theta:rad", "omega:rad/s"), ("u:1/s^2",), u0=[0.3]))
    for t, x in ((0.0, [0.1, 0.2]), (2.0, [-3.0, 40.0])):
        # the same operations in another library's elementary functions
        np.testing.assert_allclose(ode.rate_at(t, x), pendulum(t, x, [0.3], np), rtol=1e-14)
    assert [entry.unit for entry in ode.outputs.entries] == ["rad", "rad/s"]


@pytest.mark.parametrize("symbol", [ca.SX, ca.MX])
def test_casadi_functions_of_columns_become_a_plant_as_they_stand(symbol):
    t, x, u, p = symbol.sym("t"), symbol.sym("x", 2), symbol.sym("u"), symbol.sym("p", 2)
    A = ca.vertcat(ca.horzcat(-p[0], -0.01), ca.horzcat(1.0, -p[1]))
    f = ca.Function("f", [t, x, u, p], [A @ x + ca.vertcat(u, t)])
    h = ca.Function("h", [t, x, p], [p[0] * x[1]])
    plant = OdePlant.of(f, STATES, INPUTS, ("y:V",), h, p=layout(a=("", [2.0, 3.0])), x0=[1.0, 4.0], u0=[5.0])
    ode = open_loop(plant)
    assert ode.parameters.names == ("a", "v")
    np.testing.assert_allclose(ode.rate_at(7.0, [1.0, 4.0]), [-2.0 - 0.04 + 5.0, 1.0 - 12.0 + 7.0])
    assert ode.outputs_at(0.0, [1.0, 4.0])["y"] == 8.0


def test_the_numbers_of_a_function_are_varied_as_those_of_any_block():
    plant = OdePlant.of(motor, STATES, INPUTS, ("omega",), p=NUMBERS)
    ode = ClosedLoop(plant, controller=Constant()).ode()
    assert ode.parameters.names == ("plant.R", "plant.b")
    assert ode.parameters["plant.R"].unit == "ohm"
    p = ode.parameters.pack({"plant.R": [1.0, 4.0]})
    ends = simulate(rk4(ode, 0.01), p, until=60.0)["omega"][:, -1]
    # after 60 s, 30 of the slowest time constants, the motor is at rest: omega = K v / (R b + K^2)
    np.testing.assert_allclose(ends.ravel(), [0.02 / (R * 0.1 + 1e-4) for R in (1.0, 4.0)], rtol=1e-6)


def test_an_open_equation_is_a_plant_and_comes_back_from_the_loop():
    plant = OdePlant.of(motor, STATES, INPUTS, ("omega",), p=NUMBERS, x0=[0.5, 1.0])
    again = OdePlant(open_loop(plant))
    first, second = (open_loop(each) for each in (plant, again))
    assert first.parameters.names == second.parameters.names
    np.testing.assert_array_equal(first.states.default, second.states.default)
    np.testing.assert_allclose(first.rate_at(0.0, [0.5, 1.0]), second.rate_at(0.0, [0.5, 1.0]), rtol=1e-15)


def test_numpys_functions_of_a_symbol_give_no_warning():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        plant = OdePlant.of(lambda t, x, u: np.array([x[1], np.sin(x[0]) + u[0]]), ("a:rad", "b:rad/s"), ("u:",))
    assert open_loop(plant).rate_at(0.0, [0.5, 0.0])[1] == math.sin(0.5)


@pytest.mark.parametrize(
    ("f", "says"),
    [
        (lambda t, x, u: [math.sin(x[0]), u[0]], "symbols in place of numbers.*'i' is no number: take `m.sin`"),
        (lambda t, x, u: [1.0 if math.exp(x[0]) > 0.5 else 2.0, u[0]], "'i' is no number"),
        (lambda t, x, u: [1.0 if x[0] > 0 else 2.0, u[0]], "'.0<i.' is no number.*`m.where"),
        (lambda t, x, u: [x[0]], "must return 2 numbers, for i, omega; it returned 1"),
        (lambda t, x, u: [x[0], x], "it returned 3"),
        (lambda t, x, u: None, "it returned None"),
        (lambda t, x: x, "must be a function of t, x, u or of t, x, u, m; got one of t, x"),
        (lambda t, x, u, m: [m.sinus(x[0]), u[0]], "no attribute 'sinus'"),
        (ca.Function("f", [ca.SX.sym("x", 2)], [ca.SX(2, 1)]), r"function of t \(1, 1\), x \(2, 1\), u \(1, 1\)"),
        (3.0, "must be a function; got 3.0"),
    ],
)
def test_a_function_that_cannot_be_read_is_refused_with_the_reason(f, says):
    with pytest.raises(ValueError, match=rf"`OdePlant.of\(f=...\)` .*{says}"):
        OdePlant.of(f, STATES, INPUTS)
    assert math.isnan(float(ca.SX.sym("x")))  # CasADi is as it was


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ({"states": "i:A"}, r"states=...\)` must be a `Layout` or a tuple of `str`"),
        ({"inputs": ()}, r"inputs=...\)` must have a name for each number.*got none"),
        ({"outputs": ("theta",)}, "no 'theta'"),
        ({"h": lambda t, x: [x[0]]}, r"outputs=...\)` must name what h gives"),
        ({"h": lambda t, x: [x[0]], "outputs": ("y", "z")}, r"h=...\)` must return 2 numbers, for y, z"),
        ({"x0": [1.0]}, r"x0=...\)` must have shape \(2,\)"),
        ({"x0": [1.0, np.nan]}, "'omega' must be finite.*got nan"),
    ],
)
def test_a_port_that_does_not_fit_the_function_is_refused(more, says):
    given = {"states": STATES, "inputs": INPUTS} | more
    with pytest.raises((ValueError, LookupError), match=says):
        OdePlant.of(lambda t, x, u: [u[0], x[0]], **given)


def test_an_output_that_depends_on_an_input_is_an_algebraic_loop_and_refused():
    ode = open_loop(OdePlant.of(motor, STATES, INPUTS, p=NUMBERS))
    feedthrough = replace(ode, output=ca.vertcat(ode.x[0], ode.x[1] + ode.input_symbols))
    with pytest.raises(ValueError, match="an algebraic loop; 'omega' of 'plant' does"):
        OdePlant(feedthrough)
    with pytest.raises(ValueError, match="must declare in `inputs` which of its parameters drive it"):
        OdePlant(replace(ode, inputs=()))


def tanks(t, x, u, m):
    return [0.1 * u[0] - 0.2 * m.sqrt(x[0]), 0.2 * m.sqrt(x[0]) - 0.1 * m.sqrt(x[1])]


def stiff(t, x, u, m):
    return [-1e5 * (x[0] - m.cos(x[1])), -x[1] + 0.1 * x[0] * x[1] ** 2 + u[0]]


@pytest.mark.parametrize(("f", "x", "u"), [(tanks, (9.0, 0.01), (2.0,)), (stiff, (5.0, -3.0), (0.1,))])
def test_inputs_that_are_wanted_hold_and_the_states_follow_from_a_poor_guess(f, x, u):
    ode = open_loop(OdePlant.of(f, ("a:", "b:"), ("u:",), x0=x))
    point = operating_point(ode, {"u": u})
    assert tuple(point.u) == u
    other = root(lambda x: f(0.0, x, u, np), point.x * 1.1, tol=1e-13).x
    np.testing.assert_allclose(point.x, other, rtol=1e-10)  # of SciPy's own hybrid method


def test_a_wanted_input_is_checked_as_a_state_is():
    ode = open_loop(OdePlant.of(tanks, ("a:", "b:"), ("u:",)))
    with pytest.raises(ValueError, match="'u' must be 1 finite numbers; got 'on'"):
        operating_point(ode, {"u": "on"})


@pytest.mark.parametrize("f", heavy_but([pendulum, stiff], pendulum))
def test_the_samples_in_a_computer_are_those_of_an_implicit_solver(f):
    case = {"f": f, "states": ("a:", "b:"), "inputs": ("u:",), "outputs": ("a",), "x": (0.5, 0.1), "u": (0.1,)}
    case |= {"Q": (1, 1), "R": (1,), "period": 0.02, "x0": (0.3, 0.2), "kept": range(4), "balance": f is stiff}
    got = solve(case if f is stiff else case | {"x": (0.0, 0.0), "u": (0.0,)})
    u_0 = np.array(case["u"] if f is stiff else (0.0,))
    at = [np.array(case["x0"])]
    for k in range(3):
        u = u_0 - got["K"] @ (at[-1] - got["x"])
        run = solve_ivp(
            lambda t, x, u=u: f(t, x, u, np), (0.02 * k, 0.02 * k + 0.02), at[-1], "Radau", rtol=1e-9, atol=1e-11
        )
        at.append(run.y[:, -1])
    np.testing.assert_allclose(got["samples"], at, rtol=1e-6, atol=1e-8)  # the exam's bar


@pytest.mark.heavy
def test_a_plant_too_stiff_for_substeps_keeps_the_time_of_its_instants():
    def f(t, x, u, m):
        return [-1e5 * (x[0] - m.sin(t)), x[0] + u[0]]

    case = {"f": f, "states": ("a:", "b:"), "inputs": ("u:",), "outputs": ("a",), "x": (0.0, 0.0), "u": (0.0,)}
    got = solve(case | {"Q": (1, 1), "R": (1,), "period": 0.1, "x0": (0.0, 0.0), "kept": [0, 2]})
    # behind sin(t) by the fast mode's time constant, 1e-5 s
    assert abs(got["samples"][1, 0] - math.sin(0.2 - 1e-5)) < 1e-8


@block
class Bag:
    """Numbers that are named when it is made."""

    k: Scalar = parameter(unit="N/m")
    own: Layout = parameters()

    def __post_init__(self):
        object.__setattr__(self, "own", layout(c=("N s/m", 3.0), D=("", [[1.0, 2.0], [3.0, 4.0]])))


@block
class Holder:
    """Two of them."""

    bags: tuple[Bag, ...]


def test_numbers_that_are_named_when_a_block_is_made_are_lifted_by_their_own_names():
    lifted = lift(Holder((Bag(1.0), Bag(2.0))), "plant.")
    assert lifted.layout.names == tuple(f"plant.bags[{i}].{name}" for i in (0, 1) for name in ("k", "c", "D"))
    assert lifted.layout["plant.bags[1].c"].unit == "N s/m"
    np.testing.assert_array_equal(lifted.layout.default, [1.0, 3.0, 1.0, 3.0, 2.0, 4.0, 2.0, 3.0, 1.0, 3.0, 2.0, 4.0])
    own = lifted.block.bags[1].own
    assert isinstance(own, Signals)
    assert own.D.shape == (2, 2)
    assert ca.is_equal(ca.vec(own.D), lifted.symbols[-4:])
    assert "<td>k</td><td>1</td><td>N/m</td>" in Bag(1.0)._repr_html_()

"""An Ode: exact Jacobians, and a fingerprint of its equations alone."""

import os
import subprocess
import sys
from dataclasses import replace
from itertools import pairwise

import casadi as ca
import numpy as np
import pytest

from workbench.arms.dynamics import Dynamics
from workbench.arms.manipulator import FirstOrderLag, Friction, Manipulator
from workbench.arms.mechanics import Link, PlanarArm, paper_arm
from workbench.blocks.loop import open_loop
from workbench.blocks.signals import SineTorque
from workbench.core import Entry, Layout, Ode

RNG = np.random.default_rng(1)


def arm_ode() -> Ode:
    arm = PlanarArm((Link(1.2, 0.8, 0.4, 0.1, 0.05), Link(0.9, 0.6, 0.3, -0.05, 0.02)))
    plant = Manipulator(
        arm,
        q=[0.3, -0.8],
        qd=[1.0, -0.5],
        disturbance=SineTorque([1.0, 2.0], [3.0, 4.0]),
        friction=Friction([0.1, 0.2], [0.3, 0.4], 0.5),
        actuator=FirstOrderLag(0.1),
    )
    return open_loop(plant)


def oscillator(*, name="k", factor=1.0, power=1, unit="1/s^2", default=2.0) -> Ode:
    """x'' = -factor k x^power."""
    states = Layout((Entry("x", np.array(1.0), "m"), Entry("v", np.array(0.0), "m/s")))
    parameters = Layout((Entry(name, np.array(default), unit),))
    t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
    rates = {"x": x[1], "v": -factor * p * x[0] ** power}
    return Ode.of("oscillator", states, parameters, (t, x, p), rates, {"y": 2 * x[0]}, {"y": "m"})


def central_difference(f, x, direction):
    """The best of central differences over steps 1e-2 ... 1e-7, by Richardson's own error estimate."""
    steps = 10.0 ** -np.arange(2, 7.5, 0.5)
    values = [(f(x + h * direction) - f(x - h * direction)) / (2 * h) for h in steps]
    gaps = [np.abs(a - b).max() for a, b in pairwise(values)]
    best = int(np.argmin(gaps))
    return values[best + 1], gaps[best]


@pytest.mark.parametrize("run", range(3))
@pytest.mark.parametrize("which", ["A", "B", "Cy", "D"])
def test_the_jacobians_are_those_of_the_rate_and_outputs(which, run):
    ode = arm_ode()
    # outputs with a direct path from the input, so that D is not zero
    ode = replace(ode, output=ca.vertcat(ode.output[:2], ode.rate[2:4] * ode.input_symbols))
    t, x = 0.37, np.random.default_rng(run).uniform(-1, 1, ode.states.size)
    p = ode.parameters.default.copy()
    place = ode.parameters.slice("tau")
    p[place] = [3.0, -2.0]
    value = np.array(getattr(ode, which)(t, x, p))
    function = {"A": ode.f, "B": ode.f, "Cy": ode.h, "D": ode.h}[which]
    for column in range(value.shape[1]):
        if which in "A Cy":
            z, base = np.eye(len(x))[column], x
            wanted, gap = central_difference(lambda x: np.array(function(t, x, p)).ravel(), base, z)
        else:
            z = np.eye(len(p))[place][column]
            wanted, gap = central_difference(lambda p: np.array(function(t, x, p)).ravel(), p, z)
        # a central difference at its best step is good to about eps^(2/3) of |f| ~ 100: 4e-9
        np.testing.assert_allclose(value[:, column], wanted, rtol=1e-7, atol=1e-7)
        assert gap < 1e-6


def test_named_rates_and_outputs_come_back_by_name():
    ode = oscillator()
    np.testing.assert_array_equal(ode.rate_at(0.0, np.array([3.0, 4.0])), [4.0, -6.0])
    assert ode.outputs_at(0.0, np.array([3.0, 4.0])) == {"y": 6.0}
    np.testing.assert_array_equal(ode.rate_at(0.0, np.array([3.0, 4.0]), np.array([1.0])), [4.0, -3.0])


def test_a_rate_for_each_state_and_no_other_is_asked_for():
    ode = oscillator()
    with pytest.raises(LookupError, match="v"):
        Ode.of("half", ode.states, ode.parameters, (ode.t, ode.x, ode.p), {"x": ode.x[1]}, {})


def test_the_fingerprint_knows_operations_constants_names_and_units():
    ode = oscillator()
    assert len(ode.fingerprint) == 64
    others = [
        oscillator(factor=1.0000000000000002),
        oscillator(power=3),
        oscillator(name="stiffness"),
        oscillator(unit="N/m"),
        replace(ode, output=3 * ode.x[0]),
    ]
    assert len({ode.fingerprint, *(other.fingerprint for other in others)}) == 6


def test_the_fingerprint_knows_no_default_value():
    assert oscillator(default=5.0).fingerprint == oscillator().fingerprint
    light, heavy = (Manipulator(paper_arm(), q=[0.0, x]) for x in (0.1, 0.2))
    assert open_loop(light).fingerprint == open_loop(heavy).fingerprint


def test_the_fingerprint_knows_the_choice_of_an_option():
    down, up = (PlanarArm(paper_arm().links, zero=zero) for zero in ("down", "up"))
    prints = {open_loop(Manipulator(arm, q=[0.0, 0.0])).fingerprint for arm in (down, up)}
    assert len(prints) == 2


SCRIPT = """
from workbench.blocks.loop import open_loop
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import robot
print(open_loop(Manipulator(robot("planar-3r"), q=[0.0, 0.0, 0.0])).fingerprint)
"""


def test_the_fingerprint_is_the_same_in_every_process():
    prints = set()
    for seed in ("0", "123"):
        environment = {**os.environ, "PYTHONHASHSEED": seed}
        done = subprocess.run(
            [sys.executable, "-c", SCRIPT], capture_output=True, text=True, env=environment, check=True
        )
        prints.add(done.stdout.strip())
    assert len(prints) == 1
    assert len(prints.pop()) == 64


def test_a_notebook_shows_names_units_and_values():
    html = oscillator()._repr_html_()
    assert "<td>k</td>" in html
    assert "1/s^2" in html


def test_the_open_loop_of_an_arm_solves_its_equation_of_motion():
    arm = paper_arm()
    ode, dynamics = open_loop(Manipulator(arm, q=[0.0, 0.0])), Dynamics.of(arm)
    q, qd, tau = RNG.uniform(-2, 2, (3, 2))
    p = ode.parameters.pack({"tau": tau})[0]
    qdd = ode.rate_at(0.0, np.concatenate([q, qd]), p)[2:]
    M, C, G = dynamics.matrices(q, qd)
    # the residual of the equation itself; condition of M up to 34, terms up to 30
    np.testing.assert_allclose(M @ qdd + C @ qd + G, tau, atol=1e-12)


@pytest.mark.parametrize(
    ("point", "says"),
    [
        ((0.0, 1.0), r"`rate_at\(x=...\)` must have shape \(2,\), one number for each of the states; got \(\)"),
        ((0.0, np.ones((2, 3))), r"got \(2, 3\)"),
        ((0.0, "still"), r"`rate_at\(x=...\)` must be a vector of numbers; got 'still'"),
        (([0.0, 1.0], [1.0, 0.0]), r"`rate_at\(t=...\)` must be a finite number of seconds"),
        ((0.0, [1.0, 0.0], [2.0, 2.0]), r"`rate_at\(p=...\)` must have shape \(1,\), one number for each of the par"),
    ],
)
def test_a_point_of_the_wrong_shape_is_refused_and_never_filled_up(point, says):
    ode = oscillator()
    with pytest.raises(ValueError, match=says):
        ode.rate_at(*point)
    with pytest.raises(ValueError, match=says.replace("rate_at", "outputs_at")):
        ode.outputs_at(*point)


def test_a_row_of_packed_parameters_is_a_point_too():
    ode = oscillator()
    np.testing.assert_array_equal(ode.rate_at(0, [1.0, 0.0], ode.parameters.pack({"k": 3.0})), [0.0, -3.0])


X, K = ca.SX.sym("x", 2), ca.SX.sym("stray")


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"x": X[0]}, r"`Ode\(x=...\)` must have shape \(2, 1\), one number for each of its states; got \(1, 1\)"),
        ({"p": ca.SX.sym("p", 2)}, r"`Ode\(p=...\)` must have shape \(1, 1\), one number for each of its parameters"),
        ({"t": ca.SX.sym("t", 2)}, r"`Ode\(t=...\)` must have shape \(1, 1\), the time"),
        ({"rate": ca.SX(3, 1)}, r"`Ode\(rate=...\)` must have shape \(2, 1\)"),
        ({"output": ca.SX(0, 1)}, r"`Ode\(output=...\)` must have shape \(1, 1\), one number for each of its outputs"),
        ({"output": K}, r"`Ode\(output=...\)` must be of t, x, p alone, .* got the symbol 'stray' beside them"),
        ({"rate": ca.vertcat(K, 0)}, "got the symbol 'stray' beside them"),
        ({"x": 2 * X}, "must be plain symbols"),
        ({"x": ca.vertcat(K, K)}, "each with one place"),
        ({"states": ["x", "v"]}, r"`Ode\(states=...\)` must be a `Layout`; got \['x', 'v'\]"),
        ({"rate": "x"}, r"`Ode\(rate=...\)` must be a `SX`; got 'x'"),
    ],
)
def test_an_equation_that_does_not_suit_its_layouts_is_refused(change, says):
    with pytest.raises(ValueError, match=says):
        replace(oscillator(), **change)


def test_an_input_that_is_no_parameter_is_refused():
    with pytest.raises(LookupError, match="There is no 'tau'"):
        replace(oscillator(), inputs=("tau",))

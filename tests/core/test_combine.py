"""Quadratures and sensitivities carried along with an Ode."""

import casadi as ca
import numpy as np
import pytest

from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.blocks.loop import open_loop
from workbench.core import Entry, Layout, Ode, rk4, with_quadrature, with_sensitivity


def decay() -> Ode:
    """x' = -a x, x(0) = x0."""
    states, parameters = Layout((Entry("x", np.array(2.0)),)), Layout((Entry("a", np.array(0.7), "1/s"),))
    t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
    return Ode.of("decay", states, parameters, (t, x, p), {"x": -p * x}, {})


def run(ode: Ode, h: float, steps: int, p=None, x=None):
    F = rk4(ode, h).F
    x = ode.states.default if x is None else x
    for k in range(steps):
        x = F(k, x, ode.parameters.default if p is None else p, [])
    return np.array(x).ravel()


def test_a_quadrature_is_the_integral_of_its_integrand():
    ode = decay()
    more = with_quadrature(ode, {"energy": ode.x**2, "both": ca.vertcat(ode.x, ode.t)}, {"energy": "m^2 s"})
    end = more.states.unpack(run(more, 0.01, 100))
    assert more.states["energy"].unit == "m^2 s"
    # closed forms at t = 1; RK4's local error is about 0.01^5 a step
    np.testing.assert_allclose(end["energy"], 4 * (1 - np.exp(-1.4)) / 1.4, rtol=1e-9)
    np.testing.assert_allclose(end["both"], [2 * (1 - np.exp(-0.7)) / 0.7, 0.5], rtol=1e-9)
    np.testing.assert_allclose(end["x"], 2 * np.exp(-0.7), rtol=1e-9)


def test_a_sensitivity_of_a_decay_has_its_closed_form():
    more = with_sensitivity(decay(), ["a", "x"])
    S = more.states.unpack(run(more, 0.01, 100))["S"]
    np.testing.assert_allclose(S, [[-2 * np.exp(-0.7), np.exp(-0.7)]], rtol=1e-8)


def test_sensitivities_of_an_arms_trajectory_are_its_differences():
    ode = open_loop(Manipulator(paper_arm(), q=[1.0, -0.5], qd=[0.5, 1.0]))
    names = ["arm.links[1].mass", "arm.gravity", "tau", "q[1]", "qd"]
    more = with_sensitivity(ode, names)
    S = more.states.unpack(run(more, 0.01, 100))["S"]
    assert S.shape == (4, 7)

    def differences(place, of_state, h):
        ends = []
        for sign in (1, -1):
            x, p = ode.states.default.copy(), ode.parameters.default.copy()
            (x if of_state else p)[place] += sign * h
            ends.append(run(ode, 0.01, 100, p, x))
        return (ends[0] - ends[1]) / (2 * h)

    places = [(i, False) for name in names[:3] for i in ode.parameters.indices(name)]
    places += [(i, True) for name in names[3:] for i in ode.states.indices(name)]
    for column, (place, of_state) in enumerate(places):
        # RK4 on the sensitivity equation is the derivative of RK4; a central difference at h = 1e-5
        # is good to h^2 f''' ~ 1e-9 plus eps / h ~ 1e-11, on trajectories that stretch tenfold
        wanted = differences(place, of_state, 1e-5)
        np.testing.assert_allclose(S[:, column], wanted, rtol=1e-7, atol=1e-7)


@pytest.mark.parametrize(
    ("names", "error", "says"),
    [
        ([], ValueError, "at least one"),
        (["arm.gravty"], LookupError, "gravty"),
        (["qq[0]"], LookupError, "qq"),
    ],
)
def test_a_sensitivity_to_nothing_known_is_refused(names, error, says):
    ode = open_loop(Manipulator(paper_arm(), q=[1.0, -0.5]))
    with pytest.raises(error, match=says):
        with_sensitivity(ode, names)


def test_a_misspelt_parameter_is_answered_with_the_nearest():
    ode = open_loop(Manipulator(paper_arm(), q=[1.0, -0.5]))
    with pytest.raises(LookupError, match=r"Did you mean 'arm.gravity'\?"):
        with_sensitivity(ode, ["arm.gravty"])

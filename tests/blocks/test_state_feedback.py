"""State feedback about an operating point: the cart-pole of the control tutorials, upright."""

import casadi as ca
import control
import numpy as np
import pytest

from workbench.blocks.laws import StateFeedback
from workbench.blocks.loop import AbstractPlant, AbstractReference, ClosedLoop, LinearLaw, open_loop
from workbench.core import Layout, block, initial, layout, parameter, rk4
from workbench.design.linear import equilibria, linearize, operating_point
from workbench.design.riccati import lqg, lqr
from workbench.engine import simulate


@block
class CartPole(AbstractPlant):
    """A pole on a cart that a force pushes, phi from upright."""

    M: float = parameter(default=0.5, unit="kg")
    m: float = parameter(default=0.2, unit="kg")
    b: float = parameter(default=0.1, unit="N s/m")
    I: float = parameter(default=0.006, unit="kg m^2")
    l: float = parameter(default=0.3, unit="m")
    g: float = parameter(default=9.8, unit="m/s^2")
    p: float = initial(default=0.2, unit="m")
    v: float = initial(default=0.0, unit="m/s")
    phi: float = initial(default=0.1, unit="rad")
    omega: float = initial(default=0.0, unit="rad/s")
    seen: tuple[str, ...] = ("p", "v", "phi", "omega")
    inputs = layout(F="N")

    @property
    def outputs(self):
        return Layout(tuple(self.states[name] for name in self.seen))

    def rate(self, t, x, u):
        s, c = ca.sin(x.phi), ca.cos(x.phi)
        a11, a12, a22 = self.M + self.m, -self.m * self.l * c, self.I + self.m * self.l**2
        h1 = u.F - self.b * x.v - self.m * self.l * x.omega**2 * s
        h2 = self.m * self.g * self.l * s
        det = a11 * a22 - a12 * a12
        return {"p": x.v, "v": (a22 * h1 - a12 * h2) / det, "phi": x.omega, "omega": (a11 * h2 - a12 * h1) / det}


@block
class Place(AbstractReference):
    """Where the cart shall stand."""

    p: float = parameter(unit="m")
    gives = layout(p="m")

    def at(self, t):
        return {"p": self.p}


PLANT = CartPole()
UPRIGHT = linearize(open_loop(PLANT), 0.0, np.zeros(4), u=[0.0], at_rest=True)
Q, R = np.diag([5000.0, 0.0, 100.0, 0.0]), [[1.0]]


def regulator(**more):
    return StateFeedback.of(PLANT, lqr(UPRIGHT, Q, R).K, **more)


def test_the_gain_from_the_nonlinear_cart_pole_is_the_published_one():
    # Control Tutorials for MATLAB and Simulink, Inverted Pendulum, State-Space: K to four decimals
    np.testing.assert_allclose(regulator().K, [[-70.7107, -37.8345, 105.5298, 20.9238]], rtol=0, atol=5e-5)


@pytest.mark.parametrize("digital", [False, True])
def test_the_nonlinear_loop_balances(digital):
    loop = ClosedLoop(PLANT, controller=regulator())
    step = loop.digital(0.005).step() if digital else rk4(loop.ode(), 1e-3)
    run = simulate(step, until=8.0)
    assert np.abs(run["phi"]).max() < 0.2
    assert max(abs(run[name][0, -1].item()) for name in ("p", "v", "phi", "omega")) < 1e-9


@pytest.mark.parametrize("period", [None, 0.01])
def test_a_lqg_law_of_two_readings_balances_the_nonlinear_pole_about_any_place(period):
    plant = CartPole(seen=("p", "phi"), p=1.1, phi=0.05)
    model = linearize(open_loop(plant), 0.0, [1.0, 0.0, 0.0, 0.0], at_rest=True)
    design = lqg(model if period is None else control.c2d(model, period), Q, R, np.eye(4), 1e-3 * np.eye(2))
    loop = ClosedLoop(plant, controller=LinearLaw(design.controller, u0=[0.0], v0=[1.0, 0.0]))
    run = simulate(rk4(loop.ode(), 1e-3) if period is None else loop.digital(period).step(4), until=12.0)
    assert np.abs(run["phi"]).max() < 0.3
    assert [run[name][0, -1].item() for name in ("p", "phi", "F")] == pytest.approx([1.0, 0.0, 0.0], abs=1e-6)


def test_near_the_operating_point_the_loop_has_the_poles_of_the_design():
    ode = ClosedLoop(PLANT, controller=regulator()).ode()
    poles = np.linalg.eigvals(np.array(ode.A(0.0, np.zeros(4), ode.parameters.default)))
    wanted = np.sort_complex(lqr(UPRIGHT, Q, R).poles)
    np.testing.assert_allclose(np.sort_complex(poles), wanted, rtol=1e-9)  # four simple poles


def test_a_state_that_follows_goes_where_it_is_wanted():
    loop = ClosedLoop(PLANT, controller=regulator(follow=("p",)), reference=Place(0.5))
    assert loop.follows == ("p",)
    assert simulate(rk4(loop.ode(), 1e-3), until=10.0)["p"][0, -1] == pytest.approx(0.5, abs=1e-9)


def test_the_force_about_an_operating_point_is_that_of_the_point():
    law = StateFeedback.of(PLANT, [[1.0, 2.0, 3.0, 4.0]], x0=[1.0, 0.0, 0.0, 0.0], u0=[5.0])
    ode = ClosedLoop(PLANT, controller=law).ode()
    assert ode.outputs_at(0.0, [1.0, 0.0, 0.0, 0.0])["F"] == 5.0
    assert ode.outputs_at(0.0, [2.0, 1.0, 0.0, 0.0])["F"] == 5.0 - 1.0 - 2.0


def test_the_rest_points_of_a_cart_that_may_stand_anywhere_are_called_a_continuum():
    box = {"p": (-1.0, 1.0), "v": (-1.0, 1.0), "phi": (-0.5, 0.5), "omega": (-1.0, 1.0)}
    assert "continuum" in str(equilibria(open_loop(PLANT), box, starts=8))
    point = operating_point(open_loop(PLANT), {"p": 0.3, "phi": 0.0})
    np.testing.assert_allclose([*point.x, *point.u], [0.3, 0, 0, 0, 0], atol=1e-15)


@pytest.mark.parametrize(
    ("make", "error", "message"),
    [
        (
            lambda: StateFeedback.of(PLANT, np.zeros((1, 3))),
            ValueError,
            r"`StateFeedback.of\(K=...\)` must have shape \(1, 4\)",
        ),
        (lambda: StateFeedback.of(PLANT, np.full((1, 4), np.nan)), ValueError, "matrix of finite numbers; got nan"),
        (lambda: StateFeedback.of(PLANT, np.zeros((1, 4)), x0=[1.0]), ValueError, r"x0=...\)` must have shape \(4,\)"),
        (
            lambda: StateFeedback.of(PLANT, np.zeros((1, 4)), u0=[1.0, 2.0]),
            ValueError,
            r"u0=...\)` must have shape \(1,\)",
        ),
        (
            lambda: StateFeedback.of(PLANT, np.zeros((1, 4)), follow=("x",)),
            LookupError,
            "There is no 'x' among the 4 states",
        ),
    ],
)
def test_what_is_no_gain_of_the_plant_is_refused(make, error, message):
    with pytest.raises(error, match=message):
        make()

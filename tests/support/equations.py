"""Small equations with closed forms, for tests."""

from dataclasses import replace

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Ode, StepMap
from workbench.core.numbers import Bounds


def oscillator() -> Ode:
    """q'' = -omega^2 q from (1, 0), watched as a loop of one joint would be: q = cos(omega t), reference 0."""
    states = Layout((Entry("plant.q", np.ones(1), "rad"), Entry("plant.qd", np.zeros(1), "rad/s")))
    parameters = Layout((Entry("omega", np.array(2.0), "rad/s", Bounds(0, np.inf, strict=True)),))
    t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
    rates = {"plant.q": x[1], "plant.qd": -(p**2) * x[0]}
    outputs = {"q": x[0], "e": x[0], "q_ref": ca.SX(0), "tau_applied": x[1]}
    return Ode.of("oscillator", states, parameters, (t, x, p), rates, outputs)


def decay(rate: float = 3.0, start: float = 1.0) -> Ode:
    """x' = -rate x from `start`, with x as its error."""
    states = Layout((Entry("x", np.array([start])),))
    parameters = Layout((Entry("rate", np.array(rate)),))
    t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
    return Ode.of("decay", states, parameters, (t, x, p), {"x": -p * x}, {"e": x})


def explosion() -> Ode:
    """x' = x^2 from x(0), which is 1 unless given: infinite at t = 1 / x(0)."""
    states = Layout((Entry("x", np.ones(1)),))
    t, x, p = ca.SX.sym("t"), states.symbols(), ca.SX(0, 1)
    return Ode.of("explosion", states, Layout(), (t, x, p), {"x": x**2}, {"e": x})


def staircase(q: ca.SX, levels: tuple[float, ...], hold: float) -> Ode:
    """No dynamics at all: q(t) is the given expression of time, the reference steps through `levels`."""
    states = Layout((Entry("clock", np.zeros(1)),))
    t, x = ca.SX.sym("t"), states.symbols()
    wanted = ca.SX(levels[0])
    for i, level in enumerate(levels[1:], start=1):
        wanted = ca.if_else(t >= i * hold - 1e-9, level, wanted)
    actual = ca.substitute(q, ca.symvar(q)[0], t)
    outputs = {"q": actual, "q_ref": wanted, "e": actual - wanted}
    return Ode.of("staircase", states, Layout(), (t, x, ca.SX(0, 1)), {"clock": ca.SX(1)}, outputs)


def turning(speed: float) -> Ode:
    """An angle that grows at `speed` from 0, and the integral of its sine, which stays bounded."""
    states = Layout((Entry("angle", np.zeros(1), "rad"), Entry("x", np.zeros(1))))
    t, x = ca.SX.sym("t"), states.symbols()
    rates = {"angle": ca.SX(speed), "x": ca.sin(x[0])}
    return Ode.of("turning", states, Layout(), (t, x, ca.SX(0, 1)), rates, {"e": x[1]})


def root() -> Ode:
    """x' = sqrt(x) from 0, where its Jacobian is infinite."""
    states = Layout((Entry("x", np.zeros(1)),))
    t, x = ca.SX.sym("t"), states.symbols()
    return Ode.of("root", states, Layout(), (t, x, ca.SX(0, 1)), {"x": ca.sqrt(x)}, {"e": x})


def with_next(step: StepMap, after: ca.SX) -> StepMap:
    """The step with another x+, in the symbols of its rule."""
    return replace(step, rule=replace(step.rule, rate=ca.SX(0, 1), update=after))

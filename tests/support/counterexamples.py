"""Equations and claims that a search breaks, and the worst run that it finds."""

from functools import cache

import casadi as ca

from workbench.core import Claim, Entry, Layout, Ode
from workbench.core.claim import BlockClaim
from workbench.core.numbers import Bounds
from workbench.proofs.falsify import Budget, RunSearch


def decay() -> Ode:
    """x' = -a x + b sin(t): with x(0) and b in a box the largest x is at a corner."""
    states = Layout((Entry("x", 1.0),))
    parameters = Layout((Entry("a", 1.0, bounds=Bounds(low=0)), Entry("b", 0.0)))
    t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
    return Ode.of("decay", states, parameters, (t, x, p), {"x": -p[0] * x + p[1] * ca.sin(t)}, {"e": x, "b": p[1]})


def blow_up() -> Ode:
    """x' = x^2 from x(0) = x0: it escapes at t = 1 / x0."""
    states, none = Layout((Entry("x", 0.0),)), Layout()
    t, x = ca.SX.sym("t"), states.symbols()
    return Ode.of("escape", states, none, (t, x, ca.SX(0, 1)), {"x": x**2}, {"e": x})


ODE = decay()


RANGES = {"x": (-2.0, 2.0), "b": (-1.0, 1.0)}


def late(limit: float) -> BlockClaim:
    def margin(y):
        return ca.if_else(y["t"] < 1.999, 9.0, limit - y["x"])

    return BlockClaim(Claim("x ends small", f"x(2) <= {limit}", "by hand", (), margin))


HUNT = RunSearch(ODE, late(0.0), RANGES, 2.0, 0.01)


@cache
def worst_run():
    """The worst run of the decay for a claim that it breaks."""
    return HUNT.search(1, Budget(8, 3, 1)).worst

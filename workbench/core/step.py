"""Step: x+ = F(k, x, p, w), y = h(k, x, p, w): all that a simulator knows."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import casadi as ca

from workbench.core.layout import Layout
from workbench.core.numbers import seconds
from workbench.core.ode import Ode
from workbench.core.sockets import require

# The amplification of RK4 on x' = lambda x: R(z) = 1 + z + z^2/2 + z^3/6 + z^4/24, highest power first.
RK4_AMPLIFICATION = (1 / 24, 1 / 6, 1 / 2, 1.0, 1.0)


@dataclass(frozen=True, eq=False)
class Rule:
    """x+ and y of a step of any length, as expressions in its symbols: what steps that differ in length share.

    Attributes
    ----------
    h, k, x, p, w
        Symbols: the length (1, 1) in s, the number of the step (1, 1), the state (nx, 1), the parameters (np, 1),
        and standard normal numbers (nw, 1), fresh ones at every step of every run.
    next
        x+, (nx, 1).
    output
        y, (ny, 1): what holds from t_k on.
    """

    h: ca.SX
    k: ca.SX
    x: ca.SX
    p: ca.SX
    w: ca.SX
    next: ca.SX
    output: ca.SX

    @cached_property
    def F(self) -> ca.Function:
        """x+ as a CasADi function (h, k, x, p, w) -> (nx, 1)."""
        symbols = [self.h, self.k, self.x, self.p, self.w]
        return ca.Function("workbench_rule", symbols, [ca.densify(self.next)])


@dataclass(frozen=True, eq=False)
class Step:
    """One step of length h of a recursion with named states, parameters and outputs.

    Attributes
    ----------
    h
        The step's length in s: t_k = k h.
    rule
        x+ and y as expressions.
    flow, amplification, substeps
        The differential equation that the step approximates, the polynomial R(z) by which a substep of
        h / `substeps` multiplies a mode exp(lambda t), with z = lambda h / `substeps`: what the stability
        limit is made of.
    """

    h: float
    states: Layout
    parameters: Layout
    outputs: Layout
    rule: Rule
    flow: Ode
    amplification: tuple[float, ...]
    substeps: int = 1

    def __repr__(self) -> str:
        """One line: a notebook should not print the equations by accident."""
        noise = f", {self.noises} normal numbers" if self.noises else ""
        return f"<Step of '{self.flow.name}': h = {self.h:g} s, {self.states.size} states{noise}>"

    @property
    def noises(self) -> int:
        """How many normal numbers it takes, nw."""
        return int(self.rule.w.numel())

    @property
    def operations(self) -> int:
        """How many operations CasADi makes of it: what it costs."""
        return int(self.rule.F.n_instructions())

    @cached_property
    def F(self) -> ca.Function:
        """The step as a CasADi function (k, x, p, w) -> (nx, 1)."""
        return self._function("workbench_step", ca.densify(self.rule.next), cse=False)

    @cached_property
    def y(self) -> ca.Function:
        """The outputs as a CasADi function (k, x, p, w) -> (ny, 1)."""
        return self._function("workbench_output", self.rule.output, cse=True)

    def _function(self, name: str, value: ca.SX, cse: bool) -> ca.Function:
        rule = self.rule
        value = ca.substitute(value, rule.h, self.h)
        return ca.Function(name, [rule.k, rule.x, rule.p, rule.w], [value], {"cse": cse})

    def extended(self, extra: Layout, symbols: ca.SX, update: ca.SX) -> Step:
        """The same step with memory z that is updated beside it: z+ = update(h, k, x, z, p, w)."""
        rule = self.rule
        rule = replace(rule, x=ca.vertcat(rule.x, symbols), next=ca.vertcat(rule.next, update))
        return replace(self, states=self.states + extra, rule=rule)


def rk4(ode: Ode, h: float) -> Step:
    """The classical fourth-order Runge-Kutta step of length h [s] for `ode`.

    Raises
    ------
    ValueError
        If `ode` is no `Ode`, or h is not a positive finite number.

    References
    ----------
    Hairer, Norsett and Wanner (1993), Solving Ordinary Differential Equations I, section II.1.
    """
    require("rk4(ode=...)", ode, Ode, ": a loop becomes one by its method `ode()`" if hasattr(ode, "ode") else "")
    layouts = (ode.states, ode.parameters, ode.outputs)
    return Step(seconds("rk4(h=...)", h), *layouts, _rk4(ode), ode, RK4_AMPLIFICATION)


@lru_cache(maxsize=64)
def _rk4(ode: Ode) -> Rule:
    """The rule of the steps for one equation, of whatever length."""
    f = ca.Function("f", [ode.t, ode.x, ode.p], [ode.rate])
    h, k = ca.SX.sym("h"), ca.SX.sym("k")
    t = k * h
    after = runge_kutta(f, t, ode.x, ode.p, h)
    return Rule(h, k, ode.x, ode.p, ca.SX(0, 1), after, ca.substitute(ode.output, ode.t, t))


def runge_kutta(f: ca.Function, t: ca.SX, x: ca.SX, p: ca.SX, h: ca.SX | float) -> ca.SX:
    """x(t + h) from x(t) by the classical Runge-Kutta method, for x' = f(t, x, p)."""
    k1 = f(t, x, p)
    k2 = f(t + h / 2, x + h / 2 * k1, p)
    k3 = f(t + h / 2, x + h / 2 * k2, p)
    k4 = f(t + h, x + h * k3, p)
    return x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)

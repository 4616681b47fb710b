"""Step: x+ = F(k, x, p, w), y = h(k, x, p, w): all that a simulator knows."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import ClassVar

import casadi as ca

from workbench.core.layout import Layout
from workbench.core.ode import Ode
from workbench.core.rule import RK4_AMPLIFICATION, Rule
from workbench.validation.doors import door
from workbench.validation.words import require, seconds, whole


@dataclass(frozen=True, eq=False)
@door
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

    WAYS: ClassVar = {
        "Ode": "wrap it in `rk4(ode, h)`",
        "Sampled": "take its `step(substeps)`",
        "ClosedLoop": "take `rk4(loop.ode(), h)`, or `loop.digital(period).step()`",
    }

    def __post_init__(self) -> None:
        seconds("Step(h=...)", self.h)
        whole("Step(substeps=...)", self.substeps)

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
        """About how many operations one step takes: what it costs."""
        return self.rule.operations

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
        value = ca.substitute(value, ca.vertcat(rule.t, rule.h), ca.vertcat(rule.k * self.h, self.h))
        return ca.Function(name, [rule.k, rule.x, rule.p, rule.w], [value], {"cse": cse})

    @door
    def extended(self, extra: Layout, symbols: ca.SX, update: ca.SX) -> Step:
        """The same step with memory z that is updated beside it: z+ = update(h, k, t, x, z, p, w)."""
        return replace(self, states=self.states + extra, rule=self.rule.extended(symbols, update))


def rk4(ode: Ode, h: float) -> Step:
    """The classical fourth-order Runge-Kutta step of length h [s] for `ode`.

    Raises
    ------
    ValueError
        If `ode` is no `Ode`, or h is not a positive finite number.

    References
    ----------
    Hairer, Norsett and Wanner (1993), Solving Ordinary Differential Equations I, section II.1.

    Examples
    --------
    >>> step = wb.rk4(wb.open_loop(wb.DCMotor()), 1e-3)
    >>> step.h, step.states.names
    (0.001, ('omega', 'i'))
    """
    ode, h = checked("rk4", ode, h)
    return Step(h, ode.states, ode.parameters, ode.outputs, _rk4(ode), ode, RK4_AMPLIFICATION)


def checked(call: str, ode: object, h: object) -> tuple[Ode, float]:
    """An equation and the length of a step in s."""
    return require(f"{call}(ode=...)", ode, Ode), seconds(f"{call}(h=...)", h)


@lru_cache(maxsize=64)
def _rk4(ode: Ode) -> Rule:
    """The rule of the steps for one equation, of whatever length."""
    h, k = ca.SX.sym("h"), ca.SX.sym("k")
    return Rule(h, k, ode.t, ode.x, ode.p, ca.SX(0, 1), ode.rate, ca.SX(0, 1), ode.output)

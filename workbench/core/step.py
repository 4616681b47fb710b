"""Step: x+ = F(k, x, p, w), y = h(k, x, p, w): all that a simulator knows."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import casadi as ca
import numpy as np

from workbench.core.layout import Layout, numbers
from workbench.core.ode import Ode
from workbench.core.sockets import require

# The amplification of RK4 on x' = lambda x: R(z) = 1 + z + z^2/2 + z^3/6 + z^4/24, highest power first.
RK4_AMPLIFICATION = (1 / 24, 1 / 6, 1 / 2, 1.0, 1.0)


@dataclass(frozen=True, eq=False)
class Step:
    """One step of length h of a recursion with named states, parameters and outputs.

    Attributes
    ----------
    h
        The step's length in s: t_k = k h.
    next
        x+ as an expression (nx, 1) in the symbols k (1, 1), x (nx, 1), p (np, 1), w (nw, 1).
    output
        y as an expression (ny, 1) in the same symbols: what holds from t_k on.
    w
        Standard normal numbers, fresh ones at every step of every run; none where nothing is noisy.
    flow, amplification, substeps
        The differential equation that the step approximates, the polynomial R(z) by which a substep of
        h / `substeps` multiplies a mode exp(lambda t), with z = lambda h / `substeps`: what the stability
        limit is made of.
    """

    h: float
    states: Layout
    parameters: Layout
    outputs: Layout
    k: ca.SX
    x: ca.SX
    p: ca.SX
    next: ca.SX
    output: ca.SX
    flow: Ode
    amplification: tuple[float, ...]
    w: ca.SX = field(default_factory=lambda: ca.SX(0, 1))
    substeps: int = 1

    def __repr__(self) -> str:
        """One line: a notebook should not print the equations by accident."""
        noise = f", {self.w.numel()} normal numbers" if self.w.numel() else ""
        return f"<Step of '{self.flow.name}': h = {self.h:g} s, {self.states.size} states{noise}>"

    @cached_property
    def F(self) -> ca.Function:
        """The step as a CasADi function (k, x, p, w) -> (nx, 1)."""
        return ca.Function("workbench_step", [self.k, self.x, self.p, self.w], [ca.densify(self.next)])

    @cached_property
    def y(self) -> ca.Function:
        """The outputs as a CasADi function (k, x, p, w) -> (ny, 1)."""
        return ca.Function("workbench_output", [self.k, self.x, self.p, self.w], [self.output], {"cse": True})

    def extended(self, extra: Layout, symbols: ca.SX, update: ca.SX) -> Step:
        """The same step with memory z that is updated beside it: z+ = update(k, x, z, p, w)."""
        return replace(
            self,
            states=self.states + extra,
            x=ca.vertcat(self.x, symbols),
            next=ca.vertcat(self.next, update),
        )


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
    h = length("rk4(h=...)", h)
    f = ca.Function("f", [ode.t, ode.x, ode.p], [ode.rate])
    k = ca.SX.sym("k")
    t, x, p = k * h, ode.x, ode.p
    y = ca.substitute(ode.output, ode.t, t)
    return Step(
        h,
        ode.states,
        ode.parameters,
        ode.outputs,
        k,
        x,
        p,
        runge_kutta(f, t, x, p, h),
        y,
        ode,
        RK4_AMPLIFICATION,
    )


def runge_kutta(f: ca.Function, t: ca.SX, x: ca.SX, p: ca.SX, h: float) -> ca.SX:
    """x(t + h) from x(t) by the classical Runge-Kutta method, for x' = f(t, x, p)."""
    k1 = f(t, x, p)
    k2 = f(t + h / 2, x + h / 2 * k1, p)
    k3 = f(t + h / 2, x + h / 2 * k2, p)
    k4 = f(t + h, x + h * k3, p)
    return x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def length(call: str, h: object) -> float:
    """A step's length, or a sampling period, in s; what is none is refused in the name of `call`."""
    try:
        seconds = numbers(h)
    except (TypeError, ValueError):
        seconds = np.zeros(0)
    if seconds.shape != () or isinstance(h, bool):
        raise ValueError(f"`{call}` must be a number of seconds; got {h!r}.")
    if not np.finfo(float).tiny <= seconds < np.inf:
        raise ValueError(
            f"`{call}` must be a positive, finite number of seconds; got {seconds:g}"
            + (", which a float does not hold to full accuracy." if seconds > 0 and np.isfinite(seconds) else ".")
        )
    return float(seconds)

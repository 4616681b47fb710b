"""Rule: what a step of any length makes of a state: a Runge-Kutta step of some entries, an update of the others."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeVar

import casadi as ca

from workbench.core.symbols import refuse_misfit, refuse_unknown
from workbench.validation.doors import door

Held = TypeVar("Held")  # what an equation is given beside its state, the same at each stage

# The classical fourth-order Runge-Kutta method: its nodes c_j; by how much of h k_j the next stage is ahead of x;
# and the weights of k_j in x+, in parts of DIVISOR.
NODES = (0.0, 0.5, 0.5, 1.0)
AHEAD = (0.5, 0.5, 1.0, 0.0)
WEIGHTS = (1.0, 2.0, 2.0, 1.0)
DIVISOR = 6.0
# Its amplification on x' = lambda x: R(z) = 1 + z + z^2/2 + z^3/6 + z^4/24, highest power first.
RK4_AMPLIFICATION = (1 / 24, 1 / 6, 1 / 2, 1.0, 1.0)


@dataclass(frozen=True, eq=False)
@door
class Rule:
    """x+ and y of a step of any length, as expressions in its symbols: what steps that differ in length share.

    Attributes
    ----------
    h, k, t, x, p, w
        Symbols: the length (1, 1) in s, the number of the step (1, 1), the time k h (1, 1) in s, the state (nx, 1),
        the parameters (np, 1), and standard normal numbers (nw, 1), fresh ones at every step of every run.
    rate
        (n, 1): dx/dt of the first n entries in t, x and p, which take a classical Runge-Kutta step; n may be 0.
    update
        (nx - n, 1): what the other entries become, in all the symbols; the rate knows none of them.
    output
        y, (ny, 1), in h, k, t, x and p: what holds from t_k on.

    Raises
    ------
    ValueError
        If rate and update together are not as many as the entries of x.
    """

    h: ca.SX
    k: ca.SX
    t: ca.SX
    x: ca.SX
    p: ca.SX
    w: ca.SX
    rate: ca.SX
    update: ca.SX
    output: ca.SX

    def __post_init__(self) -> None:
        for name in ("h", "k", "t"):
            refuse_misfit("Rule", name, getattr(self, name), 1, 1)
        for name in ("x", "p", "w", "rate", "update", "output"):
            refuse_misfit("Rule", name, getattr(self, name), getattr(self, name).numel(), 1, "a column")
        symbols = {name: getattr(self, name) for name in ("h", "k", "t", "x", "p", "w")}
        refuse_unknown("Rule", symbols, rate=self.rate, update=self.update, output=self.output)
        if self.rate.numel() + self.update.numel() != self.x.numel():
            raise ValueError(
                f"`Rule(rate=..., update=...)` must together have one entry for each of the {self.x.numel()} states; "
                f"got {self.rate.numel()} and {self.update.numel()}."
            )

    @cached_property
    def parts(self) -> ca.Function:
        """Rate and update as a CasADi function (h, k, t, x, p, w) -> (n, 1), (nx - n, 1)."""
        symbols = [self.h, self.k, self.t, self.x, self.p, self.w]
        return ca.Function("workbench_parts", symbols, [ca.densify(self.rate), ca.densify(self.update)])

    @cached_property
    def next(self) -> ca.SX:
        """x+, (nx, 1), in h, k, x, p and w."""
        n, t = self.rate.numel(), self.k * self.h
        update = ca.substitute(self.update, self.t, t)
        if not n:
            return update
        f = ca.Function("f", [self.t, self.x[:n], self.p], [self.rate])
        return ca.vertcat(runge_kutta(f, t, self.x[:n], self.p, self.h), update)

    @cached_property
    def F(self) -> ca.Function:
        """x+ as a CasADi function (h, k, x, p, w) -> (nx, 1)."""
        symbols = [self.h, self.k, self.x, self.p, self.w]
        return ca.Function("workbench_rule", symbols, [ca.densify(self.next)])

    @property
    def operations(self) -> int:
        """About how many operations a step takes."""
        return int(self.parts.n_instructions()) * (len(NODES) if self.rate.numel() else 1)

    @property
    def written_out(self) -> Rule:
        """The same rule with every stage of its Runge-Kutta step as a part of one update."""
        return replace(self, rate=ca.SX(0, 1), update=self.next)

    @door
    def extended(self, symbols: ca.SX, update: ca.SX) -> Rule:
        """The same rule with entries z behind those of x, which become update(h, k, t, x, z, p, w)."""
        refuse_misfit("Rule.extended", "symbols", symbols, symbols.numel(), 1, "a column")
        refuse_misfit("Rule.extended", "update", update, symbols.numel(), 1, "one entry for each symbol")
        return replace(self, x=ca.vertcat(self.x, symbols), update=ca.vertcat(self.update, update))


def runge_kutta(f: Callable[[ca.SX, ca.SX, Held], ca.SX], t: ca.SX, x: ca.SX, p: Held, h: ca.SX | float) -> ca.SX:
    """x(t + h) from x(t) by the classical Runge-Kutta method, for x' = f(t, x, p)."""
    stage, total = x, ca.SX(0)
    for node, ahead, weight in zip(NODES, AHEAD, WEIGHTS, strict=True):
        rate = f(t + node * h, stage, p)
        stage, total = x + ahead * h * rate, total + weight * rate
    return x + h / DIVISOR * total

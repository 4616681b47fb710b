"""StepMap: x+ = F(k, x, p, w), y = h(k, x, p, w), all that a simulator knows; its `StepRule` serves any length."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import ClassVar

import casadi as ca

from workbench.core.bounded_loop import operation_count
from workbench.core.crossing import Crossing, refuse_strangers, without_crossings
from workbench.core.expressions import refuse_misfit
from workbench.core.layout import Layout
from workbench.core.methods import METHODS, RK4, Method, runge_kutta
from workbench.core.ode import Ode
from workbench.core.segments import Segments
from workbench.core.state_corners import corners_of
from workbench.core.validation.refusals import Array, one_of, require, seconds, whole
from workbench.core.validation.signatures import check_arguments


@dataclass(frozen=True, eq=False)
@check_arguments
class StepRule:
    """x+ and y of a step of any length, as expressions in its symbols.

    The rate is dx/dt of the first n entries, which take a Runge-Kutta step; n may be 0. The update is the
    next value of the other entries; the rate knows none of them. y holds from t_k on. Update and y may have symbols of
    `crossings`, as what a computer makes of its readings has; the rate may not. Where a switch lies within a step, the
    first entries are what the segments make instead.

    Raises
    ------
    ValueError
        If rate and update together are not as many as the entries of x.
    """

    h: ca.SX  # symbol of the length in s, (1, 1)
    k: ca.SX  # of the number of the step, (1, 1)
    t: ca.SX  # of the time k h in s, (1, 1)
    x: ca.SX  # of the state, (nx, 1)
    p: ca.SX  # of the parameters, (np, 1)
    w: ca.SX  # of standard normal numbers, (nw, 1), fresh ones at every step of every run
    rate: ca.SX  # (n, 1), in t, m, x and p
    update: ca.SX  # (nx - n, 1), in all the symbols
    output: ca.SX  # y, (ny, 1), in h, k, t, x and p
    crossings: tuple[Crossing, ...] = ()  # in the order in which their values are made
    m: ca.SX = field(default_factory=lambda: ca.SX.sym("m"))  # of the middle of the step in s, (1, 1)
    segments: Segments | None = None  # None where no switch is known
    method: Method = RK4  # by which the first entries move
    d: ca.SX = field(default_factory=lambda: ca.SX(0, 1))  # of recorded numbers, (nd, 1), another row at each step

    def __post_init__(self) -> None:
        for name in ("h", "k", "t"):
            refuse_misfit("StepRule", name, getattr(self, name), 1, 1)
        for name in ("x", "p", "w", "d", "rate", "update", "output"):
            refuse_misfit("StepRule", name, getattr(self, name), getattr(self, name).numel(), 1, "a column")
        symbols = {name: getattr(self, name) for name in ("h", "k", "t", "x", "p", "w", "m", "d")}
        refuse_strangers("StepRule", symbols, (), rate=self.rate)
        refuse_strangers("StepRule", symbols, self.crossings, update=self.update, output=self.output)
        if self.rate.numel() + self.update.numel() != self.x.numel():
            raise ValueError(
                f"`StepRule(rate=..., update=...)` must together have one entry for each of the {self.x.numel()} "
                f"states; got {self.rate.numel()} and {self.update.numel()}."
            )

    @property
    def symbols(self) -> list[ca.SX]:
        """The symbols h, k, t, x, p, w, v of the crossings, (nv, 1), m and d."""
        v = ca.vertcat(ca.SX(0, 1), *(crossing.symbols for crossing in self.crossings))
        return [self.h, self.k, self.t, self.x, self.p, self.w, v, self.m, self.d]

    @cached_property
    def parts(self) -> ca.Function:
        """Rate, update and values of the crossings as a CasADi function (h, k, t, x, p, w, v, m, d) of `symbols`."""
        values = [self.rate, self.update, *(crossing.values for crossing in self.crossings)]
        return ca.Function("workbench_parts", self.symbols, [ca.densify(value) for value in values])

    @cached_property
    def segment_parts(self) -> ca.Function | None:
        """The parts of its segments as a CasADi function of `symbols` and s, if it has any."""
        if self.segments is None:
            return None
        ends = [] if self.segments.e is None else [self.segments.e]
        return ca.Function("workbench_segments", [*self.symbols, self.segments.s, *ends], self.segments.parts)

    @cached_property
    def next(self) -> ca.SX:
        """x+, (nx, 1), in h, k, x, p, w and d, of a step within which there is no switch."""
        return ca.substitute(self.without_crossings(self._next), self.t, self.k * self.h)

    @cached_property
    def _next(self) -> ca.SX:
        """x+, (nx, 1), in h, k, x, p, w, d and the symbols of the crossings."""
        n, t = self.rate.numel(), self.k * self.h
        update = ca.substitute(self.update, self.t, t)
        if not n:
            return update
        constants = ca.vertcat(self.p, self.d)
        f = held_at(t + self.h / 2, self.m, self.t, self.x[:n], constants, self.rate)
        return ca.vertcat(runge_kutta(f, t, self.x[:n], constants, self.h, self.method), update)

    @check_arguments
    def without_crossings(self, expression: ca.SX) -> ca.SX:
        """An expression with the values of the crossings in the place of their symbols, as for derivatives."""
        return without_crossings(self.crossings, expression)

    @cached_property
    def F(self) -> ca.Function:
        """`next` as a CasADi function (h, k, x, p, w) -> (nx, 1); of a recorded step (h, k, x, p, w, d)."""
        symbols = [self.h, self.k, self.x, self.p, *self.drives]
        return ca.Function("workbench_rule", symbols, [ca.densify(self.next)])

    @property
    def drives(self) -> list[ca.SX]:
        """The symbols of the numbers that are new at each step: w, and d if there are recorded numbers."""
        return [self.w, self.d] if self.d.numel() else [self.w]

    @cached_property
    def operations(self) -> int:
        """The number of operations of a step, roughly."""
        return operation_count(self.parts) * self._stages

    @cached_property
    def written_operations(self) -> int:
        """The number of operations of a step in which each loop is passed once, roughly: the size of its code."""
        return operation_count(self.parts, of_passes=False) * self._stages

    @property
    def _stages(self) -> int:
        return len(self.method.nodes) if self.rate.numel() else 1

    @property
    def written_out(self) -> StepRule:
        """The same rule as one update that contains every stage of its Runge-Kutta step."""
        return replace(self, rate=ca.SX(0, 1), update=self._next, segments=None)

    @check_arguments
    def with_memory(self, symbols: ca.SX, update: ca.SX) -> StepRule:
        """The same rule with entries z behind those of x: z+ = update(h, k, t, x, z, p, w)."""
        refuse_misfit("StepRule.with_memory", "symbols", symbols, symbols.numel(), 1, "a column")
        refuse_misfit("StepRule.with_memory", "update", update, symbols.numel(), 1, "one entry for each symbol")
        return replace(self, x=ca.vertcat(self.x, symbols), update=ca.vertcat(self.update, update))


@dataclass(frozen=True, eq=False)
@check_arguments
class StepMap:
    """One step of length h [s] of a recursion with named states, parameters and outputs: t_k = k h.

    `flow` is the differential equation that the step approximates, and `amplification` the polynomial R(z), highest
    power first, by which a substep of h / `substeps` multiplies a mode exp(lambda t), with z = lambda h / `substeps`.
    """

    h: float
    states: Layout
    parameters: Layout
    outputs: Layout
    rule: StepRule
    flow: Ode
    amplification: tuple[float, ...]
    substeps: int = 1
    finer: Callable[[], StepMap] | None = None  # the same span in twice the substeps, where these are written out
    recorded_numbers: Array | None = None  # (N, nd), the numbers d of each of the N steps of a recorded step

    WAYS: ClassVar = {
        "Ode": "wrap it in `rk4(ode, h)`",
        "SampledSystem": "take its `step(substeps)`; `simulate(sampled, until=...)` chooses the substeps",
        "ClosedLoop": "take `rk4(loop.ode(), h)`, or `loop.digital(period).step(substeps)`; "
        "`simulate(loop, until=...)` chooses the step",
    }

    def __post_init__(self) -> None:
        seconds("StepMap(h=...)", self.h)
        whole("StepMap(substeps=...)", self.substeps)
        nd, rows = self.rule.d.numel(), self.recorded_numbers
        if (nd > 0) != (rows is not None) or (rows is not None and (rows.ndim != 2 or rows.shape[1] != nd)):
            got = "none" if rows is None else f"an array of shape {rows.shape}"
            raise ValueError(
                f"`StepMap(recorded_numbers=...)` must have {nd or 'no'} columns, as its rule has; got {got}."
            )

    def __repr__(self) -> str:
        noise = f", {self.noises} normal numbers" if self.noises else ""
        return f"<Step of '{self.flow.name}': h = {self.h:g} s, {self.states.size} states{noise}>"

    @property
    def noises(self) -> int:
        """The number of normal numbers it takes, nw."""
        return int(self.rule.w.numel())

    @property
    def operations(self) -> int:
        """The number of operations of one step, roughly."""
        return self.rule.operations

    @property
    def half_step(self) -> StepMap | None:
        """The step that moves the flow by half the length, for the states of the flow; None where none is known."""
        if self.finer is not None:
            return self.finer()
        n = self.rule.rate.numel()
        return replace(self, h=self.h / 2) if n and n == self.flow.states.size else None

    @cached_property
    def F(self) -> ca.Function:
        """The step as a CasADi function (k, x, p, w) -> (nx, 1); of a recorded step (k, x, p, w, d)."""
        return self._function("workbench_step", ca.densify(self.rule.next), cse=False)

    @cached_property
    def y(self) -> ca.Function:
        """The outputs as a CasADi function (k, x, p, w) -> (ny, 1); of a recorded step (k, x, p, w, d)."""
        return self._function("workbench_output", self.rule.output, cse=True)

    def _function(self, name: str, value: ca.SX, cse: bool) -> ca.Function:
        rule = self.rule
        value = ca.substitute(
            rule.without_crossings(value), ca.vertcat(rule.t, rule.h), ca.vertcat(rule.k * self.h, self.h)
        )
        return ca.Function(name, [rule.k, rule.x, rule.p, *rule.drives], [value], {"cse": cse})

    @check_arguments
    def with_memory(self, extra: Layout, symbols: ca.SX, update: ca.SX) -> StepMap:
        """The same step with memory z that is updated beside it: z+ = update(h, k, t, x, z, p, w)."""
        return replace(self, states=self.states + extra, rule=self.rule.with_memory(symbols, update))


def rk4(ode: Ode, h: float) -> StepMap:
    """The classical fourth-order Runge-Kutta step of length h [s] for an `Ode`, as a `StepMap`.

    Raises
    ------
    ValueError
        If `ode` is not an `Ode`, or h is not a positive finite number.

    References
    ----------
    Hairer, Norsett and Wanner (1993), Solving Ordinary Differential Equations I, section II.1.

    Examples
    --------
    >>> step = wb.rk4(wb.open_loop(wb.DCMotor()), 1e-3)
    >>> step.h, step.states.names
    (0.001, ('omega', 'i'))
    """
    ode = require("rk4(ode=...)", ode, Ode)
    return _step(ode, seconds("rk4(h=...)", h), RK4)


@check_arguments
def runge_kutta_step(ode: Ode, h: float, method: str = "rk4") -> StepMap:
    """A Runge-Kutta step of length h [s] for an `Ode`, as a `StepMap`.

    Parameters
    ----------
    ode
        The equations.
    h
        The length of the step in s.
    method
        "rk4" for the classical method; "stabilised" for a method of third order that stays stable for steps about twice
        as long; "restarted" for the classical method, restarted at corners of the rate within a step.

    Raises
    ------
    ValueError
        If there is no such method, or h is not a positive finite number.

    Examples
    --------
    >>> wb.runge_kutta_step(wb.open_loop(wb.DCMotor()), 1e-3, "stabilised")
    <Step of 'plant': h = 0.001 s, 2 states>
    """
    one_of("runge_kutta_step(method=...)", method, METHODS)
    return _step(ode, seconds("runge_kutta_step(h=...)", h), METHODS[method])


def _step(ode: Ode, h: float, method: Method) -> StepMap:
    return StepMap(h, ode.states, ode.parameters, ode.outputs, _rule(ode, method), ode, method.amplification)


@lru_cache(maxsize=64)
def _rule(ode: Ode, method: Method) -> StepRule:
    h, k, switches = ca.SX.sym("h"), ca.SX.sym("k"), ode.switches
    rule = StepRule(h, k, ode.t, ode.x, ode.p, ca.SX(0, 1), ode.rate, ca.SX(0, 1), ode.output, method=method)
    corners = corners_of(ode) if method.corners else None
    if not switches.has_instants and corners is None:
        return rule
    segments = Segments.of(switches, k * h, h, ode.x, ode.x, corners=corners)
    return replace(rule, rate=switches.rate, m=switches.m, segments=segments)


def held_at(
    middle: ca.SX, m: ca.SX, t: ca.SX, x: ca.SX, p: ca.SX, rate: ca.SX
) -> Callable[[ca.SX, ca.SX, ca.SX], ca.SX]:
    """A rate in t, m, x and p as a function of (t, x, p), with the middle of the step in the place of m."""
    f = ca.Function("f", [t, x, p, m], [rate])
    return lambda time, state, parameters: f(time, state, parameters, middle)

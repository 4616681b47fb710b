"""Piece: a switched rate while no side changes, as one smooth differential equation with guards at its ends."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from workbench.core.expressions import memory
from workbench.core.validation.refusals import Array
from workbench.engine.reference.surfaces import SwitchedRate

# The distance from zero to which rounding may take a value, in units of its terms' sizes.
ROUNDING = 64 * np.finfo(float).eps
SAMPLES = 8  # instants of a step at which the guards are looked at
# A staircase names its next step when the state is this far beyond the last: no simple fraction, at which another
# surface may lie.
TURN = 0.7182818


class Numeric:
    """A CasADi function of (t, x) on arrays, through buffers that two threads must not share."""

    def __init__(self, function: ca.Function) -> None:
        arguments = [ca.MX.sym("a", *function.size_in(i)) for i in range(2)]
        dense = ca.Function(function.name(), arguments, [ca.densify(function(*arguments))])
        self.shape = dense.size_out(0)
        self.arguments = [np.zeros(dense.numel_in(i)) for i in range(2)]
        self.result = np.zeros(dense.numel_out(0))
        # held by this object, as what runs the buffer does not keep it alive
        buffer, self.run = dense.buffer()
        # the stubs of both ask for a size, which CasADi takes from the memory
        hand_in: Callable[..., None] = buffer.set_arg
        take: Callable[..., None] = buffer.set_res
        for i, place in enumerate(self.arguments):
            hand_in(i, memory(place))
        take(0, memory(self.result))
        self.buffer = buffer

    def __call__(self, t: float | Array, x: Array) -> Array:
        """The value at (t, x)."""
        self.arguments[0][:] = np.ravel(t)
        self.arguments[1][:] = np.ravel(x, order="F")
        self.run()
        return self.result.reshape(self.shape, order="F").copy()


@dataclass(frozen=True)
class SwitchingMode:
    """The side of each surface, 1 or -1, or 0 where the state slides on it; and the levels of staircases."""

    sides: tuple[int, ...]
    levels: tuple[float, ...]

    @property
    def sliding_surfaces(self) -> tuple[int, ...]:
        """The surfaces on which the state slides."""
        return tuple(k for k, side in enumerate(self.sides) if side == 0)


@dataclass(frozen=True, eq=False)
class Guard:
    """A function that is positive within a piece, with its surface, and the side on which it ends the piece."""

    surface: int
    kind: str  # "cross", "leave" or "turn"
    side: int
    value: ca.SX


@dataclass(frozen=True, eq=False)
class SmoothPiece:
    """The smooth rate x' = f(t, x) while no side changes, with its constraints and guards.

    On the surfaces in sliding the sides u solve d sigma / dt = 0 (d^2 sigma / dt^2 = 0 where no side enters the first
    derivative): Utkin's equivalent control. The constraints are zero there: sigma, and d sigma / dt where no side
    enters it.
    """

    mode: SwitchingMode
    t: ca.SX
    x: ca.SX
    rate: ca.SX  # f, (nx, 1)
    sides: ca.SX  # u on the surfaces in sliding, (k, 1)
    gains: ca.SX  # (k, k), by which u enters the derivatives that it makes zero
    push: ca.SX  # df/du, (nx, k): where a side that switches drives the state
    constraints: ca.SX
    guards: tuple[Guard, ...]

    @staticmethod
    def of(switched_rate: SwitchedRate, mode: SwitchingMode) -> SmoothPiece:
        """The piece of a mode; a ValueError says why it has none, as no equivalent control."""
        t, x, free = switched_rate.t, switched_rate.x, switched_rate.symbols(mode.sliding_surfaces)
        rate, sigma = _rate_of_mode(switched_rate, mode)
        names = switched_rate.names(mode.sliding_surfaces)
        on = ca.vertcat(ca.SX(0, 1), *[sigma[k] for k in mode.sliding_surfaces])
        push = ca.jacobian(rate, free)
        if ca.depends_on(ca.vertcat(on, ca.vec(push)), free):
            raise ValueError(f"the rate is not affine in the sides of {names}, so that Utkin's and Filippov's differ")
        constraints, found = [on], []
        for k in range(on.numel()):
            row = derivative(on[k], t, x, rate)
            if not ca.depends_on(row, free):
                constraints.append(row)
                row = derivative(row, t, x, rate)
            if not ca.depends_on(row, free):
                raise ValueError(f"no side enters the first two derivatives of {names}")
            found.append(row)
        rows = ca.vertcat(ca.SX(0, 1), *found)
        gains = ca.densify(ca.jacobian(rows, free))
        zero = ca.SX.zeros(free.numel())
        sides = -ca.solve(gains, ca.substitute(rows, free, zero)) if mode.sliding_surfaces else zero
        rate, sigma = ca.substitute([rate, sigma], [free], [sides])
        guards = _guards(switched_rate, mode, sigma, sides)
        return SmoothPiece(mode, t, x, rate, sides, gains, push, ca.vertcat(*constraints), guards)

    @property
    def second_order(self) -> bool:
        """True if some d sigma / dt is zero by itself, and not by a side."""
        return bool(self.constraints.numel() > self.sides.numel())

    @cached_property
    def values(self) -> ca.SX:
        """The guards, (m, 1)."""
        return ca.vertcat(ca.SX(0, 1), *[guard.value for guard in self.guards])

    @cached_property
    def curved_guards(self) -> ca.SX:
        """The guards not affine in t and x, and their rates, (nz, 2), which are integrated beside the state."""
        z = ca.vertcat(self.t, self.x)
        guards = [guard.value for guard in self.guards]
        g = ca.vertcat(ca.SX(0, 1), *[g for g in guards if ca.depends_on(ca.jacobian(g, z), z)])
        return ca.horzcat(g, derivative(g, self.t, self.x, self.rate))

    @cached_property
    def companions(self) -> Numeric:
        """`curved` as a function of (t, x)."""
        return self._function("companions", self.curved_guards)

    def with_companions(self, t: float, x: Array) -> Array:
        """The state and its companions, [x; z]."""
        return np.concatenate([x, self.companions(t, x)[:, 0]])

    @cached_property
    def field(self) -> Numeric:
        """The rate of the state and its companions, (t, [x; z]) -> (nx + nz, 1)."""
        both, y = self._both()
        return Numeric(ca.Function("field", [self.t, y], [both], {"cse": True}))

    @cached_property
    def jacobian(self) -> Numeric:
        """The exact Jacobian of the field."""
        both, y = self._both()
        return Numeric(ca.Function("jacobian", [self.t, y], [ca.jacobian(both, y)], {"cse": True}))

    def _both(self) -> tuple[ca.SX, ca.SX]:
        z = ca.SX.sym("z", self.curved_guards.shape[0])
        return ca.vertcat(self.rate, self.curved_guards[:, 1]), ca.vertcat(self.x, z)

    @cached_property
    def watch(self) -> Numeric:
        """The guards and their rates, each followed by how far rounding may take it from zero: (t, x) -> (m, 4)."""
        return self._function("watch", self._guard_values())

    def _guard_values(self) -> ca.SX:
        g = self.values
        first = derivative(g, self.t, self.x, self.rate)
        # the terms of a rate may cancel, as they do where a side in sliding is left: its noise is that of the terms
        return ca.horzcat(g, self._noise(g), first, ca.fmax(self._noise(g, self.rate, 1.0), self._noise(first)))

    @cached_property
    def samples(self) -> Numeric:
        """`watch` at `SAMPLES` instants side by side: (1, s), (nx, s) -> (m, 4 s)."""
        return Numeric(ca.Function("watch", [self.t, self.x], [self._guard_values()], {"cse": True}).map(SAMPLES))

    @cached_property
    def bend(self) -> Numeric:
        """The second derivatives of the guards in time and their noise: (t, x) -> (m, 2)."""
        first = derivative(self.values, self.t, self.x, self.rate)
        second = derivative(first, self.t, self.x, self.rate)
        return self._function("bend", ca.horzcat(second, self._noise(first, self.rate, 1.0)))

    @cached_property
    def hold(self) -> Numeric:
        """The constraints, their Jacobian, and their noise: (t, x) -> (k, 1 + nx + 1)."""
        c = self.constraints
        return self._function("hold", ca.horzcat(c, ca.jacobian(c, self.x), self._noise(c)))

    @cached_property
    def settle(self) -> Numeric:
        """The correction along the push, (t, x) -> (nx, 1), that brings d sigma / dt back to zero."""
        across = ca.jacobian(self.constraints, self.x) @ self.push
        return self._function("settle", -self.push @ ca.pinv(across) @ self.constraints)

    @cached_property
    def drive(self) -> Numeric:
        """The push as a function, (t, x) -> (nx, k)."""
        return self._function("drive", self.push)

    @cached_property
    def control(self) -> Numeric:
        """The sides in sliding and their gains, (t, x) -> (k, 1 + k)."""
        return self._function("control", ca.horzcat(self.sides, self.gains))

    def _noise(self, g: ca.SX, x: ca.SX | None = None, t: ca.SX | float | None = None) -> ca.SX:
        x, t = (self.x if x is None else x), (self.t if t is None else t)
        sizes = ca.fabs(ca.jacobian(g, self.x)) @ ca.fabs(x) + ca.fabs(ca.jacobian(g, self.t)) * ca.fabs(t)
        return ROUNDING * sizes

    def _function(self, name: str, value: ca.SX) -> Numeric:
        return Numeric(ca.Function(name, [self.t, self.x], [value], {"cse": True}))


def derivative(g: ca.SX, t: ca.SX, x: ca.SX, rate: ca.SX) -> ca.SX:
    """dg/dt along x' = rate."""
    return ca.jacobian(g, t) + ca.jacobian(g, x) @ rate


def _rate_of_mode(switched_rate: SwitchedRate, mode: SwitchingMode) -> tuple[ca.SX, ca.SX]:
    """The rate and all sigma with the sides of a mode; those in sliding stay symbols, with no corner."""
    old, new = [], []
    for surface, side, level in zip(switched_rate.surfaces, mode.sides, mode.levels, strict=True):
        old.append(surface.corner)
        new.append(ca.SX(side))
        if side:
            old.append(surface.side)
            new.append(ca.SX(side))
        if surface.level is not None:
            old.append(surface.level)
            new.append(ca.SX(level))
    sigma = ca.vertcat(ca.SX(0, 1), *[surface.sigma for surface in switched_rate.surfaces])
    if not old:
        return switched_rate.rate, sigma
    rate, sigma = ca.substitute([switched_rate.rate, sigma], [ca.vertcat(*old)], [ca.vertcat(*new)])
    return rate, sigma


def _guards(switched_rate: SwitchedRate, mode: SwitchingMode, sigma: ca.SX, sides: ca.SX) -> tuple[Guard, ...]:
    guards: list[Guard] = []
    for k, side in enumerate(mode.sides):
        if side:
            guards.append(Guard(k, "cross", -side, side * sigma[k]))
            if switched_rate.surfaces[k].level is not None:
                guards.append(Guard(k, "turn", side, TURN - side * sigma[k]))
    for u, k in zip(ca.vertsplit(sides) if mode.sliding_surfaces else [], mode.sliding_surfaces, strict=True):
        guards += [Guard(k, "leave", 1, 1 - u), Guard(k, "leave", -1, 1 + u)]
    still = [guard for guard in guards if not ca.symvar(guard.value)]
    for guard in still:
        if not float(guard.value) > 0:
            raise ValueError(f"nothing keeps the state on that side of {switched_rate.surfaces[guard.surface].name}")
    return tuple(guard for guard in guards if guard not in still)

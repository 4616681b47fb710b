"""Switching surfaces: where a rate jumps or bends, each with a symbol for the side that the state is on."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from workbench.core import Ode
from workbench.core.expressions import evaluate_sx
from workbench.core.notation.program import NAMES
from workbench.core.validation.refusals import Array

REFUSED_OPERATIONS = (ca.OP_EQ, ca.OP_NE, ca.OP_FMOD, ca.OP_REMAINDER, ca.OP_COPYSIGN)
ROOTS = (ca.OP_SQRT, ca.OP_POW, ca.OP_CONSTPOW)
SMALLEST = float(np.finfo(float).tiny)
LONGEST = 60  # how much of an expression a message shows


@dataclass(frozen=True, eq=False)
class SwitchingSurface:
    """One surface sigma(t, x) = 0, where `side` and `corner` stand for sign(sigma).

    A rate that has the symbol `side` jumps, and the state may slide on the surface; one that has `corner` only bends
    (|sigma| = corner sigma), and a corner is free to be 0 on the surface itself. For a step of a staircase floor(a) =
    level - 1/2 + side/2 with sigma = a - level.
    """

    sigma: ca.SX  # in t, x, and the sides of surfaces before it
    side: ca.SX
    corner: ca.SX
    level: ca.SX | None
    jumps: bool

    @property
    def name(self) -> str:
        """The switching function as text."""
        text = str(self.sigma)
        text = text if len(text) <= LONGEST else text.rpartition(", ")[2]  # without what CasADi abbreviates in it
        return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."


@dataclass(frozen=True, eq=False)
class SwitchedRate:
    """A rate (nx, 1) in t, x and the sides of its surfaces: smooth while no side changes."""

    name: str
    t: ca.SX
    x: ca.SX
    rate: ca.SX
    surfaces: tuple[SwitchingSurface, ...]

    @staticmethod
    def of(ode: Ode, p: Array) -> SwitchedRate:
        """The rate of an `Ode` at the parameters p (np,); a ValueError names an operation that switches and has no
        surface.
        """
        reader = _Reader(ode.name)
        rate = reader.read(ca.Function("f", [ode.t, ode.x], [ca.substitute(ode.rate, ode.p, p)], {"cse": True}), ode)
        surfaces = tuple(SwitchingSurface(*parts, k in reader.jump_surfaces) for k, parts in enumerate(reader.surfaces))
        return SwitchedRate(ode.name, ode.t, ode.x, rate, surfaces)

    def names(self, which: Iterable[int]) -> str:
        """The switching functions of some surfaces, in order."""
        return ", ".join(self.surfaces[k].name for k in sorted(which))

    def symbols(self, which: Sequence[int]) -> ca.SX:
        """The sides of some surfaces, (k, 1)."""
        return ca.vertcat(ca.SX(0, 1), *[self.surfaces[k].side for k in which])


class _Reader:
    """The collector of the surfaces of a rate, each one once, while the rate is built again."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.surfaces: list[tuple[ca.SX, ca.SX, ca.SX, ca.SX | None]] = []
        self.jump_surfaces: set[int] = set()
        self.places: dict[object, tuple[int, int]] = {}
        self.truths: dict[int, ca.SX] = {}  # values that are 0 or 1; held, so that no other takes their key
        self.sizes: dict[int, ca.SX] = {}  # values that are |sigma|
        self.corners: set[int] = set()  # symbols of corners

    def read(self, function: ca.Function, ode: Ode) -> ca.SX:
        inputs, rate = (ode.t, ode.x), ca.SX.zeros(ode.states.size)
        results = evaluate_sx(function, lambda part, entry: inputs[part][entry], ca.SX, self._operation)
        for place, part in results[0].items():
            rate[function.sparsity_out(0).row(place)] = part
        return rate

    def _operation(self, code: int, *a: ca.SX) -> ca.SX:
        if code == ca.OP_CALL:
            raise self._refusal("a function that it calls, such as a table")
        if all(part.is_constant() for part in a) and code != ca.OP_IF_ELSE_ZERO:
            return _plain(code, *a)
        match code:
            case ca.OP_SIGN:
                return self._side(a[0])
            case ca.OP_FABS:
                return self._keep(self.sizes, self._corner(a[0]) * a[0])
            case ca.OP_FMAX if any(self._is_above_floor(*pair) for pair in (a, a[::-1])):
                return a[0] if self._is_above_floor(*a) else a[1]
            case ca.OP_FMIN | ca.OP_FMAX:
                w = self._corner(a[0] - a[1]) if code == ca.OP_FMAX else -self._corner(a[0] - a[1])
                return a[0] * (1 + w) / 2 + a[1] * (1 - w) / 2
            case ca.OP_FLOOR:
                return self._floor(a[0])
            case ca.OP_CEIL:
                return -self._floor(-a[0])
            case ca.OP_LT | ca.OP_LE:
                return self._true((1 - self._side(a[0] - a[1])) / 2)
            case ca.OP_NOT:
                return self._true(1 - self._truth(a[0]))
            case ca.OP_AND:
                return self._true(self._truth(a[0]) * self._truth(a[1]))
            case ca.OP_OR:
                return self._true(1 - (1 - self._truth(a[0])) * (1 - self._truth(a[1])))
            case ca.OP_IF_ELSE_ZERO:
                return self._truth(a[0]) * a[1]
        if code in REFUSED_OPERATIONS:
            raise self._refusal(NAMES[code].lower())
        if code in ROOTS and self._bends(a[0]):
            # beyond its surface a root of |sigma| has no smooth continuation: its mirror image is at least real
            return _plain(code, ca.fabs(a[0]), *a[1:])
        return _plain(code, *a)

    def _is_above_floor(self, a: ca.SX, floor: ca.SX) -> bool:
        """True if max(a, floor) equals a: a size |sigma| with a floor that only bounds the slope of its root."""
        return a.__hash__() in self.sizes and floor.is_constant() and float(floor) <= SMALLEST

    def _bends(self, a: ca.SX) -> bool:
        return any(symbol.__hash__() in self.corners for symbol in ca.symvar(a))

    def _side(self, a: ca.SX) -> ca.SX:
        if a.is_constant():
            return ca.sign(a)
        place, sign = self._surface(a)
        self.jump_surfaces.add(place)
        return sign * self.surfaces[place][1]

    def _corner(self, a: ca.SX) -> ca.SX:
        if a.is_constant():
            return ca.sign(a)
        place, sign = self._surface(a)
        return sign * self.surfaces[place][2]

    def _floor(self, a: ca.SX) -> ca.SX:
        place, sign = self._surface(a, ca.SX.sym(f"level{len(self.surfaces)}"))
        self.jump_surfaces.add(place)
        _, side, _, level = self.surfaces[place]
        assert level is not None
        return level - 0.5 + sign * side / 2

    def _surface(self, a: ca.SX, level: ca.SX | None = None) -> tuple[int, int]:
        """The place of the surface a = 0, and the sign with which a is its switching function."""
        sign, key = (1, ("floor", a.__hash__())) if level is not None else _orientation(a)
        if key not in self.places:
            k = len(self.surfaces)
            self.places[key] = k, sign
            side, corner = ca.SX.sym(f"side{k}"), ca.SX.sym(f"corner{k}")
            self.corners.add(corner.__hash__())
            self.surfaces.append((a if level is None else a - level, side, corner, level))
        place, first = self.places[key]
        return place, sign * first

    def _true(self, a: ca.SX) -> ca.SX:
        return self._keep(self.truths, a)

    def _keep(self, among: dict[int, ca.SX], a: ca.SX) -> ca.SX:
        among[a.__hash__()] = a
        return a

    def _truth(self, a: ca.SX) -> ca.SX:
        if a.is_constant():
            return ca.SX(float(a) != 0)
        if a.__hash__() not in self.truths:
            raise self._refusal("if_else of a number")
        return a

    def _refusal(self, what: str) -> ValueError:
        return ValueError(
            f"`reference(ode=...)` finds the surfaces of sign, fabs, fmin, fmax, floor, ceil, <, <= and if_else; "
            f"'{self.name}' switches by '{what}', which has none. Write it with one of these."
        )


def _plain(code: int, *a: ca.SX) -> ca.SX:
    if code == ca.OP_ASSIGN:
        return a[0]
    return ca.SX.unary(code, *a) if len(a) == 1 else ca.SX.binary(code, *a)


def _orientation(a: ca.SX, sign: int = 1) -> tuple[int, object]:
    """The sign and a key of a switching function that -a, 2 a and b - a, a - b have in common."""
    if a.is_op(ca.OP_NEG):
        return _orientation(a.dep(0), -sign)
    if a.is_op(ca.OP_TWICE):
        return _orientation(a.dep(0), sign)
    if a.is_op(ca.OP_MUL) and a.dep(0).is_constant() and float(a.dep(0)) != 0:
        return _orientation(a.dep(1), sign if float(a.dep(0)) > 0 else -sign)
    if a.is_op(ca.OP_SUB):
        first, second = _key(a.dep(0)), _key(a.dep(1))
        return (sign, ("difference", first, second)) if first <= second else (-sign, ("difference", second, first))
    return sign, ("value", _key(a))


def _key(a: ca.SX) -> tuple[str, float]:
    return ("constant", float(a)) if a.is_constant() else ("node", a.__hash__())

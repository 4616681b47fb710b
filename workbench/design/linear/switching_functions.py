"""Corners of an equation: the switching functions that are zero at a point, and the Jacobians on their sides.

On a corner, as of |s|, a clip or a comparison, an exact derivative is that of no piece: CasADi returns a mean. So the
Jacobians are taken a little off the point, on each side of all that switches there.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from workbench.core import Ode
from workbench.core.expressions import call_again, evaluate_sx
from workbench.core.notation.program import NAMES
from workbench.core.validation.refusals import Array, describe, finite, known_name
from workbench.design.linear.loop_switches import CORNERS, LOOKS, LoopSwitches
from workbench.design.linear.operating_point import LATEST, inputs_of, jacobians, places_of
from workbench.design.linear.side_directions import side_directions, switching_text

REACH = 4e-12  # how far off the point a side is looked at, relative: beyond its rounding, near enough for curvature
FARTHER = 1e3  # times that: what differs by a corner is there as large, what bends smoothly much larger
STAYS = 0.3  # the share of a difference that must be there already at the nearer distance
ROUNDING = 1e-12  # of the largest entry of row and column
LEAST = 1e-3  # of what a switching function might change by in a direction, if that is to count as off its zero
Sides = str | Mapping[str, float] | None
Mask = NDArray[np.bool_]
UsedEntries = Callable[[Mask], Mask]
At = tuple[float, Array, Array]  # t, x and p


@dataclass(frozen=True, eq=False)
class CornerSide:
    """One side of all corners at a point: its `signs`, a `direction` to it, and values there, near and farther off."""

    signs: tuple[int, ...]
    direction: Array
    near: Array
    far: Array


@dataclass(frozen=True, eq=False)
class SwitchingFunctions:
    """The switching functions (m, 1) of the rates and outputs of an `Ode`, with their texts.

    Those of the passes of loops are many: `at` a point are the few among them that may be zero there.
    """

    ode: Ode
    texts: tuple[str, ...]
    sigma: ca.SX
    of_loops: LoopSwitches | None = None

    @staticmethod
    @lru_cache(maxsize=LATEST)
    def of(ode: Ode) -> SwitchingFunctions:
        """The switching functions that depend on states or inputs."""
        z = ca.vertcat(ode.x, ode.input_symbols)
        function = ca.Function("both", [ode.t, ode.x, ode.p], [ca.vertcat(ode.rate, ode.output)], {"cse": True})
        symbols, texts, sigma = (ode.t, ode.x, ode.p), [], []

        def operation(code: int, *a: ca.SX) -> ca.SX:
            if code in CORNERS:
                zero = a if len(a) == 1 or code == ca.OP_COPYSIGN else (a[0] - a[1],)
                for switching in (part for part in zero if ca.depends_on(part, z)):
                    texts.append(switching_text(NAMES[code], a))
                    sigma.append(switching)
            if code == ca.OP_ASSIGN:
                return a[0]
            return ca.SX.unary(code, *a) if len(a) == 1 else ca.SX.binary(code, *a)

        if any(function.instruction_id(k) in CORNERS for k in range(function.n_instructions())):
            evaluate_sx(function, lambda part, entry: symbols[part][entry], ca.SX, operation, call_again)
        return SwitchingFunctions(ode, tuple(texts), ca.vertcat(ca.SX(0, 1), *sigma), LoopSwitches.of(ode))

    def at(self, t: float, x: Array, p: Array) -> SwitchingFunctions:
        """The switching functions with those of loops that may be zero at a point or beside it."""
        inner = self.of_loops
        if inner is None:
            return self
        reach = REACH * (1 + np.abs(np.concatenate([x, p[places_of(self.ode)]])))
        ways = [sign * np.cos(k * np.arange(1.0, len(reach) + 1)) for k in range(1, LOOKS + 1) for sign in (1, -1)]
        points = [self.shift_arguments(t, x, p, way * reach) for way in (np.zeros(len(reach)), *ways)]
        if not (places := inner.near(points, reach)):
            return self
        texts = (*self.texts, *(inner.texts[i] for i in places))
        return SwitchingFunctions(self.ode, texts, ca.vertcat(self.sigma, inner.sigma[places]))

    @cached_property
    def functions(self) -> tuple[ca.Function, ca.Function, ca.Function]:
        """sigma with its derivatives by x, u and t (m, 1 + nz + 1), the Jacobian of rates and outputs, sigma alone."""
        ode = self.ode
        z, both = ca.vertcat(ode.x, ode.input_symbols), ca.vertcat(ode.rate, ode.output)
        arguments = [ode.t, ode.x, ode.p]
        sides = ca.densify(ca.horzcat(self.sigma, ca.jacobian(self.sigma, ca.vertcat(z, ode.t))))
        named = {"sides": sides, "J": ca.densify(ca.jacobian(both, z)), "sigma": ca.densify(self.sigma)}
        of_sides, of_both, alone = (ca.Function(name, arguments, [value]) for name, value in named.items())
        return of_sides, of_both, alone

    @property
    def labels(self) -> tuple[str, ...]:
        """The names of the numbers of x and u."""
        return (*self.ode.states.labels, *inputs_of(self.ode).labels)

    def jacobian(self, t: float, x: Array, p: Array, direction: Array | None = None) -> Array:
        """The Jacobian (nx + ny, nx + nu) of rates and outputs at a point, or off it."""
        return np.array(self.functions[1](*self.shift_arguments(t, x, p, direction)))

    def shift_arguments(self, t: float, x: Array, p: Array, direction: Array | None) -> At:
        """The arguments of a function at a point, or off it by a direction in x and u."""
        if direction is None:
            return t, x, p
        row = p.copy()
        row[places_of(self.ode)] += direction[len(x) :]
        return t, x + direction[: len(x)], row

    def pieces(self, t: float, x: Array, p: Array) -> list[CornerSide]:
        """The pieces that meet at a point, with their Jacobians; empty if the point lies on no corner."""
        if not self.texts:
            return []
        reach = REACH * (1 + np.abs(np.concatenate([x, p[places_of(self.ode)]])))
        value, slope, _ = np.split(np.array(self.functions[0](t, x, p)), [1, -1], axis=1)
        size = np.abs(slope) @ reach
        active = np.asarray(np.isfinite(size)) & np.asarray(np.abs(value[:, 0]) <= size)
        if not active.any():
            return []
        found: dict[tuple[int, ...], CornerSide] = {}
        for direction in side_directions(slope[active] * reach):
            step = direction * reach
            signs = self.signs(t, x, p, step, active, size)
            if signs is not None and signs not in found:
                near, far = (self.jacobian(t, x, p, step * scale) for scale in (1, FARTHER))
                found[signs] = CornerSide(signs, step, near, far)
        return list(found.values())

    def signs(self, t: float, x: Array, p: Array, step: Array, active: Array, size: Array) -> tuple[int, ...] | None:
        """The signs of all switching functions a step off, 0 for those that are not active; None along a corner."""
        value = np.array(self.functions[2](*self.shift_arguments(t, x, p, step)))[:, 0]
        along = active & np.asarray(size > 0) & ~np.asarray(np.abs(value) > LEAST * size)
        return None if along.any() else tuple(np.where(active, np.sign(value), 0).astype(int).tolist())


def corner_entries(pieces: Sequence[CornerSide]) -> Mask:
    """True for each entry that differs between pieces by a corner, and not by rounding or by a smooth bend."""
    near, far = (np.ptp([getattr(piece, name) for piece in pieces], axis=0) for name in ("near", "far"))
    return np.asarray(~(near <= rounding_errors(pieces)) & ~(near < STAYS * far))


def anywhere(pieces: Sequence[CornerSide]) -> Mask:
    """True for each entry that is not zero on some piece."""
    return np.asarray(np.any([piece.near != 0 for piece in pieces], axis=0))


def all_entries(pattern: Mask) -> Mask:
    """True for each entry: an answer that is the Jacobians themselves depends on all of them."""
    return np.ones(pattern.shape, dtype=bool)


def rounding_errors(pieces: Sequence[CornerSide]) -> Array:
    """The largest rounding error of each entry of the Jacobians of pieces."""
    size = np.max([np.abs(piece.near) for piece in pieces], axis=0)
    return np.asarray(ROUNDING * (size.max(axis=1, keepdims=True) + size.max(axis=0, keepdims=True)))


def side_direction(call: str, corners: SwitchingFunctions, side: Sides, x: Array, u: Array) -> Array | None:
    """The direction in x and u from which a point is approached, (nx + nu,), scaled to the reach of a side."""
    if side is None:
        return None
    if isinstance(side, str) and side in ("above", "below"):
        weights = np.full(len(x) + len(u), 1.0 if side == "above" else -1.0)
    elif isinstance(side, Mapping) and side:
        weights = np.zeros(len(x) + len(u))
        for name, value in side.items():
            weights[_places(corners.ode, name)] = finite(f"{call}(side=...)", value)
    else:
        must = "'above', 'below' or a mapping as {'v': 1}"
        raise ValueError(f"`{call}(side=...)` must be {must}; got {describe(side)}.")
    if not weights.any():
        raise ValueError(f"`{call}(side=...)` must leave the point; got zeros alone.")
    return np.asarray(REACH * (1 + np.abs(np.concatenate([x, u]))) * weights / np.abs(weights).max())


def _places(ode: Ode, name: str) -> list[int]:
    """The places of a state or an input, or of one number of it, in x and u."""
    inputs = inputs_of(ode)
    known_name(name, [*ode.states.names, *ode.states.labels, *inputs.names, *inputs.labels], "states and inputs")
    if name in ode.states or name in ode.states.labels:
        return ode.states.indices(name)
    return [ode.states.size + place for place in inputs.indices(name)]


def chosen_pieces(corners: SwitchingFunctions, pieces: Sequence[CornerSide], step: Array, at: At) -> list[CornerSide]:
    """The pieces on the side to which a step leads: those whose signs it does not contradict, or all."""
    if not pieces:
        return []
    value = np.array(corners.functions[0](*corners.shift_arguments(*at, step)))[:, 0]
    size = np.abs(np.array(corners.functions[0](*at))[:, 1:-1]) @ np.abs(step)
    return _agreeing_sides(pieces, np.where(np.abs(value) > LEAST * size, np.sign(value), 0))


def pieces_ahead(corners: SwitchingFunctions, pieces: Sequence[CornerSide], at: At) -> list[CornerSide]:
    """The pieces into which the motion x' = f(t, x, p) goes from a point, by the drift of the switching functions."""
    t, x, p = at
    slope, by_time = np.split(np.array(corners.functions[0](*at))[:, 1:], [-1], axis=1)
    moves = np.concatenate([corners.ode.rate_at(t, x, p), np.zeros(slope.shape[1] - len(x))])
    drift, size = slope @ moves + by_time[:, 0], np.abs(slope) @ np.abs(moves) + np.abs(by_time[:, 0])
    return _agreeing_sides(pieces, np.where(np.abs(drift) > LEAST * size, np.sign(drift), 0))


def _agreeing_sides(pieces: Sequence[CornerSide], signs: Array) -> list[CornerSide]:
    return [piece for piece in pieces if (signs * piece.signs >= 0).all()] or list(pieces)


def refuse_corner(
    call: str,
    corners: SwitchingFunctions,
    pieces: Sequence[CornerSide],
    odd: Mask,
    rows: Sequence[str],
    remedy: str = "",
) -> None:
    """Refuse a point at which the entries `odd` of the Jacobians differ, with the corner and its pieces."""
    i, j = np.argwhere(odd)[np.argmax(np.ptp([piece.near for piece in pieces], axis=0)[odd])]
    values = [float(np.nan_to_num(piece.near[i, j], nan=np.inf)) for piece in pieces]
    ends = pieces[int(np.argmin(values))], pieces[int(np.argmax(values))]
    crossed = [text for text, a, b in zip(corners.texts, ends[0].signs, ends[1].signs, strict=True) if a != b]
    crossed = [text for text in crossed if "<" not in text] or crossed  # a comparison often goes with its maximum
    name = corners.labels[int(np.abs(ends[1].direction - ends[0].direction).argmax())]
    one_side = f"Take another point, or one piece by `side={{'{name}': 1}}` or `side={{'{name}': -1}}`."
    raise ValueError(
        f"`{call}(...)`: {rows[i]} has a corner at this state, of {' and '.join(dict.fromkeys(crossed))}: its "
        f"derivative by '{corners.labels[j]}' is {min(values):.4g} on one piece and {max(values):.4g} on another "
        f"of {len(pieces)}. {remedy or one_side}"
    )


def rows_of(ode: Ode) -> list[str]:
    """The names of the rows of the Jacobian, in words."""
    return [*(f"the rate of '{label}'" for label in ode.states.labels), *map(repr, ode.outputs.labels)]


def sure_jacobians(
    call: str,
    corners: SwitchingFunctions,
    t: float,
    x: Array,
    p: Array,
    side: Sides = None,
    used_entries: UsedEntries = all_entries,
) -> tuple[Array, Array, Array, Array]:
    """A, B, Cy and D at a point, on one side of its corners if asked; else corners in `used_entries` are refused.

    `used_entries` tells on which entries (nx + ny, nx + nu), of those not zero on all pieces, the answer depends.
    """
    ode, corners = corners.ode, corners.at(t, x, p)
    step = side_direction(call, corners, side, x, p[places_of(ode)])
    pieces = corners.pieces(t, x, p)
    if not pieces:
        return jacobians(call, ode, t, x, p)
    if step is None:
        A, B, Cy, D = jacobians(call, ode, t, x, p)  # refused where none of them is finite
    else:
        pieces = chosen_pieces(corners, pieces, step, (t, x, p))
    needed = used_entries(anywhere(pieces))
    odd = corner_entries(pieces) & needed
    if odd.any():
        refuse_corner(call, corners, pieces, odd, rows_of(ode))
    J = pieces[0].near
    if step is None:
        mean = np.block([[A, B], [Cy, D]])
        # of pieces that agree the mean may still be another number: | |x| + x | - |x| - x is zero, and its mean is -1
        off = np.abs(J - mean)
        J = np.where((off > np.abs(J - pieces[0].far)) & (off > rounding_errors(pieces)) & needed, J, mean)
    else:
        _refuse_infinite(call, ode, pieces[0])
    return split(J, len(x))


def split(J: Array, n: int) -> tuple[Array, Array, Array, Array]:
    """A, B, Cy and D, side by side in the derivatives of n rates and of the outputs."""
    return J[:n, :n], J[:n, n:], J[n:, :n], J[n:, n:]


def _refuse_infinite(call: str, ode: Ode, piece: CornerSide) -> None:
    """Refuse a side on which a derivative does not settle as the point comes nearer, as of a root at zero."""
    change = np.abs(piece.near - piece.far)
    for i, j in np.argwhere(~(change <= 1e-3 * (1 + np.abs(piece.far))))[:1]:
        raise ValueError(
            f"`{call}(side=...)`: {rows_of(ode)[i]} has no derivative on this side of the state: it is "
            f"{piece.far[i, j]:.3g} near it and {piece.near[i, j]:.3g} nearer; linearise at another state."
        )

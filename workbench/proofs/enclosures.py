r"""A symmetric matrix S(x) of expressions, enclosed over boxes |x - c| <= r, in any coordinates U:

    | U' S(x) U  -  A  -  sum_k L_k (x_k - c_k) |  <=  R,     entry by entry,

with A and L_k of doubles and R >= 0, which shrinks with r^2 where S is smooth. There are two ways to such
a form: `CosineSum`, by Taylor's remainder of sines and cosines, for the matrices of linked bodies; and
`MeanValueForm`, by intervals of the exact Jacobian, for all else. R contains the rounding of A and L_k.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import NamedTuple

import casadi as ca
import numpy as np

from workbench.core.notation.normal_form import NotInClass, normal_forms
from workbench.core.notation.program import Walk, walk
from workbench.core.validation.refusals import Array
from workbench.proofs.interval import Interval, at_points, evaluate, jumps

UNIT = 2.0**-53
# Beyond so many waves their products with U cost more than they save; beyond so many intervals of the Jacobian do.
FEW_WAVES, MANY_WAVES = 64, 1000


class Expansion(NamedTuple):
    """A (b, n, n), L (b, m, n, n), R (b, n, n), and the share of each of the m symbols in R (b, m)."""

    A: Array
    L: Array
    R: Array
    blame: Array


class AbstractForm(ABC):
    """A symmetric matrix (n, n) of expressions in m symbols that can be enclosed over boxes."""

    @property
    @abstractmethod
    def cost(self) -> int:
        """The number of doubles that one box needs, about, to which the time is in proportion."""

    @abstractmethod
    def value(self, c: Array) -> Array:
        """S at points c (b, m), (b, n, n), without a bound of its rounding."""

    @abstractmethod
    def expand(self, c: Array, r: Array, U: Array) -> Expansion:
        """The enclosure over b boxes with middles c and half widths r, (b, m) each, in coordinates U (b, n, n)."""


def form_of(matrix: ca.SX, symbols: list[ca.SX], numbers: Mapping[str, float]) -> AbstractForm:
    """The sharper of the two forms of a symmetric matrix (n, n), with some symbols fixed to numbers, not rounded."""
    try:
        return _waves(matrix, symbols, numbers)
    except NotInClass:
        return _mean_value(matrix, symbols, numbers)


@dataclass(frozen=True, eq=False)
class CosineSum(AbstractForm):
    """S(x) = W_0 + sum_s W_s cos(k_s . x + phi_s): (n, n), (S, n, n), slopes (S, m), phases (S,), and its sines (S,).

    By Taylor's theorem a wave of slopes k leaves its tangent by at most (|k| . r)^2 / 2 in a box, so R is
    the sum of |U' W_s U| (|k_s| . r)^2 / 2: taken in the coordinates U, what cancels in them costs nothing.
    """

    constant: Array
    W: Array
    slopes: Array
    phases: Array
    sines: Array

    @property
    def cost(self) -> int:
        """The number of coefficients of the waves in the coordinates of one box."""
        n, m = len(self.constant), int(self.slopes.shape[1])
        return (3 * len(self.W) + 2 * m + 4) * n * n

    @cached_property
    def _bend(self) -> Array:
        """Bounds of the second derivatives, (m, m, n, n)."""
        slopes = np.abs(self.slopes)
        return np.asarray(np.einsum("sk,sl,sij->klij", slopes, slopes, np.abs(self.W), optimize=True))

    def value(self, c: Array) -> Array:
        """The sum of waves."""
        angle = c @ self.slopes.T + self.phases
        waves = np.where(self.sines, np.sin(angle), np.cos(angle))
        return np.asarray(self.constant + np.tensordot(waves, self.W, 1))

    def expand(self, c: Array, r: Array, U: Array) -> Expansion:
        """The tangent at the middle, and Taylor's remainder."""
        angle = c @ self.slopes.T + self.phases
        ends = [at_points(name, angle) for name in ("sin", "cos")]
        sine, cosine = ((low + high) / 2 for low, high in ends)
        doubt, more = ((high - low).max(axis=1, initial=0.0) for low, high in ends)
        height, slope = np.where(self.sines, sine, cosine), np.where(self.sines, cosine, -sine)
        reach = r @ np.abs(self.slopes).T
        remainder = reach**2 / 2
        steps = slope[:, None] * self.slopes.T  # (b, m, S)
        V = U.transpose(0, 2, 1)
        if len(self.W) <= FEW_WAVES:
            turned = V[:, None] @ self.W @ U[:, None]
            A = V @ self.constant @ U + np.einsum("bs,bsij->bij", height, turned)
            L = np.einsum("bms,bsij->bmij", steps, turned)
            turned = np.abs(turned)
            R = np.einsum("bs,bsij->bij", remainder, turned)
            blame = np.einsum("bs,bs,sk->bk", reach, turned.sum(axis=(2, 3)), np.abs(self.slopes)) * r
        else:
            A = V @ (self.constant + np.tensordot(height, self.W, 1)) @ U
            L = V[:, None] @ np.tensordot(steps, self.W, 1) @ U[:, None]
            bend = np.einsum("klij,bk,bl->bkij", self._bend, r, r, optimize=True) / 2
            bend = np.abs(V)[:, None] @ bend @ np.abs(U)[:, None]
            R, blame = bend.sum(axis=1), bend.sum(axis=(2, 3))
        terms = len(self.W) + len(self.constant) ** 2 + c.shape[1] + 8
        angles = (np.abs(c) @ np.abs(self.slopes).T + np.abs(self.phases)).max(axis=1, initial=0.0)
        off = 4 * UNIT * (terms + (c.shape[1] + 2) * angles) + np.maximum(doubt, more)
        off = off * (1 + reach.max(axis=1, initial=0.0)) ** 2
        size = np.abs(self.constant) + np.abs(self.W).sum(axis=0)
        R = R * (1 + 4 * UNIT * terms) + off[:, None, None] * (np.abs(V) @ size @ np.abs(U))
        return Expansion(A, L, R, blame)


@dataclass(frozen=True, eq=False)
class MeanValueForm(AbstractForm):
    """S(x) = S(c) + sum_k dS/dx_k (x_k - c_k), each derivative in an interval over the box.

    A matrix that may jump has no such form: then L is 0, and R the radius of S itself over the box.
    """

    order: int
    names: tuple[str, ...]
    numbers: Mapping[str, float]
    matrix: Walk
    jacobian: Walk
    function: ca.Function
    jumps: bool

    @property
    def cost(self) -> int:
        """About twenty operations on doubles for each operation on intervals."""
        return 20 * len(self.jacobian.nodes) + (len(self.names) + 4) * self.order**2

    def value(self, c: Array) -> Array:
        """The matrix, evaluated by CasADi."""
        return np.array(self.function(c.T)).T.reshape(-1, self.order, self.order)

    def expand(self, c: Array, r: Array, U: Array) -> Expansion:
        """Intervals of the matrix at the middle and of its derivatives over the box."""
        n, m = self.order, len(self.names)
        low, high = np.nextafter(c - r, -np.inf), np.nextafter(c + r, np.inf)
        wide = {name: Interval(low[:, k], high[:, k]) for k, name in enumerate(self.names)}
        thin = {name: Interval(c[:, k], c[:, k]) for k, name in enumerate(self.names)}
        still = {name: Interval(*[np.full(len(c), number)] * 2) for name, number in self.numbers.items()}
        wide, thin = wide | still, thin | still
        V = U.transpose(0, 2, 1)
        with np.errstate(all="ignore"):
            A, R = _stacked(evaluate(self.matrix, wide if self.jumps else thin), (n, n))
            size, L = np.abs(A), np.zeros((len(c), m, n, n))
            blame = r * R.sum(axis=(1, 2))[:, None] if self.jumps else np.zeros_like(c)
            if not self.jumps:
                L, spread = _stacked(evaluate(self.jacobian, wide), (m, n, n))
                grown = r[:, :, None, None] * spread
                size = size + (r[:, :, None, None] * np.abs(L)).sum(axis=1)
                R, blame = R + grown.sum(axis=1), grown.sum(axis=(2, 3))
            if n == 1 and not self.jumps:
                A, L, R = self._sharper(wide, r, A, L, R)
            R = R * (1 + 8 * UNIT * (m + 2)) + 8 * UNIT * (n * n + m + 4) * size
            return Expansion(V @ A @ U, V[:, None] @ L @ U[:, None], np.abs(V) @ R @ np.abs(U), blame)

    def _sharper(self, wide: dict[str, Interval], r: Array, A: Array, L: Array, R: Array) -> tuple[Array, Array, Array]:
        """For one expression: its own interval over the box where that lies higher than the mean value's."""
        middle, radius = _stacked(evaluate(self.matrix, wide), (1, 1))
        own = middle - radius > A - R - (r[:, :, None, None] * np.abs(L)).sum(axis=1)
        return np.where(own, middle, A), np.where(own[:, None], 0.0, L), np.where(own, radius, R)


def _stacked(parts: list[Interval], shape: tuple[int, ...]) -> tuple[Array, Array]:
    middle, radius = (np.stack([getattr(part, name) for part in parts], axis=1) for name in ("middle", "radius"))
    lost = np.logical_not(np.isfinite(middle) & np.isfinite(radius))
    middle, radius = np.where(lost, 0.0, middle), np.where(lost, np.inf, radius)
    return middle.reshape(-1, *shape), radius.reshape(-1, *shape)


def _waves(matrix: ca.SX, symbols: list[ca.SX], numbers: Mapping[str, float]) -> CosineSum:
    n, names = matrix.shape[0], [symbol.name() for symbol in symbols]
    fractions = {name: Fraction(number) for name, number in numbers.items()}
    held: dict[tuple[str, tuple[float, ...], float], Array] = {}
    for i, row in enumerate(normal_forms(ca.densify(matrix), fractions)):
        for j, form in enumerate(row):
            for (monomial, (kind, angle)), coefficient in form.terms.items():
                parts = dict(angle)
                phase = float(parts.pop((), 0))
                slopes = {factor[0][0]: float(slope) for factor, slope in parts.items() if len(factor) == 1}
                linear = len(slopes) == len(parts) and all(factor[0][1] == 1 for factor in parts)
                if monomial or not linear or slopes.keys() - set(names):
                    raise NotInClass("A wave has a number before it, and an angle that is linear in the symbols.")
                key = (kind, tuple(slopes.get(name, 0.0) for name in names), phase)
                held.setdefault(key, np.zeros((n, n)))[i, j] += float(coefficient)
    moving = {key: W for key, W in held.items() if any(key[1])}
    if len(moving) > MANY_WAVES:
        raise NotInClass(f"{len(moving)} waves are too many.")
    still = [W * (np.cos(key[2]) if key[0] == "cos" else np.sin(key[2])) for key, W in held.items() if not any(key[1])]
    count = len(moving)
    return CosineSum(
        np.sum(still, axis=0) if still else np.zeros((n, n)),
        np.array(list(moving.values())).reshape(count, n, n),
        np.array([key[1] for key in moving]).reshape(count, len(names)),
        np.array([key[2] for key in moving]),
        np.array([key[0] == "sin" for key in moving], dtype=bool),
    )


def _mean_value(matrix: ca.SX, symbols: list[ca.SX], numbers: Mapping[str, float]) -> MeanValueForm:
    n, x, names = matrix.shape[0], ca.vertcat(*symbols), tuple(symbol.name() for symbol in symbols)
    fixed = [symbol for symbol in ca.symvar(matrix) if symbol.name() in numbers]
    values = [numbers[symbol.name()] for symbol in fixed]
    flat = ca.vec(ca.densify(matrix.T))
    steps = walk(flat, cse=True)
    return MeanValueForm(
        n,
        names,
        {symbol.name(): value for symbol, value in zip(fixed, values, strict=True)},
        steps,
        walk(ca.vec(ca.densify(ca.jacobian(flat, x))), cse=True) if symbols else steps,
        ca.Function("matrix", [x], [ca.substitute(flat, ca.vertcat(*fixed), ca.DM(values))], {"cse": True}),
        bool(jumps(steps, names)),
    )

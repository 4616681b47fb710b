r"""The least eigenvalue of a symmetric matrix S(x) over a box: sought on a grid, and proved by branch and bound.

A threshold a is proved box by box: S(x) - a I is positive definite in all of a box if, in coordinates U in
which it is near I at the middle, its linear part less the row sums of all that is unknown is so at each
corner. (Between the corners it is then too, as the least eigenvalue is a concave function.) A box that fails
is halved. U comes from the eigenvectors at the middle: large eigenvalues then forgive large remainders.
Definiteness is decided by Cholesky's factorisation, with a bound of its rounding.

References
----------
Rump (2006), Verification of positive definiteness, BIT Numerical Mathematics 46, theorem 2.3.
Rohn (1994), Positive definiteness and stability of interval matrices, SIAM J. Matrix Anal. Appl. 15.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.proofs.enclosures import UNIT, AbstractForm
from workbench.proofs.interval import NoBound

# Doubles that are held at a time; corners are looked at one by one, up to so many symbols.
MAX_ENTRIES, MAX_CORNER_DIMENSIONS = 20_000_000, 6
# Within this share of the value a first proof is sought, so that a large budget is not spent in vain on the last digit.
COARSE = 0.3
# A box of this width, relative to its place, is one that cannot be halved any more.
NARROW = 1e-13


class Boxes(NamedTuple):
    """Middles and half widths, (b, m) each."""

    c: Array
    r: Array


@dataclass(frozen=True, eq=False)
class Proof:
    """The least value that was found, at `x`, and `bound`, a proved lower bound of all eigenvalues; None if unproved.

    `boxes` were examined. `why` is the reason why the proof misses its tolerance, else empty.
    """

    value: float
    x: Array
    bound: float | None
    boxes: int
    why: str


def whole(low: Array, high: Array) -> Boxes:
    """One box around low <= x <= high, widened by rounding so that bounds of -pi and pi contain the whole turn."""
    c, r = (low + high) / 2, (high - low) / 2
    return Boxes(c[None], (r + 4 * UNIT * (np.abs(c) + r))[None])


def prove(
    form: AbstractForm, box: Boxes, least_sample: tuple[float, Array], scale: float, share: float, budget: int
) -> Proof:
    """Prove that no eigenvalue in a box lies more than share * scale below the least that was seen.

    A point that lies lower still takes the place of `least_sample`. `NoBound` names a pole, or a place beyond a domain.
    """
    (value, x), beyond, count, cover = least_sample, None, 0, box
    for gap in (COARSE, share) if share < COARSE else (share,):
        todo, done = cover, []
        while len(todo.c):
            if count + len(todo.c) > budget:
                return Proof(value, x, beyond, count, f"the budget of {budget} boxes was used up")
            count += len(todo.c)
            threshold = value - gap * scale
            holds, centre, halves = _look(form, todo, threshold)
            best = int(np.argmin(centre))
            if centre[best] < value - share * scale:
                value, x = float(centre[best]), todo.c[best]
                continue
            done.append(Boxes(todo.c[holds], todo.r[holds]))
            todo = halves
            if len(todo.c) and (todo.r < NARROW * (1 + np.abs(todo.c))).all(axis=1).any():
                return Proof(value, x, beyond, count, _stuck(form, todo))
        beyond, cover = value - gap * scale, Boxes(*(np.concatenate(parts) for parts in zip(*done, strict=True)))
    return Proof(value, x, beyond, count, "")


def _stuck(form: AbstractForm, todo: Boxes) -> str:
    thin = (todo.r < NARROW * (1 + np.abs(todo.c))).all(axis=1)
    n = form.value(todo.c[:1]).shape[-1]
    rest = form.expand(todo.c[thin], todo.r[thin], np.tile(np.eye(n), (int(thin.sum()), 1, 1))).R
    if not (bounded := np.isfinite(rest).all(axis=(1, 2))).all():
        place = todo.c[thin][np.argmin(bounded)].tolist()
        raise NoBound(f"There is no bound near {place}: a pole, or the end of a domain. Take a box without that place.")
    return "rounding is larger than the tolerance, or it jumps where it is extreme"


def _look(form: AbstractForm, boxes: Boxes, threshold: float) -> tuple[Array, Array, Boxes]:
    size = max(1, MAX_ENTRIES // max(form.cost, 1))
    parts = (Boxes(boxes.c[i : i + size], boxes.r[i : i + size]) for i in range(0, len(boxes.c), size))
    holds, centre, halves = zip(*(_test(form, part, threshold) for part in parts), strict=True)
    return np.concatenate(holds), np.concatenate(centre), Boxes(*map(np.concatenate, zip(*halves, strict=True)))


def _test(form: AbstractForm, boxes: Boxes, threshold: float) -> tuple[Array, Array, Boxes]:
    c, r = boxes
    S = form.value(c)
    if not (finite := np.isfinite(S).all(axis=(1, 2))).all():
        where = c[np.flatnonzero(~finite)[0]].tolist()
        raise NoBound(f"A bound needs finite numbers all over the box; it has none at {where}.")
    n = S.shape[-1]
    values, U = np.linalg.eigh(S - threshold * np.eye(n))
    U = U / np.sqrt(np.maximum(values, 1e-9 * np.abs(values).max(axis=1, initial=1e-300, keepdims=True)))[:, None]
    with np.errstate(all="ignore"):
        A, L, R, blame = form.expand(c, r, U)
        gram = U.transpose(0, 2, 1) @ U
        R = R + 8 * UNIT * n * n * (np.abs(A) + abs(threshold) * (np.abs(U).transpose(0, 2, 1) @ np.abs(U)))
        start = A - threshold * gram
        L = L * r[:, :, None, None]
        holds = corners_definite(start, L, R)
    failed = np.logical_not(holds)
    return holds, values[:, 0] + threshold, halve(c[failed], r[failed], blame[failed])


def corners_definite(A: Array, L: Array, R: Array) -> Array:
    """True (b,) where A + sum_k e_k L_k + E is proved definite for all |e_k| <= 1 and all symmetric |E| <= R.

    A and R are (b, n, n), L is (b, m, n, n). Between the corners of e it is so too, as the least eigenvalue is concave.
    """
    n = A.shape[-1]
    if L.shape[1] > MAX_CORNER_DIMENSIONS:
        R, L = R + np.abs(L).sum(axis=1), L[:, :0]
    unknown = R.sum(axis=2) * (1 + 8 * UNIT * n)
    start = A - unknown[:, :, None] * np.eye(n)
    holds = np.ones(len(A), dtype=bool)
    for corner in itertools.product((-1.0, 1.0), repeat=L.shape[1]):
        left = np.flatnonzero(holds)
        corners = start[left] + np.tensordot(L[left], np.array(corner), ((1,), (0,))) if corner else start[left]
        holds[left] = definite(corners)
    return holds


def halve(c: Array, r: Array, blame: Array) -> Boxes:
    """Both halves of each box, across the symbol with the largest share of R; without symbols, the box itself."""
    if not c.shape[1]:
        return Boxes(c, r)
    sound = np.asarray(np.isfinite(blame).all(axis=1) & (blame > 0).any(axis=1))
    axis, rows = np.where(sound[:, None], blame, r).argmax(axis=1) if len(c) else np.zeros(0, int), np.arange(len(c))
    middle, half = c.copy(), r.copy()
    half[rows, axis] = r[rows, axis] / 2
    shift = np.zeros_like(c)
    shift[rows, axis] = half[rows, axis]
    half[rows, axis] += 4 * UNIT * (np.abs(c[rows, axis]) + r[rows, axis])  # the halves overlap by their rounding
    return Boxes(np.concatenate([middle - shift, middle + shift]), np.concatenate([half, half]))


def definite(B: Array) -> Array:
    """True (b,) where symmetric B (b, n, n) are proved definite: the algorithm of Cholesky ends for B - s I (Rump)."""
    n = B.shape[-1]
    trace = np.abs(np.einsum("bii->bi", B)).sum(axis=1)
    B = B - (4 * (n + 2) * UNIT * trace + 1e-290)[:, None, None] * np.eye(n)
    L, holds = np.zeros_like(B), np.ones(len(B), dtype=bool)
    for j in range(n):
        pivot = B[:, j, j] - (L[:, j, :j] ** 2).sum(axis=1)
        holds &= pivot > 0
        L[:, j, j] = np.sqrt(np.where(pivot > 0, pivot, 1.0))
        for i in range(j + 1, n):
            L[:, i, j] = (B[:, i, j] - (L[:, i, :j] * L[:, j, :j]).sum(axis=1)) / L[:, j, j]
    return holds


# Grid points in all, and how often the grid is halved round its best point: 2^-40 of a cell is 1e-13 rad.
GRID, HALVINGS = 20_000, 40
# Beyond so many dimensions a grid has too many corners; then points of an even sequence take its place.
DIMENSIONS = 5


class LeastSample(NamedTuple):
    """The least value that was seen, where, and in how many samples."""

    value: float
    x: Array
    samples: int


def least_seen(function: Callable[[Array], Array], low: Array, high: Array) -> LeastSample:
    """The least of function (points (N, m) to values (N,)) over low <= x <= high, the middle and corners included."""
    m = len(low)
    best, half = (low + high) / 2, (high - low) / 2
    value, samples = np.inf, 0
    for steps in _steps(m):
        x = np.clip(best + steps * half, low, high)
        values = function(x)
        samples += len(x)
        if values.min() < value:
            value, best = float(values.min()), x[values.argmin()]
    return LeastSample(value, best, samples)


def _steps(m: int) -> Iterator[Array]:
    if m == 0:
        yield np.zeros((1, 0))
        return
    points = max(int(GRID ** (1 / m)) // 4, 1) * 4 + 1
    if m <= DIMENSIONS:
        yield _lattice(np.linspace(-1, 1, points), m)
        near = _lattice(np.linspace(-2, 2, 5), m)
    else:
        yield np.vstack([np.zeros(m), 2 * sequence(GRID, m) - 1])
        near = np.vstack([np.zeros(m), 4 * sequence(GRID // 8, m) - 2])
    for level in range(HALVINGS):
        yield near / (points - 1) / 2.0**level


def _lattice(side: Array, m: int) -> Array:
    return np.stack(np.meshgrid(*[side] * m, indexing="ij"), axis=-1).reshape(-1, m)


def sequence(count: int, dimensions: int) -> Array:
    """Points (count, dimensions) spread evenly over the unit cube (the R sequence of M. Roberts, 2018)."""
    if dimensions == 0:
        return np.zeros((count, 0))
    root = 2.0
    for _ in range(60):  # a contraction: the positive root of root^(d+1) = root + 1 to the last digit
        root = (1 + root) ** (1 / (dimensions + 1))
    steps = root ** -np.arange(1.0, dimensions + 1)
    return np.asarray((0.5 + np.outer(np.arange(1, count + 1), steps)) % 1.0)

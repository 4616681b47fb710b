"""Rest points of an equation in a box: Newton from many starts, and proofs where intervals give them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from workbench.core import Layout, Ode
from workbench.core.validation.notebook_display import show
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array, whole
from workbench.core.validation.refusals import seed as check_seed
from workbench.core.validation.signatures import check_arguments
from workbench.design.linear.equilibria_proofs import prove_equilibria
from workbench.design.linear.operating_point import row_of
from workbench.design.linear.switching_functions import SwitchingFunctions, corner_entries

NEWTON_STEPS, HALVINGS = 40, 12
STEP_TOLERANCE = 1e-12  # the last step, relative to the state
MERGE_DISTANCE = 1e-7  # rest points nearer than this, relative to their size, are one
ISOLATED_CONDITION = 1e10  # a condition of df/dx from which on a rest point may be one of a continuum
STRIDE, ASTRAY = 1e-3, 0.1  # a step along a continuum, relative to the state; the share of it that may lead off
MOST_STARTS = 100_000


@dataclass(frozen=True, eq=False)
@show
class Equilibrium:
    """A state x (nx,) at which f(x, p, u) = 0, with the poles (nx,) of df/dx in 1/s, the slowest to decay first.

    The poles are NaN on a corner, where pieces with other Jacobians meet: `linearize(..., side=...)` has those of each.

    `error` is the size of a further Newton step, relative to the size of x. `condition` is the norm of df/dx, or its
    median over the starts if that is larger, times the norm of its inverse. From 1e10 on the point may be one of a
    continuum, along which the states `along` change. If `radius` is not None, an equilibrium is proved to lie within
    `radius` of x in each state.
    """

    x: Array
    error: float
    condition: float
    poles: NDArray[np.complex128]
    radius: float | None
    along: tuple[str, ...] = ()

    @property
    def is_isolated(self) -> bool:
        """True if df/dx is regular, so that no other equilibrium is near."""
        return self.condition < ISOLATED_CONDITION


@dataclass(frozen=True, eq=False)
@show
class Equilibria:
    """The equilibria `points` that were found in a box, in the order of their states.

    Newton's method began from `starts` points; `converged_starts` of them reached an equilibrium, in the box or not. If
    `complete`, intervals over `boxes` parts of the box prove that it holds no others.
    """

    points: tuple[Equilibrium, ...]
    starts: int
    converged_starts: int
    complete: bool
    boxes: int

    def __str__(self) -> str:
        found = {0: "no rest point", 1: "1 rest point"}.get(len(self.points), f"{len(self.points)} rest points")
        tried = f"{self.converged_starts} of {self.starts} starts converged"
        if self.complete:
            return f"{found} in the box, and no other: proved by intervals over {self.boxes} boxes ({tried})"
        if moving := sorted({label for point in self.points for label in point.along}):
            return (
                f"{found} found in the box ({tried}), {sum(bool(point.along) for point in self.points)} of them on a "
                f"continuum of rest points, along which {', '.join(map(repr, moving))} changes"
            )
        return f"{found} found in the box ({tried}); that there is no other is not proved"


@check_arguments
def equilibria(
    ode: Ode,
    box: Mapping[str, tuple[float, float]],
    p: Numbers | None = None,
    u: Numbers | None = None,
    *,
    starts: int = 64,
    seed: int = 0,
    boxes: int = 20_000,
) -> Equilibria:
    """The equilibria of x' = f(x, p, u) in a box, found by Newton's method from quasi-random starts.

    There are `starts` of them, drawn with `seed`. Where f jumps or has corners, Newton's method sees one piece. The
    parameters p (np,) and the inputs u (nu,), which overwrite theirs in p, are by default those of `ode`. At most
    `boxes` boxes serve the proof that there are no others; 0 for no proof.

    Parameters
    ----------
    box
        The bounds (low, high) of every state, by name (`q` or `q[0]`). Angles that differ by a turn are different.

    Raises
    ------
    ValueError
        If the rate depends on time, a state has no or wrong bounds, or `starts`, `seed` or `boxes` is wrong.
    LookupError
        If a name is not that of a state.

    References
    ----------
    Moore, Kearfott and Cloud (2009), Introduction to Interval Analysis, chapter 8.

    Examples
    --------
    >>> found = wb.equilibria(wb.open_loop(wb.DCMotor()), {"omega": (-1.0, 1.0), "i": (-5.0, 5.0)}, u=[1.0])
    >>> [point.x.round(3) for point in found.points]
    [array([0.1  , 0.999])]
    """
    row = row_of(ode, p, u)
    whole("equilibria(boxes=...)", boxes, 0, of=" of boxes")
    if ca.depends_on(ode.rate, ode.t):
        raise ValueError(
            f"`equilibria(ode=...)` must have a rate that does not depend on time; that of '{ode.name}' does."
        )
    low, high = _ends(ode.states, box)
    begun = _spread_points(low, high, starts, seed)
    reached = [end for start in begun if (end := _newton(ode, start, row)) is not None]
    room = 1e-9 * (high - low)
    inside = [x for x in reached if ((low - room <= x) & (x <= high + room)).all()]
    found = _distinct(inside)
    usual = _usual(ode, begun, row)
    radii, complete, looked_at = prove_equilibria(ode, row, low, high, found, boxes)
    # where the proof is complete, a point with no zero near it is none: its rate is small, but not zero
    kept = [(x, r) for x, r in zip(found, radii, strict=True) if r is not None or not complete]
    points = [_certified_equilibrium(ode, x, row, usual, radius) for x, radius in kept]
    return Equilibria(tuple(points), starts, len(reached), complete, looked_at)


def _ends(states: Layout, box: Mapping[str, tuple[float, float]]) -> tuple[Array, Array]:
    low, high = np.full(states.size, np.nan), np.full(states.size, np.nan)
    for name, ends in box.items():
        places = states.indices(name)
        low[places], high[places] = ends
        if not (np.isfinite([low[places], high[places]]).all() and (low[places] < high[places]).all()):
            raise ValueError(f"`equilibria(box=...)`: '{name}' must be (low, high), low < high, finite; got {ends!r}.")
    if np.isnan(low).any():
        raise ValueError(
            f"`equilibria(box=...)` must bound every state, as starts are drawn from it; "
            f"'{states.labels[int(np.isnan(low).argmax())]}' has no bounds."
        )
    return low, high


def _spread_points(low: Array, high: Array, count: int, seed: int) -> Array:
    """Points (count, nx) that fill a box evenly: Kronecker's sequence of Roberts' generalised golden ratio."""
    whole("equilibria(starts=...)", count, most=MOST_STARTS)
    ratio = 1.5
    for _ in range(60):  # to the root of x^(n + 1) = x + 1
        ratio = (1 + ratio) ** (1 / (len(low) + 1))
    pace = ratio ** -np.arange(1.0, len(low) + 1)
    shift = np.random.default_rng(check_seed("equilibria(seed=...)", seed)).uniform(size=len(low))
    return np.asarray(low + (high - low) * ((shift + np.outer(np.arange(count), pace)) % 1))


def _newton(ode: Ode, start: Array, p: Array) -> Array | None:
    """The rest point that Newton's method reaches from a start, halving steps that lead uphill; None if it does not."""
    x, rate = start, ode.rate_at(0.0, start, p)
    for _ in range(NEWTON_STEPS):
        A = np.array(ode.A(0.0, x, p))
        if not (np.isfinite(A).all() and np.isfinite(rate).all()):
            return None
        change = np.linalg.lstsq(A, -rate, rcond=1e-13)[0]
        if np.abs(change).max() <= STEP_TOLERANCE * (1 + np.abs(x).max()):
            at = x + change
            # least squares also end where no step makes the rate less: what is left must be rounding
            rests = (np.abs(rate) <= 1e-9 * (1 + np.abs(A) @ (1 + np.abs(at)))).all()
            return at if rests else None
        for halvings in range(HALVINGS):
            share = 0.5**halvings
            ahead = ode.rate_at(0.0, x + share * change, p)
            if np.linalg.norm(ahead) < np.linalg.norm(rate):
                break
        x, rate = x + share * change, ahead
    return None


def _distinct(points: list[Array]) -> list[Array]:
    kept: list[Array] = []
    for x in points:
        if all(np.abs(x - other).max() > MERGE_DISTANCE * (1 + np.abs(x).max()) for other in kept):
            kept.append(x)
    return sorted(kept, key=lambda x: [round(float(value), 6) for value in x])


def _usual(ode: Ode, starts: Array, p: Array) -> float:
    """The median of the norms of df/dx over the starts at which it is defined."""
    slopes = (np.array(ode.A(0.0, x, p)) for x in starts)
    return float(np.median([float(np.linalg.norm(A, 2)) for A in slopes if np.isfinite(A).all()] or [0.0]))


def _along(ode: Ode, x: Array, p: Array, flat: Array) -> tuple[str, ...]:
    """The states that change along a continuum of rest points through x, with directions (k, nx) as candidates."""
    moving = np.zeros(len(x))
    for direction in flat:
        for stride in (STRIDE, -STRIDE):
            start = x + stride * (1 + np.abs(x).max()) * direction
            end = _newton(ode, start, p)
            if end is not None and np.linalg.norm(end - start) <= ASTRAY * np.linalg.norm(start - x):
                moving = np.maximum(moving, np.abs(direction))
    return tuple(label for label, share in zip(ode.states.labels, moving, strict=True) if share > MERGE_DISTANCE)


def _certified_equilibrium(ode: Ode, x: Array, p: Array, usual: float, radius: float | None) -> Equilibrium:
    A = np.array(ode.A(0.0, x, p))
    poles, corners = np.linalg.eigvals(A).astype(complex), SwitchingFunctions.of(ode).at(0.0, x, p)
    pieces, n = corners.pieces(0.0, x, p), len(x)
    if pieces and corner_entries(pieces)[:n, :n].any():
        poles = np.full(n, np.nan + 0j)
    step = np.linalg.lstsq(A, ode.rate_at(0.0, x, p), rcond=1e-13)[0]
    _, sizes, directions = np.linalg.svd(A)
    along = _along(ode, x, p, directions[sizes * ISOLATED_CONDITION <= max(sizes[0], usual)])
    condition = float(max(sizes[0], usual) / sizes[-1]) if sizes[-1] else float("inf")
    slowest = poles[np.lexsort((-poles.imag, -poles.real))]
    error = float(np.abs(step).max() / (1 + np.abs(x).max()))
    return Equilibrium(x, error, condition, slowest, radius, along)

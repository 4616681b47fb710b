"""The search of a box for the draws of a loop at which its figures come nearest to their limits, or break them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.design.linear_loop import LinearLoop
from workbench.design.linear_loop.linear_loops import about
from workbench.design.loop_boxes import ParameterBox
from workbench.study.specifications.limits import Limit
from workbench.study.specifications.row_figures import RowGrid, row_figures
from workbench.validation.refusals import Array

MOST_CORNERS = 8  # numbers of a box whose corners are all tried
ROUNDS, FIRST = 8, 0.25  # of the refinement, and its first step as a share of the box; each is half the one before


@dataclass(frozen=True, eq=False)
class BoxSearch:
    """The draws of a search: parameters theta (N, d) and rest states x (N, nx), and the worst draw of each figure.

    `worst` are the places of the worst draws by the name of the figure. `lost` are the draws without an answer, with
    the reason of the first; `unstable` are those at which the loop is not stable.
    """

    theta: Array
    x: Array
    p: Array
    worst: Mapping[str, int]
    lost: int
    reason: str
    unstable: tuple[int, ...]

    def __len__(self) -> int:
        return len(self.theta)


def search_box(
    linear: LinearLoop,
    box: ParameterBox,
    limits: Sequence[Limit],
    answer: tuple[str, str] | None,
    draws: int,
    seed: int,
) -> BoxSearch:
    """Corners, the middle and a Sobol sample of the box, then steps along each number from the worst draw of each limit.

    The same seed gives the same draws.
    """
    grid = RowGrid.of(linear, answer)
    u = _first_draws(len(box.labels), draws, seed)
    parts = [_judged(linear, box, limits, grid, u)]
    best = {limit.kind.name: (u[k], parts[0].excess[i, k]) for i, limit in enumerate(limits) for k in [int(np.argmax(parts[0].excess[i]))]}
    for round_ in range(ROUNDS):
        step = FIRST / 2**round_
        tried = np.unique(np.concatenate([_neighbours(point, step) for point, _ in best.values()]), axis=0)
        found = _judged(linear, box, limits, grid, tried)
        parts.append(found)
        for i, limit in enumerate(limits):
            k = int(np.argmax(found.excess[i]))
            if found.excess[i, k] > best[limit.kind.name][1]:
                best[limit.kind.name] = tried[k], found.excess[i, k]
    return _search(parts, limits)


def at_draw(linear: LinearLoop, search: BoxSearch, place: int) -> LinearLoop:
    """The linear loop at one draw of a search."""
    return about(replace(linear.point, x=search.x[place], p=search.p[place]))


@dataclass(frozen=True, eq=False)
class _Draws:
    """Draws with the excess (k, N) of each limit: positive beyond it, infinite where unstable, -inf without an answer."""

    theta: Array
    x: Array
    p: Array
    excess: Array
    lost: Array
    unstable: Array
    reason: str


def _judged(linear: LinearLoop, box: ParameterBox, limits: Sequence[Limit], grid: RowGrid, u: Array) -> _Draws:
    theta = box.at(u)
    rows = linear.rows(box.columns(theta))
    values = row_figures(rows, [limit.kind.name for limit in limits], grid, linear)
    lost = rows.flagged
    unstable = ~rows.stable & ~lost
    excess = np.stack([_excess(limit, values[limit.kind.name]) for limit in limits])
    excess = np.where(lost, -np.inf, np.where(unstable, np.inf, excess))
    return _Draws(theta, rows.x, rows.p, excess, lost, unstable, next(iter(rows.reasons.values()), ""))


def _excess(limit: Limit, values: Array) -> Array:
    """The distance beyond a limit, negative within; -inf where a figure is no number."""
    with np.errstate(invalid="ignore"):
        excess = -np.minimum(values - limit.low, limit.high - values)
    return np.where(np.isnan(excess), -np.inf, excess)


def _first_draws(d: int, draws: int, seed: int) -> Array:
    """The middle, the corners of a box of few numbers, and a scrambled Sobol sample, in the unit cube."""
    from scipy.stats import qmc  # costs half a second, and only those who search

    sample = qmc.Sobol(d, rng=np.random.default_rng(seed)).random_base2(max(1, (draws - 1).bit_length()))
    middle = np.full((1, d), 0.5)
    corners = np.stack(np.meshgrid(*[[0.0, 1.0]] * d, indexing="ij"), axis=-1).reshape(-1, d) if d <= MOST_CORNERS else np.round(sample)
    return np.asarray(np.concatenate([middle, corners, sample[:draws]]))


def _neighbours(u: Array, step: float) -> Array:
    moves = np.concatenate([step * np.eye(len(u)), -step * np.eye(len(u))])
    return np.asarray(np.clip(u + moves, 0, 1))


def _search(parts: Sequence[_Draws], limits: Sequence[Limit]) -> BoxSearch:
    theta, x, p, lost, unstable = (
        np.concatenate([getattr(part, name) for part in parts]) for name in ("theta", "x", "p", "lost", "unstable")
    )
    excess = np.concatenate([part.excess for part in parts], axis=1)
    worst = {limit.kind.name: int(np.argmax(excess[i])) for i, limit in enumerate(limits)}
    reason = next((part.reason for part in parts if part.reason), "")
    return BoxSearch(theta, x, p, worst, int(lost.sum()), reason, tuple(np.flatnonzero(unstable).tolist()))

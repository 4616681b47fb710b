"""The search of a box for the draws of a loop at which its figures come nearest to their limits, or break them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.linear.switching_functions import Mask
from workbench.design.linear_loop import LinearLoop, LinearRows
from workbench.design.linear_loop.loop_linearization import linear_loop_about
from workbench.design.loop_boxes import ParameterBox
from workbench.study.specifications.limits import FigureLimit
from workbench.study.specifications.loop_systems import LoopSystems
from workbench.study.specifications.point_figures import point_figure
from workbench.study.specifications.row_figures import RowGrid, row_figures

MOST_CORNERS = 8  # numbers of a box whose corners are all tried
FEW, DIGITS = 24, 6  # draws that are looked at one by one; significant digits of the numbers of a witness
ROUNDS, FIRST = 8, 0.25  # of the refinement, and its first step as a share of the box; each is half the one before


@dataclass(frozen=True, eq=False)
class BoxSearch:
    """The draws of a search: parameters theta (N, d) and rest states x (N, nx), and the worst draw of each figure.

    `worst` are the places of the worst draws by the name of the figure. `lost_draws` are the draws without an answer,
    with the reason of the first; `unstable_draws` are those at which the loop is not stable.
    """

    theta: Array
    x: Array
    p: Array
    worst: Mapping[str, int]
    lost_draws: int
    reason: str
    unstable_draws: tuple[int, ...]

    def __len__(self) -> int:
        return len(self.theta)


def search_box(
    linear: LinearLoop,
    box: ParameterBox,
    limits: Sequence[FigureLimit],
    answer: tuple[str, str] | None,
    draws: int,
    seed: int,
) -> BoxSearch:
    """The middle, corners and a Sobol sample of a box, then steps along each number from the worst draw of each limit.

    The same seed gives the same draws. A loop with a delay, whose draws are looked at one by one, has few of them.
    """
    late = bool(linear.models.delays.any())
    grid = None if late else RowGrid.of(linear, answer)
    task = _Task(linear, box, limits, grid, answer)
    u = _first_draws(len(box.labels), min(draws, FEW) if late else draws, seed)
    parts = [task.judge_draws(box.at(u))]
    best = [(u[int(np.argmax(row))], float(row.max())) for row in parts[0].excess]
    for round_ in range(0 if late else ROUNDS):
        tried = np.unique(np.concatenate([_neighbours(point, FIRST / 2**round_) for point, _ in best]), axis=0)
        parts.append(task.judge_draws(box.at(tried)))
        for i, row in enumerate(parts[-1].excess):
            k = int(np.argmax(row))
            if row[k] > best[i][1]:
                best[i] = tried[k], float(row[k])
    parts.append(task.judge_draws(_shortened(box, box.at(np.array([point for point, _ in best])))))
    return _search(parts, limits)


def at_draw(linear: LinearLoop, search: BoxSearch, place: int) -> LinearLoop:
    """The linear loop at one draw of a search."""
    return linear_loop_about(replace(linear.point, x=search.x[place], p=search.p[place]))


@dataclass(frozen=True, eq=False)
class _Draws:
    """Draws with the excess (k, N) over each limit: infinite where unstable, -inf without an answer."""

    theta: Array
    x: Array
    p: Array
    excess: Array
    lost: Mask
    unstable: Mask
    reason: str


@dataclass(frozen=True, eq=False)
class _Task:
    """The limits on a loop whose parameters vary; without a grid its draws are looked at one by one."""

    linear: LinearLoop
    box: ParameterBox
    limits: Sequence[FigureLimit]
    grid: RowGrid | None
    answer: tuple[str, str] | None

    def judge_draws(self, theta: Array) -> _Draws:
        """Draws (N, d) with the excess of each limit."""
        rows, names = self.linear.rows(self.box.columns(theta)), [limit.kind.name for limit in self.limits]
        lost = rows.flagged_rows
        if self.grid is None:
            values, stable = self._one_by_one(rows, names)
        else:
            values, stable = row_figures(rows, names, self.grid, self.linear), rows.stable
        unstable = ~stable & ~lost
        excess = np.stack([_excess(limit, values[limit.kind.name]) for limit in self.limits])
        excess = np.where(lost, -np.inf, np.where(unstable, np.inf, excess))
        return _Draws(theta, rows.x, rows.p, excess, lost, unstable, next(iter(rows.reasons.values()), ""))

    def _one_by_one(self, rows: LinearRows, names: Sequence[str]) -> tuple[dict[str, Array], Mask]:
        values: dict[str, Array] = {name: np.full(len(rows), np.nan) for name in names}
        stable: Mask = np.zeros(len(rows), dtype=bool)
        for i in np.flatnonzero(~rows.flagged_rows):
            own = LoopSystems(linear_loop_about(replace(self.linear.point, x=rows.x[i], p=rows.p[i])), self.answer)
            stable[i] = own.stable
            for name in names if stable[i] else ():
                figure = point_figure(name, own).value
                values[name][i] = np.nan if figure is None else figure.value
        return values, stable


def _excess(limit: FigureLimit, values: Array) -> Array:
    """The distance beyond a limit, negative within; -inf where a figure is no number."""
    with np.errstate(invalid="ignore"):
        excess = -np.minimum(values - limit.low, limit.high - values)
    return np.where(np.isnan(excess), -np.inf, excess)


def _first_draws(d: int, draws: int, seed: int) -> Array:
    """The middle, the corners of a box of few numbers, and a scrambled Sobol sample, in the unit cube."""
    from scipy.stats import qmc  # costs half a second, and only those who search

    sample = qmc.Sobol(d, rng=np.random.default_rng(seed)).random_base2(max(1, (draws - 1).bit_length()))
    middle = np.full((1, d), 0.5)
    corners = (
        np.stack(np.meshgrid(*[[0.0, 1.0]] * d, indexing="ij"), axis=-1).reshape(-1, d)
        if d <= MOST_CORNERS
        else np.round(sample)
    )
    return np.asarray(np.concatenate([middle, corners, sample[:draws]]))


def _shortened(box: ParameterBox, theta: Array) -> Array:
    """The draws with as few digits as a reader copies, within the box."""
    short = np.array([[float(f"{value:.{DIGITS}g}") for value in row] for row in theta])
    return np.asarray(np.clip(short, box.low, box.high))


def _neighbours(u: Array, step: float) -> Array:
    moves = np.concatenate([step * np.eye(len(u)), -step * np.eye(len(u))])
    return np.asarray(np.clip(u + moves, 0, 1))


def _search(parts: Sequence[_Draws], limits: Sequence[FigureLimit]) -> BoxSearch:
    theta, x, p, lost, unstable = (
        np.concatenate([getattr(part, name) for part in parts]) for name in ("theta", "x", "p", "lost", "unstable")
    )
    excess = np.concatenate([part.excess for part in parts], axis=1)
    first, worst = excess.shape[1] - len(limits), {}
    for i, limit in enumerate(limits):
        place, short = int(np.argmax(excess[i])), first + i
        kept = excess[i, short] > -np.inf and (excess[i, short] > 0) == (excess[i, place] > 0)
        worst[limit.kind.name] = short if kept else place
    reason = next((part.reason for part in parts if part.reason), "")
    return BoxSearch(theta, x, p, worst, int(lost.sum()), reason, tuple(np.flatnonzero(unstable).tolist()))

"""Trajectories from which a search starts: straight lines between what is known, and random ones about them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.planning.trajectories.plan_problem import INF, PlanProblem
from workbench.planning.trajectories.plan_values import ArcValues, Values, linear_inner

RANDOM_SPREAD = 0.5  # of a random guess, over the size of a state or input
KNOTS = 5  # of a random guess


def guess(
    problem: PlanProblem,
    counts: tuple[int, ...],
    sizes: Array,
    rows: Mapping[int, Array],
    rng: np.random.Generator | None = None,
) -> Values:
    """A first trajectory: straight lines between boundary values, or, with a generator, random about them.

    `sizes` (nx + nu,) are those of states and inputs; `rows` has, by place, values of the user's at even times.
    """
    lines = _corner_values(problem, sizes)
    arcs = []
    for i, (phase, count) in enumerate(zip(problem.phases, counts, strict=True)):
        nodes = np.linspace(0.0, 1.0, count + 1)
        values = lines[i] + nodes[:, None] * (lines[i + 1] - lines[i])
        for place, row in rows.items():
            whole = (i + nodes) / len(counts)
            values[:, place] = np.interp(whole, np.linspace(0.0, 1.0, len(row)), row)
        T = _duration(*phase.duration, rng)
        if rng is not None:
            knots = rng.normal(size=(KNOTS, len(sizes))) * RANDOM_SPREAD * sizes
            at = np.linspace(0.0, 1.0, KNOTS)
            values += np.column_stack([np.interp(nodes, at, knots[:, j]) for j in range(len(sizes))])
        low = np.concatenate([phase.x.low, phase.u.low])
        high = np.concatenate([phase.x.high, phase.u.high])
        values = np.minimum(np.maximum(values, low), high)
        x, u = values[:, : problem.nx], values[:, problem.nx :]
        held = (u[:-1] + u[1:]) / 2 if problem.hold == "zero" else u
        arcs.append(ArcValues(np.full(count, 1.0 / count), T, x, linear_inner(x), held))
    return tuple(arcs)


def _duration(low: float, high: float, rng: np.random.Generator | None) -> float:
    """A duration between its ends: near the lower one, as baselines take it, or random."""
    if low >= high:
        return low
    top = min(high, 4 * low + 4)
    if rng is None:
        return (low + top) / 2
    least = max(low, 1e-3 * top)
    most = top if high == INF else min(high, 10 * top)
    return float(np.exp(rng.uniform(np.log(least), np.log(most))))


def _corner_values(problem: PlanProblem, sizes: Array) -> Array:
    """States and inputs (phases + 1, nx + nu) at the begin and at the end of each phase."""
    size, box = len(sizes), problem.box
    middle = _middle(box.low, box.high)
    known = np.full((len(problem.phases) + 1, size), np.nan)
    for row, ends in enumerate([problem.start, *(phase.end for phase in problem.phases)]):
        fixed = np.isfinite(ends.low) & np.isfinite(ends.high)
        known[row, fixed] = (ends.low[fixed] + ends.high[fixed]) / 2
    for j in range(size):
        rows = np.flatnonzero(np.isfinite(known[:, j]))
        every = np.arange(len(known))
        known[:, j] = np.interp(every, rows, known[rows, j]) if len(rows) else middle[j]
    known[:, problem.nx :] = np.where(np.isfinite(known[:, problem.nx :]), known[:, problem.nx :], middle[problem.nx :])
    return known


def _middle(low: Array, high: Array) -> Array:
    """Zero within the limits, else the value between them that is nearest to it, or the middle."""
    inside = (low <= 0) & (high >= 0)
    both = np.isfinite(low) & np.isfinite(high)
    with np.errstate(invalid="ignore"):
        middle = np.where(both, (low + high) / 2, np.where(np.isfinite(low), low, high))
    return np.where(inside & ~both, 0.0, np.where(np.isfinite(middle), middle, 0.0))

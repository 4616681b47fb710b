"""The pilot: a few runs that choose method and step for each part of the horizon, for a whole batch to reuse.

A candidate, a method and a step, is run over one cell of time from the state of a fine RK4 run, and
compared with that run at the cell's end: for each pilot run the largest error of a state relative to the
largest value that the state has in the run, then the mean over the runs. Integrals of metrics are states;
the memory of sampled metrics is not asked. A step beyond nine tenths of the stability limit of the pilot
run with the fastest modes is no candidate. A cell with a candidate within its equal share of the tolerance
is tried with no smaller step; of all that was tried, what is cheapest in sum is taken.

The errors of one cell fade or grow in those behind it, and other runs have other errors: what the metrics
of a batch got is told by `accuracy.check_by_halving`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property, lru_cache, partial

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Rule, Step
from workbench.simulate.request import rows_of
from workbench.simulate.stepping.cells import cells_of, lost
from workbench.simulate.stepping.schedule import Make, Schedule, march, step_of
from workbench.simulate.stepping.stability import longest_steps, modes_at
from workbench.validation.refusals import Array, Integers, several, whole
from workbench.validation.signatures import door

METHODS = ("rk4", "rkc3", "rkc5", "rkc10")
INSTANTS = 50  # at which the Jacobian is looked at, over the horizon
MARGIN = 0.9  # of the stability limit: other runs, and other instants, have faster modes
NOTHING = 1e-9  # a state that stays below it, in its unit, is as good as zero
RUNS = 16
ROOM = 1 / 3  # the part of the tolerance that cells may take for which no smaller step was tried

Candidate = tuple[str, int]  # a method, and its steps a cell


@dataclass(frozen=True)
@door
class Choice:
    """A schedule with the tolerance that was asked for, and the sum of local errors that the pilot found.

    Attributes
    ----------
    tolerance, error
        Relative to the size of each state, an integral's being its value at the horizon.
    runs
        How many pilot runs told the error; one that diverges tells none.
    """

    schedule: Schedule
    tolerance: float
    error: float
    runs: int

    def __str__(self) -> str:
        """The choice in a sentence, and a line for each segment."""
        return (
            f"Local errors of {self.error:.1e} in sum, tolerance {self.tolerance:g}, told by {self.runs} pilot runs."
            f"\n{self.schedule}"
        )


def pilot_runs(p: Array, x0: Array, count: int = RUNS) -> Integers:
    """Which `count` of the B runs of a batch serve as its pilots: evenly spaced in the order of their numbers."""
    rows = np.hstack([p, x0])
    rows = rows[:, (rows != rows[:1]).any(axis=0)]
    order = np.lexsort(rows.T[::-1]) if rows.size else np.arange(len(p))
    return np.asarray(order[np.unique(np.linspace(0, len(p) - 1, min(count, len(p))).round().astype(int))])


@door
def pilot_rows(p: Array, x0: Array, count: int = RUNS) -> tuple[Array, Array]:
    """The rows of the runs that `pilot_runs` picks: the same in whatever order the batch is."""
    if not (p.ndim == x0.ndim == 2 and len(p) == len(x0) > 0):
        raise ValueError(f"`pilot_rows(p, x0)` takes rows (B, np) and (B, nx); got shapes {p.shape} and {x0.shape}.")
    picked = pilot_runs(p, x0, whole("pilot_rows(count=...)", count))
    return p[picked], x0[picked]


@door
def choose(
    make: Make,
    p: Array,
    x0: Array,
    until: float,
    tolerance: float,
    *,
    cell: float | None = None,
    grid: float | None = None,
    methods: Sequence[str] = METHODS,
    arithmetic: str | None = None,
) -> Choice:
    """The cheapest schedule whose local errors, as a few runs find them, add up to no more than the tolerance.

    Parameters
    ----------
    make
        (method, h) -> the step of length h by that method, metrics included, for each name in `methods`
        and "rk4". Where it remembers its steps, a second choice does not compile them again.
    p, x0
        (R, np) and (R, nx), the pilot runs, as `pilot_rows` takes them from a batch: about 16.
    until, cell
        The horizon, and the length of what a method and a step are chosen for, in s; without it the
        horizon has about a hundred cells.
    grid, arithmetic
        The sample time in s of metrics that look at the loop at times of their own, which every step divides; and as
        of `simulate`.

    Raises
    ------
    ValueError
        If there are no runs or methods, a number is not positive and finite, the horizon is no multiple of
        the cell or the cell none of the grid, the loop is noisy, no pilot run stays finite, or no candidate
        reaches the tolerance.
    """
    cells, make = cells_of(until, tolerance, cell, grid), cache(partial(step_of, "choose", make))
    finest = make("rk4", cells.length / cells.references[0])
    p, x0 = _checked(finest, p, x0, methods)
    found = None
    for place, fine in enumerate(cells.references):
        pilot = _Pilot.of(make, p, x0, cells.length, cells.count, fine, arithmetic)
        found = pilot and _search(pilot, methods, cells.divisors, cells.references[place:], tolerance)
        if pilot and found and found[1] <= tolerance:
            return Choice(Schedule.of(cells.length, found[0]), tolerance, found[1], len(pilot.p))
    if not found:
        raise lost(len(p), until, cells.length / cells.references[-1])
    raise ValueError(
        f"`choose(tolerance={tolerance:g})` is not reached: steps down to {cells.length / cells.divisors[-1]:g} s "
        f"leave local errors of {found[1]:.1e} in sum. Where a law switches, smaller steps help little: ask for less."
    )


def _checked(step: Step, p: Array, x0: Array, methods: Sequence[str]) -> tuple[Array, Array]:
    """The pilot rows; what no schedule can be chosen for is refused."""
    several("choose(methods=...)", methods, str, 1)
    if step.noises:
        raise ValueError("`choose(make=...)` must make steps without noise, whose error a smaller step would show.")
    if not (p.ndim == x0.ndim == 2 and len(p) == len(x0) > 0):
        raise ValueError(f"`choose(p, x0)` takes rows (R, np) and (R, nx) of pilots; got shapes {p.shape}, {x0.shape}.")
    return rows_of("choose", step, p, x0)


@dataclass(frozen=True, eq=False)
class _Pilot:
    """Pilot runs along RK4 of `fine` steps a cell, x (R, cells + 1, nx): candidates start from its states."""

    make: Make
    p: Array
    x: Array
    cell: float
    fine: int
    arithmetic: str | None

    @staticmethod
    def of(
        make: Make, p: Array, x0: Array, cell: float, cells: int, fine: int, arithmetic: str | None
    ) -> _Pilot | None:
        """The runs that stay finite, if any does."""
        x = np.empty((len(x0), cells + 1, x0.shape[1]))
        x[:, 0] = x0
        march(make("rk4", cell / fine), x, p, fine, arithmetic)
        finite = np.isfinite(x).all(axis=(1, 2))
        return _Pilot(make, p[finite], x[finite], cell, fine, arithmetic) if finite.any() else None

    def step(self, candidate: Candidate) -> Step:
        """The step of a candidate."""
        method, n = candidate
        return self.make(method, self.cell / n)

    def cost(self, candidate: Candidate) -> float:
        """Operations in a cell."""
        return float(candidate[1] * self.step(candidate).operations)

    def ends(self, candidate: Candidate, at: Integers) -> Array:
        """Where a candidate arrives from the beginning of each of the cells `at`, (R, len(at), nx)."""
        runs, _, nx = self.x.shape
        rows = np.empty((runs * len(at) + 1, 2, nx))
        rows[:-1, 0] = self.x[:, at].reshape(-1, nx)
        p = np.column_stack([np.repeat(self.p, len(at), axis=0), np.tile(at * float(candidate[1]), runs)])
        # one run more at another time, so that time always differs from run to run: that is one kernel
        rows[-1, 0] = rows[0, 0]
        p = np.vstack([p, [*p[0, :-1], p[0, -1] + 1]])
        march(movable(self.step(candidate)), rows, p, candidate[1], self.arithmetic)
        return np.asarray(rows[:-1, 1].reshape(runs, len(at), nx))

    def errors(self, candidate: Candidate, at: Integers, ends: Array) -> Array:
        """The errors of a candidate in the cells `at` against the true ends of all, (R, cells, nx); else infinite."""
        error = np.full(ends.shape[1], np.inf)
        if len(at):
            flow = self.step(candidate).flow.states.size
            size = np.maximum(np.abs(self.x[..., :flow]).max(axis=1), NOTHING)[:, np.newaxis]
            with np.errstate(all="ignore"):
                off = np.abs(self.ends(candidate, at) - ends[:, at])[..., :flow] / size
            error[at] = np.nan_to_num(off.max(axis=2).mean(axis=0), nan=np.inf, posinf=np.inf)
        return error

    def limit(self, candidate: Candidate) -> Array:
        """The longest stable step of a candidate's method in each cell, (cells,)."""
        at, modes = self.modes
        limit = np.min(longest_steps(modes, self.step(candidate).amplification), axis=1, initial=np.inf)
        cells = np.arange(self.x.shape[1] - 1)
        return np.asarray(MARGIN * limit[np.abs(cells[:, np.newaxis] - at).argmin(axis=1)])

    @cached_property
    def modes(self) -> tuple[Integers, Array]:
        """Some cells (n,) and the modes at their beginning (n, m), of the run with the fastest at a few instants."""
        runs, cells = len(self.x), self.x.shape[1] - 1
        few, at = (np.unique(np.linspace(0, cells, n).round().astype(int)) for n in (3, INSTANTS))
        sizes = np.abs(self._modes(np.tile(few, runs), np.repeat(np.arange(runs), len(few)))).max(axis=1, initial=0)
        stiffest = int(np.nan_to_num(sizes).argmax()) // len(few)
        modes = self._modes(at, np.full(len(at), stiffest))
        finite = np.isfinite(modes).all(axis=1)
        return (at[finite], modes[finite]) if finite.any() else (at[:1], np.zeros((1, 1)))

    def _modes(self, at: Integers, run: Integers) -> Array:
        flow = self.step(("rk4", self.fine)).flow
        return modes_at(flow, np.asarray(at * self.cell), self.x[run, at], self.p[run])


def movable(step: Step) -> Step:
    """The same step with a parameter more: the number of the step that is its first."""
    more = Layout((Entry("begin", np.zeros(())),))
    return replace(step, parameters=step.parameters + more, rule=_movable(step.rule))


@lru_cache(maxsize=128)
def _movable(rule: Rule) -> Rule:
    begin = ca.SX.sym("begin")
    after = ca.substitute(rule.next, rule.k, rule.k + begin)
    return replace(rule.written_out, p=ca.vertcat(rule.p, begin), update=after)


def _search(
    pilot: _Pilot, methods: Sequence[str], divisors: Sequence[int], references: Sequence[int], tolerance: float
) -> tuple[list[Candidate], float] | None:
    """A candidate for each cell and the sum of their errors; None if the cells ask for a finer pilot.

    Larger steps come first. The few cells that need a smaller one than the pilot can judge get a finer
    end to be compared with.
    """
    ends = pilot.x[:, 1:].copy()
    cells, share, least = ends.shape[1], tolerance / ends.shape[1], divisors[0]
    limits = {m: pilot.limit((m, least)) for m in ("rk4", *methods)}
    coarse = pilot.fine != references[-1]
    if coarse and (pilot.cell / pilot.fine > limits["rk4"]).any():
        return None
    tried: dict[Candidate, Array] = {}
    best, done = np.full(cells, np.inf), 0
    for fine in references:
        late = np.flatnonzero(best > share)
        if fine != pilot.fine:
            ends[:, late] = pilot.ends(("rk4", fine), late)
        for n in (n for n in divisors if done < n <= fine // 2):
            late = np.flatnonzero(best > share)
            for m in methods:
                tried[m, n] = pilot.errors((m, n), late[pilot.cell / n <= limits[m][late]], ends)
            best = np.minimum(best, np.min([tried[m, n] for m in methods], axis=0))
        done, late = fine // 2, np.flatnonzero(best > share)
        if coarse and fine == pilot.fine and len(late) > cells / 2:
            return None
        if best[late].sum() <= ROOM * tolerance:
            break
    errors = np.array(list(tried.values()))
    picked = cheapest(np.array([pilot.cost(c) for c in tried]), errors, tolerance)
    return [list(tried)[i] for i in picked], float(errors[picked, np.arange(cells)].sum())


def cheapest(costs: Array, errors: Array, tolerance: float) -> Array:
    """For each cell one candidate, so that the errors add up to the tolerance at about the least cost.

    What an error is worth, in operations, is the same in all cells: the least worth that keeps the
    tolerance is found by bisection. Where none does, it is the candidate of the smallest error.

    Parameters
    ----------
    costs, errors
        (C,) and (C, cells); an error of a candidate that was not tried is infinite.
    """
    costs, errors = costs / costs.min(), np.where(np.isfinite(errors), errors / tolerance, 1e30)

    def picked(worth: float) -> Array:
        return np.asarray(np.argmin(costs[:, np.newaxis] + worth * errors, axis=0))

    def keeps(choice: Array) -> bool:
        return bool(errors[choice, np.arange(errors.shape[1])].sum() <= 1)

    choice = np.asarray(np.argmin(errors, axis=0))
    low, high = -12.0, 12.0
    for _ in range(50 if keeps(choice) else 0):
        middle = (low + high) / 2
        attempt = picked(10**middle)
        if keeps(attempt):
            choice, high = attempt, middle
        else:
            low = middle
    return choice

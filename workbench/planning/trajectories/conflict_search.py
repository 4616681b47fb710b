"""Which limits and boundary values of a plan conflict: the least violation, and a set from which none can be left out.

A deletion filter (Chinneck and Dravnieks 1991) over elastic programs: each item may be violated by a slack at a price,
and is dropped where the others conflict without it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import casadi as ca
import numpy as np

from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.planning.trajectories.ipopt_solver import GOOD, QUIET
from workbench.planning.trajectories.marching import defects, march
from workbench.planning.trajectories.passed_limits import limited_signals
from workbench.planning.trajectories.plan_items import ItemRows, PlanItem, item_rows
from workbench.planning.trajectories.plan_values import Values
from workbench.planning.trajectories.transcription import Transcription

FEASIBLE = 1e-5  # sum of all violations, each over the size of its item, below which there is none
CALM = 1e-7  # weight of the squares of all variables, which keeps those at bay on which nothing depends
PRICED = 1e-4  # multiplier of an item, of 1, above which it takes part in a conflict
MOST = 120  # iterations
CHEAP = 1e-3  # price of an item that is left out, which keeps it from being violated without need
TRUE = 0.01  # miss of a node, as a share of the range of a state, up to which a trajectory on a coarse mesh is one
PASSED = 0.05  # of the scale of a signal, by which it may be passed between the points of a coarse mesh
FIRST = 0.1  # violation with which a search begins
ORDER = (
    "end",
    "limit",
    "rate limit",
    "periodic",
    "duration",
    "start",
)  # in which items are left out where either will do


class PlanConflictError(ValueError):
    """No trajectory meets all that was asked; the `items` conflict, and without any one of them the others can be met.

    That the others can be met is shown by a trajectory. That all together cannot is the outcome of searches from
    several starts, and no proof.

    Parameters
    ----------
    items
        The items that conflict.
    violation
        The least sum of violations, each over the size of its item.

    Examples
    --------
    >>> item = wb.planning.PlanItem("limit", "v", "high", 15.0)
    >>> wb.planning.PlanConflictError((item,), 0.1).items == (item,)
    True
    """

    @check_arguments
    def __init__(self, items: tuple[PlanItem, ...], violation: float) -> None:
        self.items, self.violation = items, violation
        names = ", ".join(f"'{item}'" for item in items)
        others = (
            "without any one of them the others can be met: widen one of them"
            if len(items) > 1
            else "it cannot be met by itself: change it"
        )
        ValueError.__init__(self, f"`plan(...)` found no trajectory, as these conflict: {names}; {others}.")


@dataclass(frozen=True, eq=False)
class ElasticProgram:
    """The program of a plan whose items may be violated at a price."""

    transcription: Transcription

    @cached_property
    def rows(self) -> tuple[ItemRows, ...]:
        """All items with their rows."""
        return tuple(item_rows(self.transcription))

    @cached_property
    def _solver(self) -> ca.Function:
        transcription, count = self.transcription, len(self.rows)
        slack, price = ca.MX.sym("slack", count), ca.MX.sym("price", count)
        periodic = len(transcription.problem.periodic)
        links = transcription.links[: transcription.links.numel() - periodic]
        hard = [links, *(ca.vec(terms.defects) for terms in transcription.terms)]
        soft = [rows.excess - slack[i] for i, rows in enumerate(self.rows)]
        calm = CALM * ca.sumsqr(transcription.w) / transcription.w.numel()
        program = {
            "x": ca.vertcat(transcription.w, slack),
            "p": price,
            "f": ca.dot(price, slack) + calm,
            "g": ca.vertcat(*hard, *soft),
        }
        options = {**QUIET, "ipopt.tol": 1e-8, "ipopt.max_iter": MOST, "ipopt.mu_init": 1.0}
        return ca.nlpsol("elastic", "ipopt", program, options)  # type: ignore[arg-type]  # the stub knows no MX here

    def solve(self, keeps: Sequence[bool], start: Array) -> tuple[float, Array, Array]:
        """The least violation of the items that are kept, their multipliers (items,), and the variables (nw,)."""
        keep = np.array(keeps, dtype=float)
        sizes = [rows.excess.numel() for rows in self.rows]
        hard = int(self._solver.size1_in("lbg")) - sum(sizes)
        low = np.concatenate([np.zeros(hard), np.full(sum(sizes), -np.inf)])
        lowest = np.full(start.size, -np.inf)
        for parts in self.transcription.split(lowest):
            parts[0][:] = 1e-4  # of a duration, which must not vanish
        answer = self._solver(
            x0=np.concatenate([start, np.full(len(keep), FIRST)]),
            p=np.where(keep > 0, 1.0, CHEAP),
            lbx=np.concatenate([lowest, np.zeros(len(keep))]),
            ubx=np.inf,
            lbg=low,
            ubg=0.0,
        )
        x, lam = np.array(answer["x"]).ravel(), np.array(answer["lam_g"]).ravel()
        ends = np.cumsum([hard, *sizes])
        loads = np.array([np.abs(lam[a:b]).sum() for a, b in pairwise(ends)])
        w = x[: start.size]
        solved = str(self._solver.stats()["return_status"]) in GOOD
        violation = float(keep @ x[start.size :]) if solved else float("nan")
        if violation <= FEASIBLE and not self._is_true(w, keeps):
            violation = float("nan")
        return violation, loads, w

    def _is_true(self, w: Array, keeps: Sequence[bool]) -> bool:
        """True if the simulator marches the trajectory, too, and it passes no limit by much between its points.

        Where no limit holds, a coarse mesh may invent a trajectory, and a long interval may hide one that passes.
        """
        problem, values = self.transcription.problem, self.transcription.unpack(w)
        runs = march(problem, values)
        kept = [rows for rows, keep in zip(self.rows, keeps, strict=True) if keep and rows.item.kind == "limit"]
        sizes = {(rows.item.phase, rows.item.label, rows.item.side): rows.size for rows in kept}
        for signal in limited_signals(problem, values, runs):
            for side, excess in (("low", signal.below), ("high", signal.above)):
                if excess > PASSED * sizes.get((signal.phase, signal.label, side), np.inf):
                    return False
        return bool(max(float(miss.max()) for miss in defects(values, runs)) <= TRUE)


def find_conflict(
    transcription: Transcription, starts: Sequence[Values], spares: Sequence[Values] = ()
) -> PlanConflictError | Values:
    """The conflict of a problem, or a trajectory that meets all that was asked.

    What is left by the filter is tried once more from the `spares`: if these meet it, the filter takes them as starts.

    Raises
    ------
    ValueError
        If no elastic program ends.
    """
    program = ElasticProgram(transcription)
    guesses, more = ([transcription.pack(one) for one in some] for some in (starts, spares))
    everything = [True] * len(program.rows)
    least, loads, w = _least(program, everything, guesses)
    if least <= FEASIBLE:
        return transcription.unpack(w)
    if np.isnan(least):
        raise ValueError(
            "`plan(...)` found no trajectory, and could not tell which limits conflict: IPOPT did not end even where "
            "each may be violated; look at the units and the guess, or take fewer `intervals`."
        )
    keeps = _filter(program, loads, [w, *guesses])
    for spare in more:
        if program.solve(keeps, spare)[0] <= FEASIBLE:
            keeps = _filter(program, loads, [w, spare, *guesses])
    items = tuple(rows.item for rows, keep in zip(program.rows, keeps, strict=True) if keep)
    return PlanConflictError(items, least)


def _filter(program: ElasticProgram, loads: Array, guesses: Sequence[Array]) -> list[bool]:
    """The items of a conflict from which none can be left out; one stays where no search tells."""
    priced = [bool(load > PRICED) for load in loads]
    keeps = priced if _least(program, priced, guesses)[0] > FEASIBLE else [True] * len(priced)
    order = sorted(range(len(keeps)), key=lambda i: (priced[i], ORDER.index(program.rows[i].item.kind), loads[i]))
    for i in (i for i in order if keeps[i]):
        trial = [keep and k != i for k, keep in enumerate(keeps)]
        if _least(program, trial, guesses)[0] > FEASIBLE:
            keeps = trial
    return keeps


def _least(program: ElasticProgram, keeps: Sequence[bool], guesses: Sequence[Array]) -> tuple[float, Array, Array]:
    """The least violation from some starts, NaN where none ends; the first below the threshold ends the search."""
    best: tuple[float, Array, Array] | None = None
    for guess in guesses:
        end = program.solve(keeps, guess)
        if best is None or not end[0] >= best[0]:
            best = end if best is None or not np.isnan(end[0]) else best
        if best[0] <= FEASIBLE:
            break
    assert best is not None
    return best

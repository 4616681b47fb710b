r"""Method, penalties and sweeps by a short tuning: the fewest operations that follow the exact law closely enough.

The spectrum chooses well where D is regular. With hard limits on states, or limits on inputs and their rates together,
rows depend on each other, D is singular and no spectrum bounds the sweeps. So the candidates, metrics of several
numbers of modes and ADMM with several penalties, run along sequences of states of the exact law, each with its own
memory. The one of fewest operations whose root mean square error of first moves is below the accuracy is taken.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array, finite
from workbench.core.validation.signatures import check_arguments
from workbench.design.matrices import DesignError
from workbench.planning.linear_mpc.dual_recursion import operation_count
from workbench.planning.linear_mpc.exact_solution import ExactMpc
from workbench.planning.linear_mpc.splitting import ADMM, SplittingNumbers, no_memory, solve_period
from workbench.planning.linear_mpc.splitting_metric import splitting_numbers

SWEEPS = (2, 3, 4, 6, 9, 14, 20, 40)
MODES = (0, 1, 2, 3, 4, 8, 16)
PENALTIES = (0.3, 1.0, 3.0, 10.0, 30.0)  # of inputs, in shares of R
OTHER_PENALTIES = (0.3, 3.0, 30.0, 300.0)  # of other rows, over the largest diagonal entry of D
RELAXATION = 1.6  # Boyd et al. (2011), section 3.4.3: between 1.5 and 1.8


@dataclass(frozen=True)
@show
class TuningRow:
    """A candidate: its method, its modes or penalties, sweeps, operations of a period, and error in spans."""

    method: str
    setting: str
    sweeps: int
    operations: int
    error: float


@dataclass(frozen=True, eq=False)
@show
class SplittingTuning:
    """The numbers of the best candidate, and the table of all."""

    numbers: SplittingNumbers
    table: tuple[TuningRow, ...]


@check_arguments
def tune_splitting(
    exact: ExactMpc, states: Array, moves: Array, *, accuracy: float = 1e-3, warm: bool = True
) -> SplittingTuning:
    """The constants of the law with the fewest operations that follow the exact law along sequences of states.

    Parameters
    ----------
    states, moves
        States (B, T, nx) that the exact law visits, and its moves (B, T, nu): `exact_loops` gives both.
    accuracy
        The root mean square error of a move, in spans of its limits.
    warm
        True if the first period of a sequence has the sweeps that it needs.

    Raises
    ------
    ValueError
        If the states and moves have other shapes.
    DesignError
        If no candidate is accurate enough.
    """
    sizes = np.shape(states)[:-1] + exact.problem.B.shape
    if len(sizes) != 4 or np.shape(states)[-1] != sizes[2] or np.shape(moves) != (*sizes[:2], sizes[3]):
        raise ValueError(
            "`tune_splitting(states=..., moves=...)` must be states (B, T, nx) and moves (B, T, nu), as `exact_loops` "
            f"returns them; got the shapes {np.shape(states)} and {np.shape(moves)}."
        )
    wanted = finite("tune_splitting(accuracy=...)", accuracy, low=1e-12, high=0.5)
    table, best = [], None
    for setting, numbers in _candidates(exact):
        for sweeps in SWEEPS:
            trial = replace(numbers, sweeps=sweeps)
            work = operation_count(trial).period
            if best is not None and work >= best[0]:
                break
            error = move_error(trial, states, moves, warm)
            table.append(TuningRow(trial.method, setting, sweeps, work, error))
            if error <= wanted:
                best = work, trial
                break
    if best is None:
        least = min(table, key=lambda row: row.error)
        raise DesignError(
            f"`tune_splitting(accuracy=...)`: no candidate follows the exact law to {wanted:g} spans; the nearest, "
            f"{least.method} with {least.setting} and {least.sweeps} sweeps, reaches {least.error:.1e}. Ask for less, "
            "or make limits on states soft."
        )
    return SplittingTuning(best[1], tuple(table))


def move_error(numbers: SplittingNumbers, states: Array, moves: Array, warm: bool) -> float:
    """The root mean square error of first moves along sequences of states (B, T, nx), in spans."""
    memory, errors, nu = no_memory(numbers, len(states)), [], moves.shape[-1]
    span = numbers.high[:nu] - numbers.low[:nu]
    span = np.where(np.isfinite(span), span, np.maximum(np.abs(moves).max(axis=(0, 1)), 1e-12))
    for k in range(states.shape[1]):
        answer = solve_period(numbers, memory, states[:, k], sweeps=100 if warm and k == 0 else None)
        memory = answer.memory
        errors.append((answer.u - moves[:, k]) / span)
    size = float(np.sqrt(np.mean(np.square(errors))))
    return size if np.isfinite(size) else np.inf


def _candidates(exact: ExactMpc) -> Iterator[tuple[str, SplittingNumbers]]:
    own = exact.numbers
    if not own.cones:
        yield f"{len(own.L)} modes", own
    for modes in MODES:
        if modes <= len(own.low) and not own.cones:
            yield f"{modes} modes", splitting_numbers(exact.problem, sweeps=1, modes=modes)
    for penalty in PENALTIES:
        others = OTHER_PENALTIES if exact.problem.rows.count > exact.problem.B.shape[1] else (1.0,)
        for other in others:
            yield f"penalties {penalty:g} and {other:g}", admm_numbers(exact, penalty, other)


def admm_numbers(exact: ExactMpc, penalty: float, other: float) -> SplittingNumbers:
    """The constants of ADMM with penalties of the inputs, in shares of R, and of other rows, over the diagonal of D."""
    problem, D = exact.problem, exact.numbers.matrix
    nu, nc = problem.B.shape[1], problem.rows.count
    stage = np.diag(D).reshape(problem.horizon, nc).max(axis=0) / other
    stage[:nu] = np.diag(np.linalg.inv(problem.R)) / penalty
    for cone in problem.rows.cones:  # one penalty for a cone, so that the nearest point is that of `cone_limits`
        stage[list(cone.rows)] = stage[list(cone.rows)].max()
    sigma = np.tile(stage, problem.horizon)
    G = np.linalg.solve(np.eye(len(D)) + D / sigma, D / sigma)
    none = np.zeros((len(D), 0)), np.zeros(0)
    return replace(
        exact.numbers,
        method=ADMM,
        matrix=G,
        sigma=sigma,
        W=none[0],
        L=none[1],
        cap=RELAXATION,
        contraction=float("nan"),
        is_proved=False,
    )

r"""The method, its penalties or modes, and the number of sweeps of a law, derived from closed loops of the exact law.

The spectrum of D bounds a sweep once the active rows are right, and says nothing of how long it takes to find them. So
each candidate runs along a sample of closed loops of the exact law with starts and steps. It has its own memory, and in
the first period the sweeps of any other. Candidates are metrics with several numbers of modes, and ADMM with several
penalties where metrics fail: with hard limits on states, or on inputs and their changes, rows depend on each other.
They are tried in the order of their operations, and ADMM behind all metrics where limits are on inputs alone: a metric
leaves out the stages at which nothing acts. The first whose largest error of a move is within the accuracy is taken, if
its own loops cost no more than that share above those of the exact law, there and in a second sample that no candidate
was chosen by. What it errs by in that one stands in the evidence. With cones, whose candidates are all of ADMM, it is
the best of those with as many operations: their penalties decide how soon the copies of an input in its limits and in
its cone agree. This is sampled, not proved.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array
from workbench.design.matrices import DesignError
from workbench.planning.linear_mpc.dual_recursion import operation_count
from workbench.planning.linear_mpc.exact_solution import ExactMpc
from workbench.planning.linear_mpc.infeasibility import MpcConflictError
from workbench.planning.linear_mpc.limit_sample import LimitSample
from workbench.planning.linear_mpc.splitting import METRIC, SplittingNumbers, no_memory, solve_period
from workbench.planning.linear_mpc.splitting_metric import splitting_numbers
from workbench.planning.linear_mpc.splitting_tuning import admm_numbers

# Two sweeps were enough for some samples, and lost loops of nonlinear plants.
SWEEPS = (3, 4, 5, 6, 8, 10, 12, 15, 20, 25, 30, 40, 60, 100)
MODES = (0, 1, 2, 3, 4, 6, 8)
PENALTIES, OTHER_PENALTIES = (0.3, 1.0, 3.0, 10.0, 30.0, 100.0), (0.3, 3.0, 30.0, 300.0, 3000.0)
OF_CONES = (0.1,)  # one more penalty of other rows
LARGEST = 1e6  # spans: a candidate that errs by more is lost


@dataclass(frozen=True)
@show
class SweepEvidence:
    """The sample from which a number of sweeps was derived, and the errors in it: sampled, not proved.

    Parameters
    ----------
    accuracy
        The largest error of a move that was allowed, in spans of the limits of its input.
    largest_error, rms_error
        Those of the law along the sample, in spans.
    other_error, other_rms_error
        The same along the second sample, by which the law was not chosen.
    loops, moves, other_loops, other_moves
        The numbers of closed loops of the exact law and of its moves, in the sample and in the second one.
    active_share
        The share of the periods of the sample in which a limit acts.
    largest_residual
        The largest residual before the last sweep that the law reported along the sample.
    cost_excess
        The largest relative excess of the cost of a loop under the law over the exact law's, from the starts of both.
    fall_error
        By how much the optimal cost falls less in a period of these loops than by the cost of the stage, at most, as a
        share of the cost of the start; infinite where a state has no solution. It is 0 under the exact law from a safe
        state.
    trials
        The number of candidates, each with a number of sweeps, that were tried before.
    """

    accuracy: float
    largest_error: float
    rms_error: float
    other_error: float
    other_rms_error: float
    loops: int
    moves: int
    other_loops: int
    other_moves: int
    active_share: float
    largest_residual: float
    cost_excess: float
    fall_error: float
    trials: int

    def __str__(self) -> str:
        return (
            f"largest error {self.largest_error:.1g} of a span in {self.moves} moves of {self.loops} loops, "
            f"{self.other_error:.1g} in {self.other_moves} moves of {self.other_loops} others; limits active in "
            f"{self.active_share:.0%} (sampled, not proved)"
        )


def choose_sweeps(
    exact: ExactMpc,
    samples: tuple[LimitSample, LimitSample],
    accuracy: float,
    count: int | None = None,
    modes: int | None = None,
) -> tuple[SplittingNumbers, SweepEvidence]:
    """The constants of the law with the fewest operations that is accurate enough along the first of two samples.

    With a number of sweeps, the constants of the candidate that errs the least; with one of modes, of metrics.

    Raises
    ------
    DesignError
        If no number of sweeps of a candidate is accurate enough.
    """
    sample, alone = samples[0], exact.problem.rows.count == exact.problem.B.shape[1]  # limits on inputs
    trials = [
        (alone and one.method != METRIC, operation_count(one).period, i, one)
        for i, numbers in enumerate(_candidates(exact, modes))
        for one in (replace(numbers, sweeps=sweeps) for sweeps in (SWEEPS if count is None else (count,)))
    ]
    least: tuple[float, SplittingNumbers] = (np.inf, exact.numbers)
    passed: tuple[float, int, SplittingNumbers] | None = None
    for done, (_, work, _, numbers) in enumerate(sorted(trials, key=lambda trial: trial[:3])):
        if passed is not None and (work > passed[1] or not exact.numbers.cones):
            return passed[2], evidence(exact, passed[2], samples, accuracy, done - 1)
        largest = float(errors_along(numbers, sample, stop=max(accuracy, min(least[0], 1.0)))[0].max())
        if largest <= accuracy and count is None and _costs_little(exact, numbers, samples, accuracy):
            passed = (largest, work, numbers) if passed is None or largest < passed[0] else passed
        if largest < least[0]:
            least = largest, numbers
    if passed is not None:
        return passed[2], evidence(exact, passed[2], samples, accuracy, len(trials))
    if count is not None:
        return least[1], evidence(exact, least[1], samples, accuracy, len(trials))
    raise DesignError(
        f"`predictive_design(accuracy=...)`: no number of sweeps up to {SWEEPS[-1]} follows the exact law to "
        f"{accuracy:g} spans along {len(sample.states)} sampled loops; the nearest, {least[1].sweeps} "
        f"{method_in_words(least[1])}, errs by {least[0]:.1g}. Ask for a larger `accuracy`, make limits of states soft "
        "by a smaller `soft_weight`, or give `sweeps` and judge runs by their `residual`."
    )


def evidence(
    exact: ExactMpc,
    numbers: SplittingNumbers,
    samples: tuple[LimitSample, LimitSample],
    accuracy: float,
    trials: int,
) -> SweepEvidence:
    """The errors of a law along two samples, and the excess of its cost in its own loops."""
    sample, others = samples
    errors, residual = errors_along(numbers, sample, stop=np.inf)
    other_errors, _ = errors_along(numbers, others, stop=np.inf)
    excess, states, moves = _own_loops(exact, numbers, sample)
    return SweepEvidence(
        accuracy,
        float(errors.max()),
        float(np.sqrt(np.mean(errors**2))),
        float(other_errors.max()),
        float(np.sqrt(np.mean(other_errors**2))),
        len(sample.states),
        sample.count,
        len(others.states),
        others.count,
        sample.active_share,
        residual,
        max(excess, _own_loops(exact, numbers, others)[0]),
        _fall_error(exact, states, moves),
        trials,
    )


def _costs_little(
    exact: ExactMpc, numbers: SplittingNumbers, samples: tuple[LimitSample, LimitSample], most: float
) -> bool:
    return all(_own_loops(exact, numbers, sample)[0] <= most for sample in samples)


def errors_along(numbers: SplittingNumbers, sample: LimitSample, stop: float) -> tuple[Array, float]:
    """The errors (periods, B, nu) of moves along a sample in spans, and the largest residual.

    They end with the period in which an error exceeds `stop`.
    """
    residual = 0.0
    memory, errors, nu = no_memory(numbers, len(sample.states)), [], sample.moves.shape[-1]
    span = numbers.high[:nu] - numbers.low[:nu]
    span = np.where(np.isfinite(span), span, np.maximum(np.abs(sample.moves).max(axis=(0, 1)), 1e-12))
    for k in range(sample.states.shape[1]):
        answer = solve_period(numbers, memory, sample.states[:, k])
        memory, residual = answer.memory, max(residual, float(np.max(answer.residual)))
        error = np.abs(answer.u - sample.moves[:, k]) / span
        if not (np.abs(memory) <= LARGEST * (1 + np.abs(numbers.Y).max())).all():
            error = np.full_like(error, np.inf)
        errors.append(error)
        if not error.max() <= stop:
            break
    return np.array(errors), residual


def _own_loops(exact: ExactMpc, numbers: SplittingNumbers, sample: LimitSample) -> tuple[float, Array, Array]:
    """The largest relative excess of cost of the law's own loops from the starts, their states, and their moves.

    Behind the end of a loop stands the cost of the LQR law.
    """
    problem, half = exact.problem, sample.states.shape[1] // 2
    x, memory = sample.states[:, 0], no_memory(numbers, len(sample.states))
    own = np.zeros(len(x))
    states, moves = [], []
    for _ in range(half):
        answer = solve_period(numbers, memory, x)
        own = own + _stage(exact, x, answer.u)
        states.append(x)
        moves.append(answer.u)
        memory, x = answer.memory, x @ problem.A.T + answer.u @ problem.B.T
    theirs = sum(_stage(exact, sample.states[:, k], sample.moves[:, k]) for k in range(half))
    end = sample.states[:, half - 1] @ problem.A.T + sample.moves[:, half - 1] @ problem.B.T
    costs = [np.asarray(cost + np.einsum("bi,ij,bj->b", e, problem.P, e)) for cost, e in ((own, x), (theirs, end))]
    excess = float((costs[0] / np.maximum(costs[1], 1e-300) - 1).max())
    return excess, np.stack(states, axis=1), np.stack(moves, axis=1)


def _fall_error(exact: ExactMpc, states: Array, moves: Array) -> float:
    """The largest lack of a fall of the optimal cost by that of a stage, as a share of the cost of the start."""
    stages = np.stack([_stage(exact, states[:, k], moves[:, k]) for k in range(states.shape[1])], axis=1)
    costs = np.array([[_optimal_cost(exact, x) for x in loop] for loop in states])
    lack = costs[:, 1:] - costs[:, :-1] + stages[:, :-1]
    return float(np.nan_to_num(lack / costs[:, :1], nan=np.inf).clip(min=0.0).max())


def _optimal_cost(exact: ExactMpc, x: Array) -> float:
    try:
        return exact.solve(x).objective
    except (MpcConflictError, DesignError):
        return float("nan")


def _stage(exact: ExactMpc, x: Array, u: Array) -> Array:
    """The costs (B,) of a stage, with those of soft limits."""
    problem, rows = exact.problem, exact.problem.rows
    y = x @ rows.F.T + u @ rows.E.T
    soft = rows.softness > 0
    over = np.maximum(np.maximum(y - rows.high, rows.low - y), 0.0)[:, soft]
    cost = np.einsum("bi,ij,bj->b", x, problem.Q, x) + np.einsum("bi,ij,bj->b", u, problem.R, u)
    return np.asarray(cost + (over**2 / rows.softness[soft]).sum(axis=1))


def _candidates(exact: ExactMpc, only: int | None) -> Iterator[SplittingNumbers]:
    """Metrics with several numbers of modes, and ADMM with several penalties; or the metric of one number of modes."""
    if only is not None:
        yield splitting_numbers(exact.problem, sweeps=1, modes=only)
        return
    own, nu = exact.numbers, exact.problem.B.shape[1]
    if not own.cones:  # of which a metric knows nothing
        yield own
    for modes in MODES:
        if modes <= len(own.low) and not own.cones:
            yield splitting_numbers(exact.problem, sweeps=1, modes=modes)
    others: tuple[float, ...] = OTHER_PENALTIES if exact.problem.rows.count > nu else (1.0,)
    others = OF_CONES + others if own.cones else others
    for penalty in PENALTIES:
        for other in others:
            yield admm_numbers(exact, penalty, other)


def method_in_words(numbers: SplittingNumbers) -> str:
    """The method of the sweeps."""
    return f"sweeps with {len(numbers.L)} modes" if numbers.method == METRIC else "sweeps of ADMM"

"""Speed at equal accuracy: what a run costs when its RMSE shall have a stated error."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, lru_cache

import numpy as np

from studies.performance.effort import Effort, alternated, our_rate, ours, rate, rows_of
from studies.performance.peers import casadi_cvodes
from studies.performance.peers.contract import Peer, Runner
from studies.performance.row import Row
from studies.performance.workload import STATES, loop, rmse
from workbench.core import Step, stepper
from workbench.simulate import simulate
from workbench.simulate.step_size import pilot_runs, step_for_tolerance
from workbench.validation.refusals import Array

TOLERANCES, OURS = (1e-9, 1e-2), (1e-7, 1e-1)  # of CVODES and of our pilot, where the one of an error is looked for
STEPS_A_DECADE = 24
CELLS = 100  # of the horizon: the longest steps


@lru_cache(maxsize=4)
def reference(horizon: float, fine: float, samples: int) -> Array:
    """The RMSE (B, 2) of the first so many runs at a step so fine that its own error does not count."""
    return ours(rows_of(samples), horizon, fine)


def error(found: Array, wanted: Array) -> float:
    """The median over runs of the relative error of the RMSE, of the worse joint of each; infinite if one is NaN."""
    both = min(len(found), len(wanted))
    worse = np.abs(found[:both] / wanted[:both] - 1).max(axis=1)
    return float(np.median(np.where(np.isnan(worse), np.inf, worse)))


def coarsest(error_of: Callable[[float], float], target: float, low: float, high: float) -> float:
    """The first of `high` and smaller settings, in small ratios down to `low`, whose error is within the target.

    Raises
    ------
    ValueError
        If there is none.
    """
    for setting in np.geomspace(high, low, 1 + round(STEPS_A_DECADE * np.log10(high / low))):
        if error_of(float(setting)) <= target:
            return float(setting)
    raise ValueError(f"`coarsest(target={target:g})` has a larger error at every setting down to {low:g}.")


@cache
def stepped(method: str, h: float) -> Step:
    """A step of W by a method, with the integrals that score it, as CVODES has them, and no sum over steps."""
    return stepper(method)(loop(), h)


def chosen(p: Array, horizon: float, tolerance: float) -> float:
    """The step that pilot runs of p (B, 40) choose for a tolerance, in s."""
    x0 = np.broadcast_to(STATES.default, (len(p), STATES.size))
    few = pilot_runs(p, x0)
    return step_for_tolerance(stepped, p[few], x0[few], horizon, tolerance, horizon / CELLS)


def through(h: float, p: Array, horizon: float) -> Array:
    """The RMSE (B, 2) of runs at a step of h [s]."""
    return rmse(simulate(stepped("rk4", h), p, until=horizon, every=horizon).x[:, -1], horizon)


def ours_at_equal_accuracy(target: float, effort: Effort) -> tuple[Runner, str]:
    """What runs W as fast as we can with that error of the RMSE, and how it does: by a pilot in each call.

    Its tolerance is looked for with the runs of a timed call, which it will see there.

    Raises
    ------
    ValueError
        If no tolerance reaches that error.
    """
    wanted, p = reference(effort.horizon, effort.fine, effort.samples), rows_of(effort.batch)

    def runner(tolerance: float) -> Runner:
        return lambda p: through(chosen(p, effort.horizon, tolerance), p, effort.horizon)

    def error_of(tolerance: float) -> float:
        try:
            h = chosen(p, effort.horizon, tolerance)
        except ValueError:  # no step keeps it
            return np.inf
        return error(through(h, p[: effort.samples], effort.horizon), wanted)

    try:
        tolerance = coarsest(error_of, target, *OURS)
    except ValueError as refusal:
        raise ValueError(
            f"`ours_at_equal_accuracy(target={target:g})` is reached by no tolerance of pilots."
        ) from refusal
    how = f"in calls of {effort.batch:,}, each with pilot runs, whose tolerance is {tolerance:.1e}"
    return runner(tolerance), how


def cvodes_row(target: float, bar: float, effort: Effort) -> Row:
    """CVODES against us, both at the coarsest setting that reaches the error."""
    wanted = reference(effort.horizon, effort.fine, effort.samples)
    p, many = rows_of(effort.samples), rows_of(effort.batch)
    tolerance = coarsest(
        lambda tolerance: error(casadi_cvodes.runner(effort.horizon, tolerance)(p), wanted), target, *TOLERANCES
    )
    theirs, (mine, how) = casadi_cvodes.runner(effort.horizon, tolerance), ours_at_equal_accuracy(target, effort)
    fast, slow = alternated(effort, lambda: rate(mine, many, effort), lambda: rate(theirs, p, effort))
    note = f"tolerance {tolerance:.1e}; ours {how}, {fast:,.0f} runs/s, error {error(mine(many), wanted):.1e}"
    return Row(cvodes_name(target), bar, slow, fast / slow, error=error(theirs(p), wanted), note=note)


def work_precision(
    settings: Sequence[float], runner: Callable[[float], Runner], effort: Effort
) -> list[tuple[float, float]]:
    """The error and the rate of what runs W at each setting that loses no run."""
    wanted = reference(effort.horizon, effort.fine, effort.samples)
    p, found = rows_of(effort.samples), []
    for each in map(runner, settings):
        wrong = error(each(p), wanted)
        if np.isfinite(wrong):
            found.append((wrong, rate(each, p, effort)))
    return found


def cvodes_name(target: float) -> str:
    """The row's name."""
    return f"CasADi CVODES at error {target:.0e}"


def peer_row(peer: Peer, effort: Effort) -> Row:
    """A peer at its settings against us at the step of W."""
    runner = peer.runner(effort.horizon)
    batches = np.split(rows_of(peer.runs * (1 + effort.repetitions)), 1 + effort.repetitions)
    found = [runner(batches[0])]  # whatever is compiled at the first call is compiled

    def theirs() -> float:
        results: list[Array] = []
        speed = rate(lambda p: results.append(runner(p)), batches[len(found)], effort)
        found.append(results[-1])
        return speed

    fast, slow = alternated(effort, lambda: our_rate(effort), theirs)
    wanted = reference(effort.horizon, effort.fine, effort.samples)
    return Row(peer.name, peer.bar, slow, fast / slow, error=error(np.concatenate(found), wanted))

"""Speed at equal accuracy: what a run costs when its RMSE shall have a stated error."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np

from workbench.bench.effort import Effort, alternated, our_rate, ours, rate, rows_of
from workbench.bench.peers import casadi_cvodes
from workbench.bench.peers.contract import Peer, Runner
from workbench.bench.row import Row
from workbench.core.layout import Array

STEPS, TOLERANCES = (1e-5, 5e-3), (1e-9, 1e-2)  # where the one of a stated error is looked for
STEPS_A_DECADE = 12


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


def ours_at_equal_accuracy(target: float, effort: Effort) -> tuple[Runner, str]:
    """What runs W as fast as we can with that error of the RMSE, and how it does: RK4 at one step for all.

    Whatever a call needs for its own runs, it does within the call, where it is timed.
    """
    wanted = reference(effort.horizon, effort.fine, effort.samples)
    p = rows_of(effort.samples)

    def whole(h: float) -> float:
        return effort.horizon / float(np.ceil(effort.horizon / h))

    h = whole(coarsest(lambda h: error(ours(p, effort.horizon, whole(h)), wanted), target, *STEPS))
    return lambda p: ours(p, effort.horizon, h), f"RK4 at {1e3 * h:.3g} ms"


def cvodes_row(target: float, bar: float, effort: Effort) -> Row:
    """CVODES against us, both at the coarsest setting that reaches the error."""
    wanted = reference(effort.horizon, effort.fine, effort.samples)
    p, many = rows_of(effort.samples), rows_of(effort.runs)
    tolerance = coarsest(
        lambda tolerance: error(casadi_cvodes.runner(effort.horizon, tolerance)(p), wanted), target, *TOLERANCES
    )
    theirs, (mine, how) = casadi_cvodes.runner(effort.horizon, tolerance), ours_at_equal_accuracy(target, effort)
    fast, slow = alternated(effort, lambda: rate(mine, many, effort), lambda: rate(theirs, p, effort))
    note = f"tolerance {tolerance:.1e}; ours {how}, {fast:,.0f} runs/s, error {error(mine(p), wanted):.1e}"
    return Row(cvodes_name(target), bar, slow, fast / slow, error=error(theirs(p), wanted), note=note)


def work_precision(
    settings: Sequence[float], runner: Callable[[float], Runner], effort: Effort
) -> list[tuple[float, float]]:
    """The error and the rate of what runs W at each setting that loses no run."""
    wanted = reference(effort.horizon, effort.fine, effort.samples)
    p, found = rows_of(effort.samples), []
    for run in map(runner, settings):
        wrong = error(run(p), wanted)
        if np.isfinite(wrong):
            found.append((wrong, rate(run, p, effort)))
    return found


def cvodes_name(target: float) -> str:
    """The row's name."""
    return f"CasADi CVODES at error {target:.0e}"


def peer_row(peer: Peer, effort: Effort) -> Row:
    """A peer at its settings against us at the step of W."""
    run = peer.runner(effort.horizon)
    batches = np.split(rows_of(peer.runs * (1 + effort.repetitions)), 1 + effort.repetitions)
    found = [run(batches[0])]  # whatever is compiled at the first call is compiled

    def theirs() -> float:
        results: list[Array] = []
        speed = rate(lambda p: results.append(run(p)), batches[len(found)], effort)
        found.append(results[-1])
        return speed

    fast, slow = alternated(effort, lambda: our_rate(effort), theirs)
    wanted = reference(effort.horizon, effort.fine, effort.samples)
    return Row(peer.name, peer.bar, slow, fast / slow, error=error(np.concatenate(found), wanted))

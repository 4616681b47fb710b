"""The change of the states of pilot runs, for which a step is chosen where no metric is asked for."""

from __future__ import annotations

import numpy as np

from workbench.engine.trajectories import Trajectories

NEGLIGIBLE = 1e-9  # a state that stays below it, in its unit, is as good as zero


def state_change(fine: Trajectories, coarse: Trajectories) -> tuple[float, str]:
    """The largest change of a state to half the step, relative to its largest value in the run, and its name.

    The memory of sampled metrics is not asked. Of a run that diverges nothing is; where every run diverges, the change
    is that of the times at which they do, in horizons.
    """
    lasts, states = ~fine.has_diverged, fine.step.flow.states
    if not lasts.any():
        off = np.abs(fine.diverged_at - coarse.diverged_at) / fine.t[-1]
        return float(np.nan_to_num(off, nan=np.inf).max()), "the time of a divergence"
    x, other = (runs.x[lasts, :, : states.size] for runs in (fine, coarse))
    size = np.maximum(np.abs(x).max(axis=1), NEGLIGIBLE)
    with np.errstate(all="ignore"):
        off = np.nan_to_num(np.abs(x - other).max(axis=1) / size, nan=np.inf)
    worst = int(np.argmax(off.max(axis=0)))
    return float(off.max()), f"'{states.labels[worst]}'"

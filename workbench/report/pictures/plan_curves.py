"""Plans of a predictive law over a run: what it foresaw of a signal at some of its instants."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np

from workbench.core.validation.refusals import whole
from workbench.core.validation.signatures import check_arguments
from workbench.study.document.figure import Series
from workbench.study.result_marks import changes_by_jumps, signal_source, time_source
from workbench.study.study import Outcome

MOST = 16  # plans over a run


@check_arguments
def plan_curves(outcome: Outcome, signal: str, number: int = 0, most: int = MOST) -> tuple[Series, ...]:
    """The plans of a signal at instants of a run that are a horizon apart, at most `most` of them.

    There are none if the law does not foresee the signal. A law foresees it if it records `predicted_t`, the times of
    the stages of a plan from now on in s, and `predicted_` with the name of the signal. There all stages of the first
    number stand first.

    Raises
    ------
    ValueError
        If `most` is no positive whole number.
    """
    most, name = whole("plan_curves(most=...)", most), f"predicted_{signal.removesuffix('_applied')}"
    outputs = outcome.measurement.trajectories.step.outputs
    if name not in outputs or "predicted_t" not in outputs:
        return ()
    size = outputs["predicted_t"].size
    spacing = float(outcome.signal("predicted_t", 1)[0])
    look: Literal["steps", "line"] = "steps" if changes_by_jumps(outcome, signal_source(outcome, signal)) else "line"
    horizon, until = spacing * (size - 1), float(outcome.t[-1])
    starts = np.arange(0.0, until, max(horizon, until / most))
    rows = np.searchsorted(outcome.t, starts - 1e-9 * until)
    plans: list[Series] = []
    for row in rows[np.isfinite(outcome.signal(name, number * size)[rows])].tolist():
        kept = (row, row + 1)
        source = replace(signal_source(outcome, name, number * size, kept), stages=size, spacing=spacing)
        y = np.array([outcome.signal(name, number * size + j)[row] for j in range(size)])
        x, label = outcome.t[row] + spacing * np.arange(size), "" if plans else "plans"
        plans.append(Series(label, x, y, "aid", look, (time_source(outcome, kept), source)))
    return tuple(plans)

"""The step responses of many rows of a linear loop at once, by the exponential of each row's matrix."""

from __future__ import annotations

import numpy as np

from workbench.core.validation.refusals import Array, positive
from workbench.design.linear.response_times import exact_responses, response_times, times_of
from workbench.design.linear.system_answers import showing_time
from workbench.design.linear_loop import LinearRows
from workbench.design.matrices import DesignError
from workbench.report.linear_loop_curves import signal_units
from workbench.report.linear_loop_responses import response_pairs

TIMES, MOST = 300, 2000  # of the slow modes, and how many more while fast ones last
LONGEST = 5000  # periods
RARE = 0.9  # of the rows settle within the time that is drawn

CALL = "LinearRows.plot('step')"


def row_steps(
    rows: LinearRows, until: float | None, inputs: str | None, outputs: str | None
) -> tuple[Array, Array, tuple[str, str, str]]:
    """The times (m,) in s and the responses (N, m) of one output to a step of one input; NaN in rows not stable.

    The last names are those of the input and of the output, and the unit of the output.

    Raises
    ------
    ValueError
        If there are several inputs or outputs, or `until` is not positive.
    DesignError
        If the loop has a delay, blocks that run at several periods, or would need too many periods.
    """
    if rows.models.delays.any() or rows.models.closed_model.count > 1:
        what = "a delay has infinitely many states" if rows.models.delays.any() else "blocks run at several periods"
        raise DesignError(f"`{CALL}` needs a model of one period and of finitely many states; here {what}.")
    pairs = response_pairs(rows, inputs, outputs)
    if len(pairs) != 1:
        words = ", ".join(f"{other} from {one}" for one, other in pairs)
        raise ValueError(f"`{CALL}` draws one response; there are {words}: choose one by `inputs` and `outputs`.")
    ((into, out),) = pairs
    model, h = rows.models.select_model(CALL, "closed", (into,), (out,)), rows.models.closed_model.period
    sound = np.flatnonzero(rows.stable & ~rows.flagged_rows)
    if not sound.size:
        raise DesignError(f"`{CALL}` draws stable rows; there is none.")
    if until is None:
        held = rows.poles[sound]
        poles = held if h is None else np.asarray(np.log(np.where(held == 0, 1e-3, held)) / h)
        until = float(np.quantile([showing_time(row, h) for row in poles], RARE))
    end = positive(f"{CALL[:-8]}(until=...)", until)
    if h is not None and end / h > LONGEST:
        raise DesignError(
            f"`{CALL}` draws up to {LONGEST} periods; {end:g} s are {end / h:.0f}: give a shorter `until`."
        )
    A, B, Cy, D = (M[sound] for M in (model.A, model.B, model.Cy, model.D))
    if h is None:
        steps = response_times(rows.poles[sound].ravel(), end, TIMES, MOST)
        t, values = times_of(steps), np.full((len(rows), sum(times for _, times in steps) + 1), np.nan)
        values[sound] = exact_responses(A, B, Cy, D, steps)[:, :, 0, 0].T
        return t, values, (into, out, signal_units(rows)[out])
    t = np.asarray(h * np.arange(max(2, round(end / h) + 1)), dtype=float)
    values, x = np.full((len(rows), len(t)), np.nan), np.zeros((len(sound), A.shape[1], 1))
    for k in range(len(t)):
        values[sound, k] = (Cy @ x + D)[:, 0, 0]
        x = A @ x + B
    return t, np.asarray(values), (into, out, signal_units(rows)[out])

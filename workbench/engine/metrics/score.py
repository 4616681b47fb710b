"""One number of a metric in several runs, with its error, its unit and the label of its signal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from workbench.core.validation.array_shapes import require_shapes
from workbench.core.validation.notebook_display import table_to_html
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments

HEADERS = ("metric", "of", "unit", "least", "mean", "largest", "error")


class MetricColumn(NamedTuple):
    """One number of a metric: the metric's name, the number counted from 0, its unit, and the label of its signal."""

    metric: str
    number: int
    unit: str
    label: str = ""


@dataclass(frozen=True, eq=False)
@check_arguments
class Score:
    """One number of a metric in N runs: `value` (N,), and `error` (N,), twice the change of the value from h to h / 2.

    This bounds the error of the value if the change falls at least as fast as the step, once the step is short enough.
    A time has an error of at least one step. For a run that diverged, value and error are NaN. The error is NaN too if
    the run was not repeated at h / 2, and infinite if only the run at h / 2 gives no value.
    """

    metric: str
    label: str
    unit: str
    value: Array
    error: Array

    def __post_init__(self) -> None:
        require_shapes(self, dict.fromkeys(("value", "error"), (self.value.size,)), "one number for each run")

    @property
    def pair(self) -> tuple[float, float]:
        """The value and the error of the first run; a case has only this run.

        Raises
        ------
        LookupError
            If there is no run.
        """
        if not len(self.value):
            raise LookupError(f"`Score.pair` of '{self.metric}' is of the first run, and there is none.")
        return float(self.value[0]), float(self.error[0])

    @property
    def largest_error(self) -> float:
        """The largest error of the runs that were repeated at h / 2; NaN if all of these diverged or there are none."""
        return float(np.fmax.reduce(self.error, initial=np.nan))

    @property
    def row(self) -> tuple[str, ...]:
        """Metric, label, unit, the least, mean and largest finite value, and the largest finite error, as text."""
        values, errors = (column[np.isfinite(column)] for column in (self.value, self.error))
        ends = (values.min(), values.mean(), values.max()) if values.size else (np.nan,) * 3
        numbers = (*ends, errors.max() if errors.size else np.nan)
        return (self.metric, self.label, self.unit, *(f"{number:.6g}" for number in numbers))

    def _repr_html_(self) -> str:
        return table_to_html("", HEADERS, [self.row])

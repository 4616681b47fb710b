"""The measurement of runs: the values of metrics at the step h, their errors from h / 2, and warnings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from workbench.core.validation.array_shapes import require_shapes
from workbench.core.validation.notebook_display import short_list, table_to_html
from workbench.core.validation.refusals import Array, Integers, describe, nearest
from workbench.core.validation.signatures import check_arguments
from workbench.engine import StepLimit, Trajectories
from workbench.engine.metrics.contract import AbstractMetric
from workbench.engine.metrics.score import HEADERS, MetricColumn, Score
from workbench.engine.stability import beyond
from workbench.engine.state_bounds import StateExtremes
from workbench.engine.step_choice import StepChoice
from workbench.engine.step_limits import Check, accuracy


@dataclass(frozen=True, eq=False)
@check_arguments
class Measurement:
    """The metrics of N runs of one loop in k columns at T times, with their errors and the limits on their step.

    Attributes
    ----------
    columns
        For each column the metric, its number from 0, its unit and the label of its signal, (k,).
    t
        (T,), the times in s up to which the metrics are taken from the start; the last is the horizon.
    h
        The step of the values in s; for a sampled loop, the substep.
    values
        (N, T, k), NaN from the time at which a run diverged.
    diverged_at
        (N,), in s, NaN for a run that stayed finite.
    looked_at
        (m,), the numbers of the runs that were repeated at h / 2.
    errors, half_diverged_at
        (m, T, k), by `error_of`, NaN if the run diverged at h or h / 2; and (m,), the time in s of that at h / 2.
    limits, limited_at
        (m,), the longest step in s that is stable at some states of these runs, and the time in s of the state that
        limits it. The limit is infinite if no state limits the step, and NaN if it is not known.
    tolerance
        The tolerance of the errors, relative to the values; None if none was given.
    choice
        The choice of the step by pilot runs for this tolerance; None if `h` was given.
    metrics, kept_runs
        The metrics themselves, and the trajectories of the runs where they were kept.
    pulse_warnings
        The sentences on metrics that may miss a pulse between two steps.
    extremes
        The extremes over all steps of the states with bounds; None of runs that were read from a ledger.
    """

    columns: tuple[MetricColumn, ...]
    t: Array
    h: float
    values: Array
    diverged_at: Array
    looked_at: Integers
    errors: Array
    half_diverged_at: Array
    limits: Array
    limited_at: Array | None = None
    tolerance: float | None = None
    choice: StepChoice | None = None
    metrics: tuple[AbstractMetric, ...] = ()
    pulse_warnings: tuple[str, ...] = ()
    kept_runs: Trajectories | None = None
    extremes: StateExtremes | None = None

    def __post_init__(self) -> None:
        runs, times, looked = self.diverged_at.size, max(1, self.t.size), self.looked_at.size
        shapes = {"t": (times,), "values": (runs, times, len(self.columns)), "diverged_at": (runs,)}
        shapes |= {"looked_at": (looked,), "errors": (looked, times, len(self.columns))}
        shapes |= dict.fromkeys(("half_diverged_at", "limits", "limited_at"), (looked,))
        of = f"of {runs} runs, {looked} that were looked at, {times} times and {len(self.columns)} columns"
        require_shapes(self, shapes, of)
        if not ((self.looked_at >= 0) & (self.looked_at < runs)).all():
            raise ValueError(
                f"`Measurement(looked_at=...)` must be numbers of the {runs} runs, counted from 0; got others."
            )

    def __len__(self) -> int:
        return len(self.values)

    def __repr__(self) -> str:
        """One line: the runs, the metrics, and the warnings."""
        return f"<Measurement of {len(self)} runs: {self.summary}>"

    def _repr_html_(self) -> str:
        return table_to_html(repr(self)[1:-1], HEADERS, [score.row for score in self.scores])

    @property
    def trajectories(self) -> Trajectories:
        """The states of the runs.

        Raises
        ------
        LookupError
            If they were not kept; a sweep does not keep them.
        """
        if self.kept_runs is None:
            raise LookupError("`Measurement.trajectories` were not kept: those of `measure` and of a case are.")
        return self.kept_runs

    @check_arguments
    def score(self, metric: str, signal: int | str = 0) -> Score:
        """A metric of one signal at the horizon, by the signal's label or its number from 0.

        Raises
        ------
        LookupError
            If there is no such metric, or it has no such signal.
        """
        return self._score(self.place(metric, signal))

    @check_arguments
    def over_time(self, metric: str, signal: int | str = 0) -> Array:
        """A metric of one signal from the start to each of the times, (N, T)."""
        return np.asarray(self.values[:, :, self.place(metric, signal)])

    @property
    def scores(self) -> tuple[Score, ...]:
        """The score of each column."""
        return tuple(map(self._score, range(len(self.columns))))

    @check_arguments
    def scores_of(self, metric: str) -> tuple[Score, ...]:
        """The score of each signal of a metric."""
        self.place(metric)
        return tuple(score for score in self.scores if score.metric == metric)

    def _score(self, place: int) -> Score:
        column, errors = self.columns[place], np.full(len(self), np.nan)
        values, found = np.asarray(self.values[:, -1, place]), self.errors[:, -1, place]
        alone = np.isnan(found) & ~np.isnan(values[self.looked_at])
        errors[self.looked_at] = np.where(alone, np.inf, found)
        return Score(column.metric, column.label, column.unit, values, errors)

    @check_arguments
    def column(self, metric: str, signal: int | str = 0) -> MetricColumn:
        """The column of a metric of one signal, by the signal's label or its number from 0."""
        return self.columns[self.place(metric, signal)]

    @check_arguments
    def place(self, metric: str, signal: int | str = 0) -> int:
        """The place of the column of a metric of one signal."""
        mine = {i: one for i, one in enumerate(self.columns) if one.metric == metric}
        for i, one in mine.items():
            if signal in (one.number, one.label):
                return i
        if mine:
            near = nearest(signal, [one.label for one in mine.values()]) if isinstance(signal, str) else ""
            there = ", ".join(
                f"{one.number} ({one.label!r})" if one.label else f"{one.number}" for one in mine.values()
            )
            raise LookupError(f"'{metric}' has no signal {describe(signal)}: it has {there}, counted from 0.{near}")
        there = f"among {short_list(self.names)}" if self.names else "as none was taken"
        raise LookupError(f"There is no metric {describe(metric)} {there}.{nearest(metric, self.names)}")

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the metrics."""
        return tuple(dict.fromkeys(one.metric for one in self.columns))

    @property
    def column_headers(self) -> tuple[str, ...]:
        """The header of each column: the metric with the signal's label or, if the label has two words, its number."""
        names = ((one.metric, one.number if " " in one.label or not one.label else one.label) for one in self.columns)
        return tuple(f"{metric}[{signal}]" for metric, signal in names)

    @check_arguments
    def only(self, runs: Integers) -> Measurement:
        """The measurement of these runs alone, named by their numbers in rising order and numbered anew from 0."""
        if runs.ndim != 1 or not ((runs >= 0) & (runs < len(self))).all() or (np.diff(runs) <= 0).any():
            raise ValueError(
                f"`only(runs)` takes numbers of the {len(self)} runs in rising order, counted from 0; got "
                f"{describe(runs.tolist())}."
            )
        held = np.isin(self.looked_at, runs)
        return replace(
            self,
            values=self.values[runs],
            diverged_at=self.diverged_at[runs],
            looked_at=np.searchsorted(runs, self.looked_at[held]),
            errors=self.errors[held],
            half_diverged_at=self.half_diverged_at[held],
            limits=self.limits[held],
            limited_at=None if self.limited_at is None else self.limited_at[held],
            kept_runs=None,
            extremes=None if self.extremes is None else self.extremes.only(runs),
        )

    @property
    def diverged_count(self) -> int:
        """The number of runs that diverged."""
        return int(np.isfinite(self.diverged_at).sum())

    @property
    def limit(self) -> StepLimit:
        """The tightest of the limits on the step."""
        known = np.flatnonzero(~np.isnan(self.limits))
        if not len(known):
            return StepLimit(self.h, np.nan, np.nan, complex(np.nan, np.nan), 0)
        i = known[np.argmin(self.limits[known])]
        at = np.nan if self.limited_at is None else float(self.limited_at[i])
        return StepLimit(self.h, float(self.limits[i]), at, complex(np.nan, np.nan), len(known))

    @cached_property
    def check(self) -> Check | None:
        """The errors compared with the tolerance; None if no tolerance was given."""
        if self.tolerance is None:
            return None
        found = []
        for name in self.names:
            mine = self.scores_of(name)
            errors, values = (
                np.stack(parts, axis=1)[self.looked_at] for parts in ([s.error for s in mine], [s.value for s in mine])
            )
            found.append(accuracy(name, errors, values, self.tolerance))
        return Check(tuple(found), self.limit, len(self.limits), len(self))

    @property
    def summary(self) -> str:
        """The names of the metrics, and the warnings."""
        return "; ".join([short_list(list(self.names)), *self.warnings])

    @property
    def warnings(self) -> tuple[str, ...]:
        """The sentences on runs that diverged or passed a bound, a step beyond its limit, and metrics that miss."""
        missed = () if self.check is None else tuple(one.miss for one in self.check.metrics if not one.is_met)
        lost = f"{self.diverged_count:,} of {len(self):,} runs diverged" if self.diverged_count else ""
        losses = lost if self.kept_runs is None else self.kept_runs.losses
        step = beyond(self.limit) if len(self.limits) else ""
        return tuple(filter(None, (losses, *self.excursions, step, *missed, *self.pulse_warnings)))

    @property
    def excursions(self) -> tuple[str, ...]:
        """A sentence for each state that passes a bound of its block at any step of a run."""
        return () if self.extremes is None else self.extremes.sentences


def error_of(value: Array, half_value: Array, least: Sequence[float]) -> Array:
    """The error of values (..., k): twice their change to those at half the step, and at least so much, (k,).

    A method of order p has the error 2^p / (2^p - 1) times the change, so that twice the change bounds it for p >= 1,
    once the step is short enough. It is zero where two infinite values agree.
    """
    with np.errstate(invalid="ignore"):
        found = np.maximum(2 * np.abs(value - half_value), least)
    return np.where(np.isinf(value) & np.isinf(half_value), 0.0, found)

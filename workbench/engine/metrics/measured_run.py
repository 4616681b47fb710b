"""The run of all measurements: rows of parameters and initial states give accumulators, and these give values."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property, partial
from math import isqrt

import numpy as np

from workbench.core import StepMap
from workbench.core.validation.refusals import Array, Integers
from workbench.engine import Trajectories, simulate
from workbench.engine.arithmetic import default_for
from workbench.engine.divergence import Divergence
from workbench.engine.job import Job, Progress
from workbench.engine.metrics.measured_equation import MeasuredEquation
from workbench.engine.metrics.measurement import Measurement, error_of
from workbench.engine.metrics.unseen_pulses import unseen_pulses
from workbench.engine.pilot_selection import pilot_runs
from workbench.engine.stability import longest_steps, modes_at
from workbench.engine.step_choice import StepChoice

POINTS = 400  # states of a single run at which its modes are looked at; of several runs, as many in all
FEWEST = 4  # of each of many runs


def points_of(runs: int) -> int:
    """The number of states of each run at which its modes are computed, for a number of runs."""
    return max(FEWEST, POINTS // max(1, runs))


@dataclass(frozen=True, eq=False)
class Accumulation:
    """The accumulators of n runs at T times, and of m of them at half the step, with some states of these.

    Attributes
    ----------
    totals, diverged_at
        (n, T, a), and (n,) in s, NaN for a run that stayed finite.
    half_totals, half_diverged_at
        (m, T, a) and (m,), the same at half the step.
    states
        (m, S, nx), the states at half the step at which the modes are computed.
    """

    totals: Array
    diverged_at: Array
    half_totals: Array
    half_diverged_at: Array
    states: Array


@dataclass(frozen=True, eq=False)
class MeasuredRun:
    """A measured equation at a step h [s] up to a horizon, with the times at which its metrics are taken.

    Attributes
    ----------
    every, spacing
        The time in s between two kept states, and between two times at which the metrics are taken.
    seed, arithmetic
        The seed of the noise, and the arithmetic of all runs; both hold at h / 2 too, and so does the method.
    points
        The number of states, of a run that is repeated at h / 2, at which its modes are computed.
    """

    measured_equation: MeasuredEquation
    h: float
    until: float
    every: float
    spacing: float
    seed: int
    arithmetic: str
    method: str = "rk4"
    points: int = POINTS

    @cached_property
    def step(self) -> StepMap:
        """The step of the values, with the accumulators beside the states."""
        return self.measured_equation.step(self.h, self.method)

    @cached_property
    def half(self) -> StepMap:
        """The step at h / 2."""
        return self.measured_equation.step(self.h / 2, self.method)

    @cached_property
    def times(self) -> Array:
        """(T,), the times at which the metrics are taken, in s."""
        stride = round(self.spacing / self.step.h)
        return np.asarray(np.arange(1, round(self.until / self.spacing) + 1) * stride * self.step.h)

    def start(self, x0: Array) -> Array:
        """Initial states (n, nx) of the equation with those of the metrics behind them."""
        return np.hstack([x0, np.tile(self.step.states.default[x0.shape[1] :], (len(x0), 1))])

    def march(
        self, p: Array, x0: Array, keys: Integers, looked_at: Integers, tell: Progress
    ) -> tuple[Accumulation, Trajectories]:
        """The accumulators of the runs with rows p (n, np) and x0 (n, nx), for the runs `looked_at` also at h / 2.

        `keys` (n,) are the keys of the noise of each run.
        """
        x, m = self.start(x0), len(looked_at)
        share = 2 * m / (2 * m + len(p))
        run = partial(simulate, until=self.until, seed=self.seed, arithmetic=self.arithmetic)
        size = self.measured_equation.accumulators.size
        halved, lost = np.empty((0, len(self.times), size)), np.empty(0)
        states = np.empty((0, len(self._look_places), self.half.flow.states.size))
        if m:  # the longer run first: from it the engine sees how good its code should be
            whole = m == len(p)
            rows, start = (part if whole else part[looked_at] for part in (p, x))
            own = keys if whole else keys[looked_at]
            every = self._look_spacing
            fine = run(self.half, rows, start, noise_keys=own, every=every, progress=lambda done: tell(share * done))
            halved, lost = self._totals(fine), fine.diverged_at
            states = fine.x[:, self._look_places, : self.half.flow.states.size]
        coarse = run(
            self.step, p, x, noise_keys=keys, every=self.every, progress=lambda done: tell(share + (1 - share) * done)
        )
        return Accumulation(self._totals(coarse), coarse.diverged_at, halved, lost, states), coarse

    def _totals(self, runs: Trajectories) -> Array:
        """The accumulators (n, T, a) of some runs at the times of the metrics."""
        kept = np.searchsorted(runs.t, self.times - runs.step.h / 2)
        return np.stack([self.measured_equation.totals(runs, int(row)) for row in kept], axis=1)

    @cached_property
    def _look_spacing(self) -> float:
        """The distance in s of the kept states at half the step, which meet all times of metrics."""
        stride, spans = round(self.spacing / self.half.h), len(self.times)
        small = [i for i in range(1, isqrt(stride) + 1) if stride % i == 0]
        fits = (d for i in small for d in (i, stride // i) if spans * stride >= self.points * d)
        return max(fits, default=1) * self.half.h

    @cached_property
    def _look_places(self) -> Integers:
        """The places of the kept states at half the step at which modes are looked at, (S,)."""
        kept = round(self.until / self._look_spacing)
        return np.unique(np.linspace(0, kept, self.points).round().astype(int))

    def shapes(self, n: int, m: int) -> dict[str, tuple[int, ...]]:
        """The shapes of the arrays of an `Accumulation` of n runs, of which m are looked at."""
        each = (len(self.times), self.measured_equation.accumulators.size)
        states = (m, len(self._look_places), self.step.flow.states.size)
        shapes = ((n, *each), (n,), (m, *each), (m,), states)
        return dict(zip((field.name for field in fields(Accumulation)), shapes, strict=True))

    def trajectories(self, p: Array, keys: Integers, x: Array, divergence: Divergence) -> Trajectories:
        """The trajectories of runs whose states x (n, K, nx) were kept at h."""
        stride = round(self.every / self.step.h)
        job = Job(self.step, p, stride, self.seed, keys, arithmetic=self.arithmetic)
        return Trajectories(job, np.asarray(np.arange(x.shape[1]) * stride * self.step.h), x, divergence)

    def measurement(
        self,
        runs: Accumulation,
        p: Array,
        looked_at: Integers,
        at_half: bool = False,
        *,
        tolerance: float | None,
        choice: StepChoice | None,
        kept_runs: Trajectories | None,
    ) -> Measurement:
        """The values of runs with rows p (n, np), their errors, and the limits on the step.

        With `at_half` the values are those of h / 2, of the runs that were looked at.
        """
        values, lost = self.measured_equation.values(runs.totals, self.times, runs.diverged_at), runs.diverged_at
        ends = (self.half, runs.half_totals) if at_half else (self.step, runs.totals)
        halved = self.measured_equation.values(runs.half_totals, self.times, runs.half_diverged_at)
        least = [self.step.h if is_time else 0.0 for is_time in self.measured_equation.times]
        errors = error_of(values[looked_at], halved, least)
        if at_half:
            values, lost, p, looked_at = halved, runs.half_diverged_at, p[looked_at], np.arange(len(looked_at))
        limits, at = self._limits(runs.states, p[looked_at])
        few = looked_at[pilot_runs(p[looked_at], np.empty((len(looked_at), 0)))] if len(looked_at) else looked_at
        return Measurement(
            columns=self.measured_equation.columns,
            t=self.times,
            h=self.h,
            values=values,
            diverged_at=lost,
            looked_at=looked_at,
            errors=errors,
            half_diverged_at=runs.half_diverged_at,
            limits=limits,
            limited_at=at,
            metrics=self.measured_equation.metrics,
            pulse_warnings=unseen_pulses(self.step, self.measured_equation.metrics, p[few], self.until),
            tolerance=tolerance,
            choice=choice,
            kept_runs=kept_runs,
            extremes=self.measured_equation.extremes(ends[0], ends[1][:, -1]),
        )

    def _limits(self, states: Array, p: Array) -> tuple[Array, Array]:
        """The longest step that is stable at states (m, S, nx) of runs, (m,) in s, and when; NaN where not known."""
        m, looks = states.shape[:2]
        if not m:
            return np.empty(0), np.empty(0)
        t = self._look_places * self._look_spacing
        modes = modes_at(self.step.flow, np.tile(t, m), states.reshape(m * looks, -1), np.repeat(p, looks, axis=0))
        longest = np.min(longest_steps(modes, self.step.amplification), axis=1, initial=np.inf)
        longest[np.isnan(modes).any(axis=1)] = np.nan
        longest = longest.reshape(m, looks)
        limits = np.asarray(np.fmin.reduce(longest, axis=1))
        first = np.argmin(np.nan_to_num(longest, nan=np.inf), axis=1)
        return limits, np.where(np.isnan(limits), np.nan, t[first])


def arithmetic_for(step: StepMap, name: str | None) -> str:
    """The arithmetic of all runs at a step and at half of it: the one that is named, or else the step's best."""
    return name or default_for(step)

"""Optimum: the best point that the searches of a tuning found, its spread, and the doubts about it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from workbench.core import Layout, Ode, SampledSystem
from workbench.core.equations import Loop, answer, equations_of
from workbench.core.validation.refusals import Array, Integers, known_name, vector, whole
from workbench.core.validation.signatures import check_arguments
from workbench.engine.factors import Space
from workbench.engine.metrics.measurement import error_of
from workbench.study.document.words import join_names
from workbench.study.sample import Sample
from workbench.study.tuning.convergence import SearchCourse, percent, share
from workbench.study.tuning.tuning import NOISES, Tuning

# Beyond these a search is said to be in doubt.
EDGE = 0.01  # of a range, from its end: of the range of logarithms, if that is what is searched
STEP = 0.01  # of the objective, which its error may be
SEEDS = 0.05  # of the objective, by which the bests of several searches, or that of the best by noise, may differ

Measure = Callable[[Mapping[str, Sample]], Array]


@dataclass(frozen=True, eq=False)
@check_arguments
class TuningResult:
    """All points that a tuning evaluated, their objectives, and the best of them: N points of d numbers, K finalists.

    `points` (N, d) are in the unit cube, search after search, and `numbers` (N, d) are the values of the factors.
    `objectives` (N,) are those at the step h, infinite for a point that is not admissible. `evaluations` counts the
    points of each search, and `samples` has the runs by trial. The finalists, the best points of each search, are run
    at h and h / 2 under the S training noises of all searches (S = 1 if no trial has noise). `finalists` (K,) are their
    places, `finals` and `finals_at_half_step` (K, S) their objectives, and `final_samples` their runs by trial.
    """

    tuning: Tuning
    evaluations: tuple[int, ...]  # of the points, by each search
    points: Array  # (N, d), in the unit cube, one search behind the other
    numbers: Array  # (N, d), as values of the factors
    objectives: Array  # (N,), at the step h, under the noise of the point's search; infinite where not admissible
    samples: Mapping[str, Sample]  # by trial; what they say of a seed is that of the first search
    finalists: Integers  # (K,), their places
    finals: Array  # (K, S), their objectives at h
    finals_at_half_step: Array  # (K, S), their objectives at h / 2
    final_samples: Mapping[str, Sample]  # their runs by trial, all under one noise behind all under the one before

    @property
    def name(self) -> str:
        """The name of the tuning."""
        return self.tuning.name

    @property
    def _row(self) -> int:
        """The place of the best point among the finalists."""
        return int(np.argmin(self._admissible(self.finals.mean(axis=1), self.finals_at_half_step.mean(axis=1))))

    @property
    def place(self) -> int:
        """The number of the best point: the finalist of the least objective in the mean over the noises."""
        return int(self.finalists[self._row])

    @property
    def best(self) -> dict[str, float]:
        """The best value of each factor."""
        return self._numbers(self.place)

    @check_arguments
    def best_of(self, seed: int) -> dict[str, float]:
        """The best value of each factor in the search of a seed: its best finalist under the noise of that search."""
        seeds = list(map(str, self.tuning.seeds))
        search = seeds.index(known_name(str(seed), seeds, f"searches of '{self.name}' by their seeds"))
        objectives = self._admissible(self._own(self.finals), self._own(self.finals_at_half_step))
        own = np.where(self._searches[self.finalists] == search, objectives, np.inf)
        if not np.isfinite(own).any():
            raise ValueError(
                f"`best_of({seed})`: this search of '{self.name}' has no admissible point at half the step."
            )
        return self._numbers(int(self.finalists[np.argmin(own)]))

    @check_arguments
    def best_within(self, evaluations: int) -> dict[str, float]:
        """The best value of each factor at the step h, among the first `evaluations` points of each search."""
        whole("best_within(evaluations)", evaluations)
        nth = np.concatenate([np.arange(used) for used in self.evaluations])
        early = np.where(nth < evaluations, self.objectives, np.inf)
        if not np.isfinite(early).any():
            raise ValueError(
                f"`best_within({evaluations})`: no search of '{self.name}' has an admissible point among its first "
                f"{evaluations:,}."
            )
        return self._numbers(int(np.argmin(early)))

    @property
    def objective(self) -> float:
        """The objective of the best point, in the mean over the training noises."""
        return float(self.finals[self._row].mean())

    @property
    def spread(self) -> float:
        """The greatest less the least objective of the best point over the training noises."""
        return float(np.ptp(self.finals[self._row]))

    @property
    def step_error(self) -> float:
        """The error of the objective of the best point: twice its change from h to h / 2."""
        return float(error_of(np.array([self.objective]), self.finals_at_half_step[[self._row]].mean(axis=1), [0.0])[0])

    @property
    def stable_steps(self) -> dict[str, float]:
        """The longest stable step along the run of the best point, in s, by trial."""
        return {name: float(one.measurement.limits[self._row]) for name, one in self.final_samples.items()}

    @property
    def failures(self) -> int:
        """The number of points that are not admissible."""
        return int((~np.isfinite(self.objectives)).sum())

    @cached_property
    def searches(self) -> tuple[SearchCourse, ...]:
        """The course of each search."""
        parts = np.split(self.objectives, np.cumsum(self.evaluations)[:-1])
        each = (part.reshape(-1, self.tuning.population).min(axis=1) for part in parts)
        return tuple(SearchCourse(self.tuning, k, np.minimum.accumulate(bests)) for k, bests in enumerate(each))

    @property
    def bests(self) -> Array:
        """The least objective of each search at the step h, one number per seed."""
        return np.array([one.bests[-1] for one in self.searches])

    @property
    def has_settled(self) -> tuple[bool, ...]:
        """True for each search that has settled: the last quarter of its evaluations gained no more than 1 %."""
        return tuple(one.has_settled for one in self.searches)

    @property
    def at_edge(self) -> tuple[str, ...]:
        """The factors whose best value lies at a limit that is not declared physical."""
        return tuple(name for name, end in self._ends.items() if (name, end) not in self.tuning.physical)

    @property
    def at_physical(self) -> dict[str, str]:
        """The reasons of the physical limits at which best values lie, by factor."""
        declared = self.tuning.physical
        return {name: declared[name, end] for name, end in self._ends.items() if (name, end) in declared}

    @property
    def _ends(self) -> dict[str, str]:
        """The factors whose best value lies at an end of the range, with that end."""
        names, at = [factor.name for factor in self.tuning.factors], self.points[self.place]
        low = {name: "low" for name, u in zip(names, at, strict=True) if u < EDGE}
        return low | {name: "high" for name, u in zip(names, at, strict=True) if u > 1 - EDGE}

    @property
    def _searches(self) -> Integers:
        """The search that each point is of, (N,)."""
        return np.arange(len(self.evaluations)).repeat(self.evaluations)

    def _own(self, objectives: Array) -> Array:
        """Those of objectives (K, S) that are each under the noise of the finalist's own search, (K,)."""
        noises = self._searches[self.finalists] % objectives.shape[1]
        return np.asarray(objectives[np.arange(len(objectives)), noises])

    def _admissible(self, finals: Array, halved: Array) -> Array:
        """The objectives at h (K,), infinite where the point is not admissible at h / 2."""
        return np.where(np.isfinite(halved), finals, np.inf)

    def _numbers(self, place: int) -> dict[str, float]:
        names = (factor.name for factor in self.tuning.factors)
        return dict(zip(names, map(float, self.numbers[place]), strict=True))

    @check_arguments
    def best_equations(self, loop: Loop | Ode | SampledSystem) -> Ode | SampledSystem:
        """The equations of a loop with the best numbers as defaults, in the places of the factors."""
        equation: Ode | SampledSystem = equations_of(loop, self.name)
        p, x0 = Space(self.tuning.factors, equation.parameters, equation.states).rows(self.points[[self.place]])
        flow = equation.flow if isinstance(equation, SampledSystem) else equation
        flow = replace(flow, parameters=_refilled(flow.parameters, p[0]), states=_refilled(flow.states, x0[0]))
        return replace(equation, flow=flow) if isinstance(equation, SampledSystem) else flow

    @check_arguments
    def measures(self, *measures: Measure) -> Array:
        """Several measures of all admissible points, (B, m), from their runs by trial."""
        if not measures:
            raise ValueError("`measures(measure, ...)` needs at least one measure; got none.")
        good = np.flatnonzero(np.isfinite(self.objectives))
        runs = {name: one.only(good) for name, one in self.samples.items()}
        call = "measures(measure)(runs)"
        return np.stack([vector(call, answer(call, one, runs), len(good), "points") for one in measures], axis=1)

    @property
    def note(self) -> str:
        """The note below a figure: evaluations, failures, seeds, step, step error, and training noise."""
        tuning, error = self.tuning, percent(share(self.step_error, self.objective))
        several, noises = len(tuning.seeds) > 1, self.finals_at_half_step.shape[1]
        steps = join_names(f"{h:g} s" for h in dict.fromkeys(one.h for one in self.samples.values()))
        said = [
            f"{self._budget_words}, {tuning.evaluations_per_number:,.4g} for each tuned number; {self.failures:,} of "
            f"{len(self.objectives):,} were not admissible.",
            f"The {'seeds of the searches are' if several else 'seed of the search is'} "
            f"{join_names(map(str, tuning.seeds))}.",
            f"The step of the simulation is {steps}; the best objective has an error of {error} by the step.",
        ]
        if noises > 1:
            said.append(
                f"Each search has a noise of its own, with seeds {NOISES} apart. Under the {noises} noises the best "
                f"objective varies by {percent(share(self.spread, self.objective))}."
            )
        said += [f"'{name}' is at a physical limit: {why}." for name, why in self.at_physical.items()]
        return " ".join(said)

    @property
    def _budget_words(self) -> str:
        """The evaluations of each search, and the most that it may use if not all were used."""
        counts, most = self.evaluations, self.tuning.evaluations
        of = "" if set(counts) == {most} else f" of at most {most:,}"
        if len(counts) == 1:
            return f"The search used {counts[0]:,}{of} evaluations"
        if len(set(counts)) == 1:
            return f"Each of the {len(counts)} searches used {counts[0]:,}{of} evaluations"
        return f"The {len(counts)} searches used {join_names(f'{one:,}' for one in counts)}{of} evaluations"

    @property
    def warnings(self) -> tuple[str, ...]:
        """Sentences on doubts about the best point."""
        said = [f"The best '{name}' lies at the {self._ends[name]} end of its range." for name in self.at_edge]
        said += [sentence for one in self.searches if (sentence := one.doubt)]
        if (error := share(self.step_error, self.objective)) > STEP:
            said.append(f"The best objective has an error of {percent(error)} by the step.")
        for name, limit in self.stable_steps.items():
            h = self.samples[name].h
            if np.isnan(limit):
                said.append(f"The stability limit of the step is not known along the best run in '{name}'.")
            elif limit < h:
                along = f"{limit:.3g} s along the best run in '{name}'"
                said.append(f"The step of {h:g} s is beyond the stability limit {along}.")
        if SEEDS < (spread := share(float(np.ptp(self.bests)), self.objective)) < np.inf:
            said.append(f"The best objectives of the {len(self.bests)} searches differ by {percent(spread)}.")
        if (spread := share(self.spread, self.objective)) > SEEDS:
            said.append(f"The best objective varies by {percent(spread)} with the training noise.")
        return tuple(said)


def _refilled(layout: Layout, row: Array) -> Layout:
    values = layout.unpack(row)
    return Layout(tuple(replace(entry, default=values[entry.name]) for entry in layout.entries))

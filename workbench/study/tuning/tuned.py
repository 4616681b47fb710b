"""Tuned: what the searches of a tuning found, and how far that may be trusted."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from workbench.study.adjusted import Adjusted, adjusted
from workbench.study.contract import Loop, answer, check_loop, equations_of
from workbench.study.factors import Space
from workbench.study.pareto import pareto
from workbench.study.sample import Sample
from workbench.study.tuning.contract import Tuning
from workbench.validation.doors import door
from workbench.validation.words import Array, Integers, vector
from workbench.verify.evolution import Flags

# Beyond these a search is said to be in doubt.
EDGE = 0.01  # of a range, from its end: of the range of logarithms, if that is what is searched
SETTLED = 0.01  # of the objective, by which it may still become better in the last quarter of a search
STEP = 0.01  # of the objective, by which it may change at half the step
SEEDS = 0.05  # of the objective, by which the bests of several searches may differ

Measure = Callable[[Mapping[str, Sample]], Array]


@dataclass(frozen=True, eq=False)
@door
class Tuned:
    """All points that were looked at, what they are worth, and the best of them.

    Attributes
    ----------
    points, numbers
        (N, d), in the unit cube and as values of the factors: one search behind the other.
    objectives
        (N,) at the step h; infinite for a point that is not admissible.
    samples
        The runs of all points, by trial.
    finalists, halved, halves
        The places (K,) of the best points of all searches, their objectives (K,) at h / 2, and the runs of these by
        trial.
    limits
        (K,) by trial, the longest step in s that is stable at a few states of these runs; infinite where all are, NaN
        where that is not known.
    """

    tuning: Tuning
    points: Array
    numbers: Array
    objectives: Array
    samples: Mapping[str, Sample]
    finalists: Integers
    halved: Array
    halves: Mapping[str, Sample]
    limits: Mapping[str, Array]

    @property
    def name(self) -> str:
        """That of the tuning."""
        return self.tuning.name

    @property
    def place(self) -> int:
        """The number of the best point: among the finalists that whose objective is least at h / 2."""
        return int(self.finalists[np.argmin(self.halved)])

    @property
    def best(self) -> dict[str, float]:
        """The best value of each factor."""
        names = (factor.name for factor in self.tuning.factors)
        return dict(zip(names, map(float, self.numbers[self.place]), strict=True))

    @property
    def objective(self) -> float:
        """That of the best point, at h / 2."""
        return float(self.halved.min())

    @property
    def step_error(self) -> float:
        """By how much the objective of the best point changes from h to h / 2."""
        return abs(float(self.objectives[self.place]) - self.objective)

    @property
    def stable_steps(self) -> dict[str, float]:
        """The longest stable step along the run of the best point, in s, by trial: as in `limits`."""
        best = int(np.argmin(self.halved))
        return {name: float(limits[best]) for name, limits in self.limits.items()}

    @property
    def failed(self) -> int:
        """How many points are not admissible."""
        return int((~np.isfinite(self.objectives)).sum())

    @property
    def inadmissible(self) -> dict[str, int]:
        """How many points are not, by reason; a point may diverge in several trials."""
        return reasons_of(self.objectives, self.samples)

    @cached_property
    def curves(self) -> dict[str, tuple[Array, Array]]:
        """By search, the evaluations after each generation and the least objective so far; infinite while none is."""
        tuning = self.tuning
        each = self.objectives.reshape(len(tuning.seeds), tuning.generations, tuning.population).min(axis=2)
        spent = tuning.population * np.arange(1.0, tuning.generations + 1)
        bests = np.minimum.accumulate(each, axis=1)
        return {f"seed {seed}": (spent, best) for seed, best in zip(tuning.seeds, bests, strict=True)}

    @property
    def bests(self) -> Array:
        """The least objective of each search at the step h, a number a seed."""
        return np.array([best[-1] for _, best in self.curves.values()])

    @property
    def at_edge(self) -> tuple[str, ...]:
        """The factors whose best value lies at an end of its range."""
        ends = np.minimum(self.points[self.place], 1 - self.points[self.place]) < EDGE
        return tuple(factor.name for factor, at in zip(self.tuning.factors, ends, strict=True) if at)

    @property
    def settled(self) -> bool:
        """Whether no search became better by more than 1 % in its last quarter; False if it is too short to tell."""
        return bool((self._late_gains <= SETTLED).all())

    @property
    def _late_gains(self) -> Array:
        """By what part of its objective each search became better in its last quarter; NaN if it is too short to tell.

        Infinite if nothing was admissible before.
        """
        count = self.tuning.generations
        early = count - count // 4 - 1
        if early == count - 1:
            return np.full(len(self.tuning.seeds), np.nan)
        pairs = ((best[early], best[-1]) for _, best in self.curves.values())
        return np.array([_share(before - after, after) if np.isfinite(before) else np.inf for before, after in pairs])

    def adjusted(self, loop: Loop) -> Adjusted:
        """A loop with the best numbers in the places of the factors.

        Raises
        ------
        LookupError, ValueError
            If the loop does not have a path, or the number is out of its bounds there.
        """
        check_loop("adjusted(loop)", loop)
        equation = equations_of(loop, self.name)
        space = Space(self.tuning.factors, equation.parameters, equation.states)
        p, x0 = space.rows(self.points[self.place][np.newaxis])
        changed: dict[str, float] = {}
        for layout, row in ((equation.parameters, p[0]), (equation.states, x0[0])):
            triples = zip(layout.labels, row, layout.default, strict=True)
            changed |= {label: float(value) for label, value, own in triples if value != own}
        return adjusted(loop, changed)

    @door
    def measured(self, measure: Measure) -> Array:
        """A measure of all points, (N,), from their runs by trial; NaN where a point is not admissible."""
        good = np.flatnonzero(np.isfinite(self.objectives))
        found = np.full(len(self.objectives), np.nan)
        runs = {name: one.only(good) for name, one in self.samples.items()}
        found[good] = vector(
            "measured(measure)(runs)", answer("measured(measure)(runs)", measure, runs), len(good), "points"
        )
        return found

    @door
    def front(self, *measures: Measure) -> Array:
        """The Pareto set of several measures over all admissible points, (B, m), in rising order of the first."""
        if not measures:
            raise ValueError("`front(measure, ...)` needs at least one measure; got none.")
        table = np.stack([self.measured(one) for one in measures], axis=1)
        return np.asarray(table[pareto(table)])

    @property
    def note(self) -> str:
        """What must stand below a figure: evaluations, failed ones, seeds, step, and its error."""
        tuning = self.tuning
        seeds = ", ".join(map(str, tuning.seeds))
        steps = ", ".join(f"{h:g} s" for h in dict.fromkeys(trial.h for trial in tuning.trials))
        return (
            f"{tuning.evaluations:,} evaluations a search, {self.failed:,} of {len(self.objectives):,} not admissible; "
            f"{'seed' if len(tuning.seeds) == 1 else 'seeds'} {seeds}; step {steps}, at half of which the best "
            f"objective changes by {_percent(_share(self.step_error, self.objective))}"
        )

    @property
    def warnings(self) -> tuple[str, ...]:
        """Why the best may not be the best, in sentences."""
        said = [f"The best '{name}' lies at an end of its range." for name in self.at_edge]
        late = float(self._late_gains.max())
        if np.isnan(late):
            said.append("The search is too short to tell whether it has settled.")
        elif late > SETTLED and late < np.inf:
            said.append(f"A search became better by {_percent(late)} in its last quarter, so it has not settled.")
        if (share := _share(self.step_error, self.objective)) > STEP:
            said.append(f"The objective of the best changes by {_percent(share)} at half the step.")
        said += self._beyond
        spread = _share(float(np.ptp(self.bests)), self.objective)
        if SEEDS < spread < np.inf:
            said.append(f"The bests of the {len(self.bests)} searches differ by {_percent(spread)}.")
        if np.isinf(late) or np.isinf(spread):
            said.append("A search found an admissible point in its last quarter only, or none.")
        return tuple(said)

    @property
    def _beyond(self) -> list[str]:
        """The trials in which the step is longer than is stable along the run of the best, or nobody knows."""
        said = []
        for trial in self.tuning.trials:
            limit = self.stable_steps[trial.name]
            if np.isnan(limit):
                said.append(f"The stability limit of the step is not known along the best run in '{trial.name}'.")
            elif limit < trial.h:
                said.append(
                    f"The step of {trial.h:g} s is beyond the stability limit {limit:.3g} s along the best run in "
                    f"'{trial.name}'."
                )
        return said


def reasons_of(objectives: Array, samples: Mapping[str, Sample]) -> dict[str, int]:
    """How many points are not admissible, by reason, from their objectives (N,) and their runs by trial."""
    reasons: dict[str, int] = {}
    for name, one in samples.items():
        nameless = int((~have_values(one) & np.isnan(one.diverged_at)).sum())
        reasons |= {f"the run in '{name}' diverged": one.failed, f"a metric in '{name}' is no number": nameless}
    worthless = np.all([have_values(one) for one in samples.values()], axis=0) & ~np.isfinite(objectives)
    return reasons | {"the objective is infinite": int(worthless.sum())}


def have_values(sample: Sample) -> Flags:
    """Which runs have a value of every metric at the horizon; a run near overflow may not, though it is finite."""
    return np.asarray(~np.isnan(sample.values[:, -1]).any(axis=1))


def _share(part: float, whole: float) -> float:
    """A part of a whole; infinite if there is none to be a part of."""
    return 0.0 if part == 0 else part / abs(whole) if whole else np.inf


def _percent(share: float) -> str:
    if 0 < share < 1e-4:
        return "less than 0.01 %"
    return f"{100 * share:.2g} %" if share < 0.995 else f"{100 * share:,.0f} %"

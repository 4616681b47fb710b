"""Shares of the draws in which the proposed law is first, or below a rival: under each prior, in each column."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

import workbench as wb
from studies.a6_unstated_choices.draws import DESIGNS, PRIORS, Prior, part, rmse_by_law, sweep_name
from studies.a6_unstated_choices.loops import FACTORS, NAMES, PROPOSED_LAW, SCENARIOS, Reading, factors_of
from studies.paper.card import LAWS

COLUMNS = {(scenario, joint): f"{scenario}, q{joint}" for scenario in SCENARIOS for joint in (1, 2)}
SHARES = len(COLUMNS) * len(PRIORS)  # of one question, which a sentence on it rests on together
TOGETHER = 1 - 0.05 / SHARES  # Bonferroni
RIVALS = LAWS[1:]
NO, YES, UNDECIDED, MIXED = "no", "yes", "undecided", "mixed"
READINGS = {
    factor.name: factor.distribution.names
    for law in LAWS
    for factor in FACTORS[law]
    if isinstance(factor.distribution, Reading)
}

Cell = tuple[str, tuple[str, int]]  # the name of a prior, and a column


@dataclass(frozen=True, eq=False)
class Draws:
    """RMSE (N, 6) of the laws in the draws of a column under a prior; infinite where a run diverged."""

    rmse: wb.Array
    points: wb.Array  # (N, d), in the unit cube, in the order of `NAMES`

    def first(self, without: str | None = None) -> wb.uncertainty.Flags:
        """True in a draw in which the proposed law is below all its rivals, or all but one."""
        kept = [i for i, law in enumerate(RIVALS, 1) if law != without]
        return np.asarray(self.rmse[:, 0] < self.rmse[:, kept].min(axis=1))

    def below(self, rival: str) -> wb.uncertainty.Flags:
        """True in a draw in which the proposed law is below a rival."""
        return np.asarray(self.rmse[:, 0] < self.rmse[:, LAWS.index(rival)])

    def only(self, rows: wb.core.Integers | wb.uncertainty.Flags) -> "Draws":
        return Draws(self.rmse[rows], self.points[rows])

    def reading(self, name: str, value: str) -> "Draws":
        """The draws with one reading."""
        names = READINGS[name]
        places = np.minimum(self.points[:, NAMES.index(name)] * len(names), len(names) - 1).astype(int)
        return self.only(places == names.index(value))


Cells = Mapping[Cell, Draws]


def cells(results: wb.Results, kind: str = "random") -> dict[Cell, Draws]:
    """The draws of every prior and column."""
    points = DESIGNS[kind].points()
    every: dict[Cell, Draws] = {}
    for name, prior in PRIORS.items():
        for scenario in SCENARIOS:
            rmse = rmse_by_law(results, kind, scenario, prior)
            for joint in (1, 2):
                table = np.column_stack([rmse[law][:, joint - 1] for law in LAWS])
                every[name, (scenario, joint)] = Draws(np.where(np.isnan(table), np.inf, table), points)
    return every


@dataclass(frozen=True, eq=False)
class Rerun:
    """The draws of a column under a prior in which the proposed law was run at half of the step too."""

    draws: Draws
    errors: wb.Array  # (N,), of the RMSE of the proposed law by the step; infinite where not known

    def shifted_draws(self, side: int) -> Draws:
        """The draws with the error added to the RMSE of the proposed law, `side` 1, or taken off, `side` -1."""
        rmse = self.draws.rmse.copy()
        finite = np.isfinite(rmse[:, 0])
        rmse[finite, 0] += side * self.errors[finite]
        return Draws(rmse, self.draws.points)

    @cached_property
    def is_inaccurate(self) -> wb.uncertainty.Flags:
        """True where the error is above 1 % of the RMSE."""
        ours = self.draws.rmse[:, 0]
        return np.asarray(np.isfinite(ours) & (self.errors > 0.01 * ours))

    @cached_property
    def is_undecided(self) -> wb.uncertainty.Flags:
        """True where a rival is nearer to the proposed law than the error, so that its rank is not known."""
        low, high = (self.shifted_draws(side).rmse for side in (-1, 1))
        return np.asarray(((low[:, :1] < low[:, 1:]) != (high[:, :1] < high[:, 1:])).any(axis=1))


def reruns(results: wb.Results, every: Cells) -> dict[Cell, Rerun]:
    """The draws that were run at half of the step too, at their own horizons."""
    found = {}
    for (name, (scenario, joint)), draws in every.items():
        prior = PRIORS[name]
        rows, errors = _errors(results, scenario, prior)
        found[name, (scenario, joint)] = Rerun(draws.only(rows), errors[:, joint - 1])
    return found


def _errors(results: wb.Results, scenario: str, prior: Prior) -> tuple[wb.core.Integers, wb.Array]:
    """The numbers (n,) of the draws that were run at half of the step too, and the errors (n, 2) at their horizons."""
    sample = results.sample(sweep_name("random", PROPOSED_LAW, scenario, prior))
    _, places = part("random", factors_of(PROPOSED_LAW, scenario))
    measured = sample.measurement
    rows = np.array([int(np.flatnonzero(places == run)[0]) for run in measured.looked_at])
    times = prior.horizons_of("random", scenario)[rows]
    at = np.round(sample.t).astype(int).searchsorted(times)
    errors = measured.errors[np.arange(len(rows)), at]
    return rows, np.where(np.isnan(errors), np.inf, errors)


def share_of_draws(draws: Draws, flags: Callable[[Draws], wb.uncertainty.Flags]) -> wb.uncertainty.Share:
    return wb.uncertainty.share(flags(draws), TOGETHER)


def answer_of(one: wb.uncertainty.Share) -> str:
    """The answer of most draws by a share: yes, no, or undecided where its interval has one half in it."""
    return YES if one.low > 0.5 else NO if one.high < 0.5 else UNDECIDED


def answer_of_all(shares: Sequence[wb.uncertainty.Share]) -> str:
    """The one answer of all shares, or undecided where some are; mixed where some say yes and some no."""
    answers = {answer_of(one) for one in shares}
    if {YES, NO} <= answers:
        return MIXED
    return answers.pop() if len(answers) == 1 else UNDECIDED


def subsets(every: Cells) -> Iterator[tuple[str, Cells]]:
    """The draws with each single reading, in words."""
    for name, values in READINGS.items():
        for value in values:
            yield f"{name}: {value}", {cell: draws.reading(name, value) for cell, draws in every.items()}

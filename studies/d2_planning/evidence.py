"""The judgement of the laws from their runs: costs draw by draw, lost runs, and intervals that hold at once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

import workbench as wb
from studies.d2_planning.batches import AGAIN, DELAYED, DRAWS, MORE, levels_of, sweep_name
from studies.d2_planning.choices import Choice, Item, items
from studies.d2_planning.designs import BY_KEY, CONVERGED, Law, laws_of
from studies.d2_planning.problems import PROBLEMS, Problem
from studies.d2_planning.runs import cost_of, is_lost, terms_of

PRIMARY = wb.evidence.Mean()
KEPT = wb.evidence.Success(1e6)  # each cost is below: the share of runs that are not lost
OTHERS = (wb.evidence.Median(), wb.evidence.Quantile(0.9), wb.evidence.Tail(0.9), KEPT)
STATISTICS = {"median": OTHERS[0].words, "90 % quantile": OTHERS[1].words, "mean of the worst 10 %": OTHERS[2].words}
STATISTICS |= {"mean cost alone": PRIMARY.words, "share of lost runs alone": KEPT.words}
MARGIN = 0.02  # of the smaller value: what is closer is no difference to an engineer
FAMILY = 0.95
CONDITIONS = sum(len(problem.levels) for problem in PROBLEMS.values())
CONFIDENCE = 1 - (1 - FAMILY) / CONDITIONS  # of the intervals at one limit of one plant (Bonferroni)
RESAMPLES, SEED = 2000, 37
WEIGHTS = {
    "error of the whole run alone": (1.0, 0.0, 0.0),
    "late error alone": (0.0, 1.0, 0.0),
    "variation of the inputs alone": (0.0, 0.0, 1.0),
    "late error four times": (1.0, 4.0, 1.0),
    "variation of the inputs four times": (1.0, 1.0, 4.0),
}


@dataclass(frozen=True)
class Condition:
    """A plant, a level of its limits, and the kind of the runs."""

    problem: str
    level: float = 1.0
    kind: str = ""


@dataclass(frozen=True)
class Evidence:
    """All runs of the laws, and what was chosen for each."""

    terms: Mapping[tuple[Condition, str], wb.Array]  # (N, 3), by condition and law
    errors: Mapping[tuple[Condition, str], float]  # of the cost, by the step
    choices: Mapping[Item, Choice]
    judgements: dict[tuple[Condition, str], wb.evidence.LawJudgement] = field(default_factory=dict)

    def cost(self, at: Condition, law: Law, weights: tuple[float, float, float] = (1.0, 1.0, 1.0)) -> wb.Array:
        """The cost of each run, (N,); NaN where the run is lost."""
        return cost_of(PROBLEMS[at.problem], self.terms[at, law.key], weights)

    def lost_runs(self, at: Condition, law: Law) -> int:
        """The number of lost runs."""
        return int(is_lost(PROBLEMS[at.problem], self.terms[at, law.key]).sum())

    def judge(self, at: Condition, words: str = "", only: tuple[str, ...] = ()) -> wb.evidence.LawJudgement:
        """The laws at a condition, by the cost or by one with other weights; `only` some laws."""
        place = (at, f"{words} {only}")
        if place not in self.judgements:
            laws = [law for law in laws_of(PROBLEMS[at.problem]) if not only or law.key in only]
            weights = WEIGHTS[words] if words else (1.0, 1.0, 1.0)
            pairs = wb.evidence.pair_samples(
                {law.name: self.cost(at, law, weights) for law in laws},
                metric="cost",
                errors={law.name: self.errors[at, law.key] for law in laws},
            )
            others = (KEPT,) if words or only else OTHERS
            self.judgements[place] = wb.evidence.judge(
                pairs, PRIMARY, others, confidence=CONFIDENCE, margin=MARGIN, resamples=RESAMPLES, seed=SEED
            )
        return self.judgements[place]

    def order(self, at: Condition, rival: Law, words: str = "") -> str:
        """MPC beside a rival: by the share of lost runs where either loses any, else by the mean cost."""
        mpc = CONVERGED.key
        lost = self.lost_runs(at, BY_KEY[mpc]) + self.lost_runs(at, rival)
        by = self.judge(at, words).by[KEPT.words if lost else PRIMARY.words]
        return by.order(BY_KEY[mpc].name, rival.name)

    def order_of_converged(self, at: Condition, rival: Law) -> str:
        """MPC of many sweeps beside a rival, both at the limits of a condition, as `order` has it."""
        more = Condition(at.problem, at.level, MORE)
        places = {CONVERGED.name: (more, CONVERGED), rival.name: (at, rival)}
        pairs = wb.evidence.pair_samples(
            {name: self.cost(*place) for name, place in places.items()},
            metric="cost",
            errors={name: self.errors[place[0], place[1].key] for name, place in places.items()},
        )
        statistic = KEPT if any(self.lost_runs(*place) for place in places.values()) else PRIMARY
        by = wb.evidence.compare(pairs, statistic, confidence=CONFIDENCE, margin=MARGIN, resamples=RESAMPLES, seed=SEED)
        return by.order(CONVERGED.name, rival.name)

    def order_by(self, at: Condition, rival: Law, statistic: str) -> str:
        """The same by one statistic alone."""
        return self.judge(at).by[statistic].order(BY_KEY[CONVERGED.key].name, rival.name)


def gather(results: wb.Results) -> Evidence:
    """The evidence in the results of the study."""
    terms, errors = dict[tuple[Condition, str], wb.Array](), dict[tuple[Condition, str], float]()
    for problem in PROBLEMS.values():
        for law in laws_of(problem):
            for kind in ("", AGAIN, DELAYED, *((MORE,) if law.key == CONVERGED.key else ())):
                sample = results.sample(sweep_name(problem, law, kind))
                for i, level in enumerate(levels_of(problem, kind)):
                    own = sample.only(np.arange(i * DRAWS, (i + 1) * DRAWS))
                    at = Condition(problem.key, level, kind), law.key
                    terms[at] = terms_of(problem, own.measurement)
                    errors[at] = step_error(problem, own.measurement)
    return Evidence(terms, errors, dict(zip(items(), results.work("choices"), strict=True)))


def step_error(problem: Problem, measurement: wb.metrics.Measurement) -> float:
    """The largest error of the cost by the step, of the runs that were run again and are not lost."""
    heads = ("RMSE", "late", "TV")
    off = np.zeros(len(measurement.looked_at))
    for head, acceptable in zip(heads, problem.acceptable, strict=True):
        own = [i for i, one in enumerate(measurement.columns) if one.metric.startswith(head)]
        off += np.sqrt((measurement.errors[:, -1, own] ** 2).sum(axis=1)) / acceptable
    kept = np.logical_not(is_lost(problem, terms_of(problem, measurement)[measurement.looked_at]))
    return float(np.max(off[kept], initial=0.0)) if np.isfinite(off[kept]).all() else float("inf")

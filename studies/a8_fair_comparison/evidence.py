"""The evidence of a8: the cost of each law draw by draw, judged by its mean and by all that could turn a verdict."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from studies.a8_fair_comparison.conditions import HELD_OUT, HORIZON, TERMS, Scenario, Term, cost, metrics, uncertain
from studies.a8_fair_comparison.entrants import ALL, BOTH, ENTRANTS, GIVEN, PROPOSAL, PROPOSED, Entrant
from workbench.loop import DigitalLoop
from workbench.study import Results, Work
from workbench.study.contract import Run, Sweep
from workbench.study.evidence import (
    Judgement,
    Mean,
    Median,
    Paired,
    Quantile,
    Standings,
    Success,
    Tail,
    judge,
    paired,
)
from workbench.study.evidence.divergence_causes import Causes, causes_in_sweep
from workbench.study.sample import Sample
from workbench.study.tuning import Tuned
from workbench.study.uncertainty import MonteCarlo

Samples = Mapping[str, Sample]  # by the names of laws
ABLATED = ("paper", "payload")  # the scenarios in which AOSMC-RGS loses its parts
ACCEPTABLE = float(len(TERMS))  # a cost at which all terms are acceptable, or make up for each other
ASKED = Mean()
OTHERS = (Median(), Quantile(0.9), Tail(0.9), Success(ACCEPTABLE))
MARGIN = 0.02  # of the smaller value: what is closer is no difference to an engineer, however sure
FAMILY = 0.95  # that all intervals of a measure hold at once, in all held-out scenarios
CONFIDENCE = 1 - (1 - FAMILY) / len(HELD_OUT)  # of those of one scenario (Bonferroni)
RESAMPLES, SEED = 4000, 88
DRAWS, DRAWN = 160, 8  # of each scenario, and their seed
CONTENDERS = 3  # laws of least training cost, and AOSMC-RGS
AS_TUNED = "as tuned, fewer laws"
WEIGHTS = {
    "as tuned for": (1.0, 1.0, 1.0, 1.0),
    "error alone": (1.0, 1.0, 0.0, 0.0),
    "late error four times": (1.0, 4.0, 1.0, 1.0),
    "chattering four times": (1.0, 1.0, 4.0, 1.0),
    "effort four times": (1.0, 1.0, 1.0, 4.0),
    "late error alone": (0.0, 1.0, 0.0, 0.0),
    "chattering alone": (0.0, 0.0, 1.0, 0.0),
}


def other_search(tuned: Tuned) -> dict[str, float]:
    """The best of the search with the least objective among those that the best numbers of all are not from."""
    own = int(np.searchsorted(np.cumsum(tuned.used), tuned.place, side="right"))
    others = (one for one in tuned.searches if one.search != own)
    return tuned.best_of(min(others, key=lambda one: float(one.bests[-1])).seed)


def half_budget(tuned: Tuned) -> dict[str, float]:
    """The best of the first evaluations of each search, half as many as the shortest of them used."""
    return tuned.best_within(min(tuned.used) // 2)


AGAIN: Mapping[str, tuple[str, Callable[[Tuned], dict[str, float]]]] = {  # a kind of sweeps to its words and numbers
    "_other": ("another search", other_search),
    "_half": ("half of the budget", half_budget),
}


def contenders(entrants: Sequence[Entrant], tuned: Mapping[str, Tuned]) -> tuple[Entrant, ...]:
    """The laws of least training cost of those that are given the same, and AOSMC-RGS."""
    least = sorted(entrants, key=lambda one: tuned[one.key].objective)[:CONTENDERS]
    return tuple(one for one in entrants if one in least or one.name == PROPOSED)


def sweep(name: str, loop: DigitalLoop, scenario: Scenario) -> Sweep:
    """A loop over the draws of a scenario, the same for all."""
    factors = uncertain(scenario, loop)
    design = MonteCarlo(len(factors), DRAWS, DRAWN)
    return Sweep(name, Run(loop, metrics(scenario), HORIZON, h=scenario.period, seed=DRAWN), factors, design)


def name_of(scenario: Scenario, key: str) -> str:
    """The name of a sweep: of a law by its key, or of a part that was left out."""
    return f"{scenario.name}_{''.join(c if c.isalnum() else '_' for c in key.lower())}"


def cost_of(held: Samples, terms: tuple[Term, ...] = TERMS, metric: str = "cost", unit: str = "") -> Paired:
    """The cost of each run; its error is the largest of the runs that were run again."""
    values = {law: cost(sample, terms) for law, sample in held.items()}
    errors = {law: sum(step_error(s, term.metric) / term.acceptable for term in terms) for law, s in held.items()}
    return paired(values, metric=metric, unit=unit, errors=errors, samples=held)


def step_error(sample: Sample, metric: str) -> float:
    """The largest error of a metric of both joints by the step; NaN if all that were run again diverged."""
    found = sample.measurement
    places = [i for i, one in enumerate(found.columns) if one.metric == metric]
    errors = found.errors[:, -1, places][np.isnan(sample.diverged_at[found.looked_at])]
    return float(np.hypot(*np.where(np.isnan(errors), np.inf, errors).T).max()) if len(errors) else float("nan")


def weighted(held: Samples, weights: tuple[float, ...]) -> Paired:
    """The cost with other weights: a term that counts w times has 1 / w of its acceptable value."""
    terms = (replace(term, acceptable=term.acceptable / w) for term, w in zip(TERMS, weights, strict=True) if w)
    return cost_of(held, tuple(terms))


def judge_laws(values: Paired, others: Sequence[Median | Quantile | Tail | Success] = OTHERS) -> Judgement:
    """Laws by the mean and by all else, sure enough for verdicts over all scenarios."""
    return judge(values, ASKED, others, confidence=CONFIDENCE, margin=MARGIN, resamples=RESAMPLES, seed=SEED)


@dataclass(frozen=True)
class Evidence:
    """All judgements, made once from the runs."""

    runs: Mapping[str, Mapping[str, Samples]]  # by the key of what a law is given, and by scenario
    cost: Mapping[str, Standings]  # by the same key
    together: Mapping[str, Judgement]  # the cost of each draw, the mean over the scenarios
    again: Mapping[str, Mapping[str, Standings]]  # by key and by what was done: the laws of least training cost
    weighted: Mapping[str, Standings]  # behind both observers, tuned for the first weights
    causes: Mapping[tuple[str, str, str], Causes]  # of lost runs, by scenario, law and words of what it is given
    parts: Mapping[str, tuple[Judgement, ...]]  # by scenario: the cost and each metric, without each part


def evidence(results: Results) -> Evidence:
    """All judgements of the runs."""

    def samples(scenario: Scenario, laws: Sequence[Entrant], kind: str = "") -> dict[str, Sample]:
        return {law.name: results.sample(name_of(scenario, f"{law.key}{kind}")) for law in laws}

    def standings(laws: Sequence[Entrant], kind: str = "") -> Standings:
        return Standings({s.name: judge_laws(cost_of(samples(s, laws, kind))) for s in HELD_OUT})

    tuned = {one.key: results.tuned(one.key) for entrants in ENTRANTS.values() for one in entrants}
    kinds = {AS_TUNED: ""} | {words: kind for kind, (words, _) in AGAIN.items()}
    runs = {key: {s.name: samples(s, entrants) for s in HELD_OUT} for key, entrants in ENTRANTS.items()}
    ours = runs[BOTH.key]
    return Evidence(
        runs,
        {key: standings(entrants) for key, entrants in ENTRANTS.items()},
        {key: judge_laws(mean_cost(held)) for key, held in runs.items()},
        {
            key: {words: standings(contenders(entrants, tuned), kind) for words, kind in kinds.items()}
            for key, entrants in ENTRANTS.items()
        },
        {
            words: Standings({s: judge_laws(weighted(held, weights), ()) for s, held in ours.items()})
            for words, weights in WEIGHTS.items()
        },
        dict(zip(losses(results), results.work("causes"), strict=True)),
        {s.name: without_parts(results, s, ours[s.name][PROPOSED]) for s in HELD_OUT if s.name in ABLATED},
    )


def mean_cost(runs: Mapping[str, Samples]) -> Paired:
    """The mean over the scenarios of each draw, which is the same in all of them."""
    costs = [cost_of(held) for held in runs.values()]
    mean = np.mean([one.values for one in costs], axis=0)
    errors = np.mean([one.errors for one in costs], axis=0)
    laws = costs[0].laws
    values = dict(zip(laws, np.where(np.isinf(mean), np.nan, mean).T, strict=True))
    off = dict(zip(laws, map(float, errors), strict=True))
    return paired(values, metric="cost", errors=off, note=costs[0].note)


@dataclass(frozen=True)
class LostRuns:
    """The runs of a law that diverged in a scenario, by the names of both, their numbers, and the law as tuned."""

    scenario: str
    entrant: str
    runs: tuple[int, ...]
    best: tuple[tuple[str, float], ...]


def losses(results: Results) -> dict[tuple[str, str, str], LostRuns]:
    """The lost runs by scenario, law and words of what it is given."""
    lost = {}
    for given in GIVEN:
        for scenario in HELD_OUT:
            for one in ENTRANTS[given.key]:
                sample = results.sample(name_of(scenario, one.key))
                if sample.failed:
                    runs = np.flatnonzero(np.isfinite(sample.diverged_at)).tolist()
                    best = tuple(results.tuned(one.key).best.items())
                    lost[scenario.name, one.name, given.words] = LostRuns(scenario.name, one.key, tuple(runs), best)
    return lost


def works(results: Results) -> tuple[Work, ...]:
    """The lost runs again, with the memories near their exact flow."""
    return (Work("causes", cause_of, tuple(losses(results).values()), seconds=0.5),)


def cause_of(lost: LostRuns) -> Causes:
    """The causes of lost runs: the integrator, if they last where the memories move near their exact flow."""
    scenario = next(one for one in HELD_OUT if one.name == lost.scenario)
    loop = next(one for one in ALL if one.key == lost.entrant).loop(scenario, dict(lost.best))
    ways = {"declared": loop, "fine": replace(loop, integrator="fine")}
    return causes_in_sweep(sweep(name_of(scenario, lost.entrant), loop, scenario), np.array(lost.runs), ways)


def without_parts(results: Results, scenario: Scenario, proposed: Sample) -> tuple[Judgement, ...]:
    """AOSMC-RGS beside itself less each of its parts: the cost first, then each of its terms."""
    parts = PROPOSAL.loop(scenario, results.tuned(PROPOSAL.key).best).ablations()
    held = {PROPOSED: proposed} | {part: results.sample(name_of(scenario, part)) for part in parts}
    terms = (cost_of(held, (replace(term, acceptable=1.0),), term.metric, term.unit) for term in TERMS)
    return tuple(judge_laws(values, ()) for values in (cost_of(held), *terms))

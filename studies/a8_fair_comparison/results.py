"""All judgements of a8, made once from its runs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from studies.a8_fair_comparison.conditions import HELD_OUT, Scenario
from studies.a8_fair_comparison.entrants import BOTH, ENTRANTS, GIVEN, PROPOSAL, TOLD
from studies.a8_fair_comparison.evidence import (
    ABLATED,
    AGAIN,
    CARD,
    CARDED,
    FEW,
    by_mean,
    causes_of,
    contenders,
    cost_of,
    judged,
    metric_of,
    name_of,
    samples,
    standings,
)
from studies.a8_fair_comparison.laws import PROPOSED
from studies.a8_fair_comparison.objective import LATE, TERMS
from workbench.study.evidence import Judgement, Paired, Standings, paired
from workbench.study.evidence.causes import Causes
from workbench.study.sample import Sample
from workbench.study.study import Results

Runs = Mapping[str, Mapping[str, Sample]]  # by scenario and law
WEIGHTS = {
    "as tuned for": (1.0, 1.0, 1.0, 1.0),
    "error alone": (1.0, 1.0, 0.0, 0.0),
    "late error four times": (1.0, 4.0, 1.0, 1.0),
    "chattering four times": (1.0, 1.0, 4.0, 1.0),
    "effort four times": (1.0, 1.0, 1.0, 4.0),
}


@dataclass(frozen=True)
class Found:
    """What is compared.

    Attributes
    ----------
    runs
        By the key of what a law is given: all laws in all scenarios.
    cost
        The same, judged by cost.
    together
        By the same key: the cost of each draw, the mean over the scenarios.
    again
        By the same key and by what was done: the laws of least training cost, as tuned and otherwise.
    late, chattering
        Of the laws behind both observers.
    weighted
        The cost of the same with other weights of its terms, of runs that were tuned for the first ones.
    told
        The cost of AOSMC-RGS, and of the same law that is told the true disturbance.
    card
        The cost of the laws behind both observers with the numbers of the card, in one scenario.
    causes
        Why runs were lost, by scenario, name of the law and words of what it was given.
    parts
        By scenario, the cost and each metric of AOSMC-RGS and of what is left of it without a part.
    """

    runs: Mapping[str, Runs]
    cost: Mapping[str, Standings]
    together: Mapping[str, Judgement]
    again: Mapping[str, Mapping[str, Standings]]
    late: Standings
    chattering: Standings
    weighted: Mapping[str, Standings]
    told: Standings
    card: Judgement
    causes: Mapping[tuple[str, str, str], Causes]
    parts: Mapping[str, tuple[Judgement, ...]]


@lru_cache(maxsize=1)
def found_of(results: Results) -> Found:
    """All of them."""
    runs = {key: {s.name: samples(results, s, entrants) for s in HELD_OUT} for key, entrants in ENTRANTS.items()}
    tuned = {one.key: results.tuned(one.key) for entrants in ENTRANTS.values() for one in entrants}
    again = {
        key: {
            kind: standings({s.name: samples(results, s, contenders(entrants, tuned), of) for s in HELD_OUT})
            for kind, of in {FEW: "", **{kind: kind for kind in AGAIN}}.items()
        }
        for key, entrants in ENTRANTS.items()
    }
    terms = {term.metric: term for term in TERMS}
    ours = runs[BOTH.key]
    told = {s.name: {PROPOSED: ours[s.name][PROPOSED], f"{PROPOSED}, oracle": _told(results, s)} for s in HELD_OUT}
    carded = next(one for one in HELD_OUT if one.name == CARDED)
    return Found(
        runs,
        {key: standings(held) for key, held in runs.items()},
        {key: judged(_together(held)) for key, held in runs.items()},
        again,
        standings(ours, by_mean, lambda held: metric_of(held, terms[LATE])),
        standings(ours, by_mean, lambda held: metric_of(held, terms["TV"])),
        {
            words: standings(ours, by_mean, lambda held, w=weights: _weighted(held, w))
            for words, weights in WEIGHTS.items()
        },
        standings(told),
        judged(cost_of(samples(results, carded, ENTRANTS[BOTH.key], CARD))),
        _causes(results, runs),
        {s.name: _parts(results, s, ours[s.name][PROPOSED]) for s in HELD_OUT if s.name in ABLATED},
    )


def _together(runs: Runs) -> Paired:
    """The draws are the same in all scenarios, so that each has a cost in all of them."""
    costs = [cost_of(held) for held in runs.values()]
    mean = np.mean([one.values for one in costs], axis=0)
    errors = np.mean([one.errors for one in costs], axis=0)
    laws = costs[0].laws
    return paired(
        dict(zip(laws, np.where(np.isinf(mean), np.nan, mean).T, strict=True)),
        metric="cost",
        errors=dict(zip(laws, map(float, errors), strict=True)),
        note=costs[0].note,
    )


def _causes(results: Results, runs: Mapping[str, Runs]) -> dict[tuple[str, str, str], Causes]:
    return {
        (scenario.name, one.name, given.words): causes_of(sample, one.loop(scenario, numbers), scenario)
        for given in GIVEN
        for scenario in HELD_OUT
        for one in ENTRANTS[given.key]
        for sample in (runs[given.key][scenario.name][one.name],)
        for numbers in (results.tuned(one.key).best,)
        if sample.failed
    }


def _told(results: Results, scenario: Scenario) -> Sample:
    return results.sample(name_of(scenario, TOLD.key))


def _weighted(held: Mapping[str, Sample], weights: tuple[float, ...]) -> Paired:
    # a term that counts w times is one whose acceptable value is 1 / w of what it was
    terms = tuple(replace(term, acceptable=term.acceptable / w) for term, w in zip(TERMS, weights, strict=True) if w)
    return cost_of(held, "cost", terms)


def _parts(results: Results, scenario: Scenario, proposed: Sample) -> tuple[Judgement, ...]:
    """The cost first, then each of its terms."""
    parts = PROPOSAL.loop(scenario, results.tuned(PROPOSAL.key).best).ablations()
    held = {PROPOSED: proposed} | {part: results.sample(name_of(scenario, part)) for part in parts}
    values: list[Paired] = [cost_of(held), *(metric_of(held, term) for term in TERMS)]
    return tuple(map(by_mean, values))

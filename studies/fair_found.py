"""All comparisons of a8, made once from its runs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

from fair_conditions import HELD_OUT, Scenario
from fair_evidence import ABLATED, CARD, CARDED, OTHER, cost_of, judged, metric_of, name_of, samples
from fair_findings import Held
from fair_laws import MAIN, OBSERVED, PROPOSALS, PROPOSED
from fair_objective import LATE, TERMS

from workbench.study.evidence import Comparison, Ranks, ranks
from workbench.study.sample import Sample
from workbench.study.study import Results

WEIGHTS = {
    "as tuned for": (1.0, 1.0, 1.0, 1.0),
    "error alone": (1.0, 1.0, 0.0, 0.0),
    "late error four times": (1.0, 4.0, 1.0, 1.0),
    "chattering four times": (1.0, 1.0, 4.0, 1.0),
    "effort four times": (1.0, 1.0, 1.0, 4.0),
}


@dataclass(frozen=True)
class Found:
    """The cost in each held-out scenario, and what else is compared.

    Attributes
    ----------
    cost, late, chattering
        Of the laws of the paper and two more.
    chances
        The ranks of the same laws by cost.
    weighted
        The cost with other weights of its terms, of runs that were tuned for the first ones.
    observed
        The cost of AOSMC-RGS and of rivals behind its observers.
    told
        The cost of AOSMC-RGS, and of the same law that is told the true disturbance.
    card
        The cost with the numbers of the card, in one scenario, and with those tuned.
    other
        The cost of the laws as the other search tuned them.
    parts
        By scenario, the cost and each metric of AOSMC-RGS and of what is left of it without a part.
    """

    cost: Held
    late: Held
    chattering: Held
    chances: dict[str, Ranks]
    weighted: dict[str, Held]
    observed: Held
    told: Held
    card: Comparison
    other: Held
    parts: dict[str, tuple[Comparison, ...]]


@lru_cache(maxsize=1)
def found_of(results: Results) -> Found:
    """All of them."""
    runs = {scenario.name: samples(results, scenario, MAIN) for scenario in HELD_OUT}
    by_name = {term.metric: term for term in TERMS}
    costs = {name: cost_of(held, name) for name, held in runs.items()}
    proposed = {scenario.name: samples(results, scenario, (PROPOSALS[0],)) for scenario in HELD_OUT}
    return Found(
        {name: judged(one) for name, one in costs.items()},
        {name: judged(metric_of(held, by_name[LATE], name)) for name, held in runs.items()},
        {name: judged(metric_of(held, by_name["TV"], name)) for name, held in runs.items()},
        {name: ranks(one) for name, one in costs.items()},
        {words: _weighted(runs, weights) for words, weights in WEIGHTS.items()},
        {s.name: judged(cost_of(proposed[s.name] | samples(results, s, OBSERVED), s.name)) for s in HELD_OUT},
        {s.name: judged(cost_of(samples(results, s, PROPOSALS), s.name)) for s in HELD_OUT},
        judged(cost_of(_with_card(results, runs[CARDED]), "cost")),
        {s.name: judged(cost_of(samples(results, s, MAIN, OTHER), s.name)) for s in HELD_OUT},
        {s.name: _parts(results, s, proposed[s.name]) for s in HELD_OUT if s.name in ABLATED},
    )


def _weighted(runs: dict[str, dict[str, Sample]], weights: tuple[float, ...]) -> Held:
    # a term that counts w times is one whose acceptable value is 1 / w of what it was
    terms = tuple(replace(term, acceptable=term.acceptable / w) for term, w in zip(TERMS, weights, strict=True) if w)
    return {name: judged(cost_of(held, name, terms)) for name, held in runs.items()}


def _with_card(results: Results, tuned: dict[str, Sample]) -> dict[str, Sample]:
    scenario = next(one for one in HELD_OUT if one.name == CARDED)
    return tuned | {f"{law} as assumed": one for law, one in samples(results, scenario, MAIN, CARD).items()}


def _parts(results: Results, scenario: Scenario, proposed: dict[str, Sample]) -> tuple[Comparison, ...]:
    """The cost first, then each of its terms."""
    best = results.tuned(PROPOSALS[0].key).best
    parts = PROPOSALS[0].loop(scenario, best).ablations()
    held = {PROPOSED: proposed[PROPOSED]} | {part: results.sample(name_of(scenario, part)) for part in parts}
    return (judged(cost_of(held, "cost")), *(judged(metric_of(held, term, term.metric)) for term in TERMS))

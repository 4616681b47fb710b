"""From the runs of a8 to evidence: which law costs how much in which scenario, draw by draw."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache

import numpy as np
from fair_conditions import HELD_OUT, Scenario
from fair_laws import Entrant
from fair_objective import TERMS, Term, both, cost

from workbench.core.layout import Array
from workbench.study.evidence import Comparison, Paired, compare, paired, same_draws
from workbench.study.sample import Sample
from workbench.study.study import Results

RESAMPLES = 2000
SEED = 88
COST = "cost"


def name_of(scenario: Scenario, key: str) -> str:
    """The name of a sweep: of a law by its key, or of a part that was left out."""
    return f"{scenario.name}_{''.join(c if c.isalnum() else '_' for c in key.lower())}"


def samples(results: Results, scenario: Scenario, laws: Sequence[Entrant]) -> dict[str, Sample]:
    """The runs of some laws in a scenario, by the laws' names."""
    return {law.name: results.sample(name_of(scenario, law.key)) for law in laws}


def cost_of(held: Mapping[str, Sample], name: str, terms: tuple[Term, ...] = TERMS) -> Paired:
    """The cost of each run, under the name of a scenario."""
    values = {law: cost(sample, terms) for law, sample in held.items()}
    errors = {law: sum(_error(s, term.metric) / term.acceptable for term in terms) for law, s in held.items()}
    return paired(values, metric=name, errors=errors, note=same_draws(held))


def metric_of(held: Mapping[str, Sample], term: Term, name: str) -> Paired:
    """One metric of each run, both joints together."""
    values = {law: both(sample, term.metric) for law, sample in held.items()}
    errors = {law: _error(sample, term.metric) for law, sample in held.items()}
    return paired(values, metric=name, unit=term.unit, errors=errors, note=same_draws(held))


def judged(values: Paired) -> Comparison:
    """Medians over the draws, and all differences."""
    return compare(values, resamples=RESAMPLES, seed=SEED)


def ratio(values: Paired, a: str, b: str) -> tuple[float, float, float]:
    """The median over the draws of the value of law a over that of law b, with the ends of its interval."""
    columns = {law: np.log(values.values[:, values.place(law)]) for law in (a, b)}
    found = compare(paired(columns, metric="log"), resamples=RESAMPLES, seed=SEED).difference
    return tuple(float(np.exp(part[0, 1])) for part in (found.value, found.low, found.high))


def _error(sample: Sample, metric: str) -> float:
    return float(np.hypot(sample.step_error(metric, 0), sample.step_error(metric, 1)))

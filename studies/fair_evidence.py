"""From the runs of a8 to evidence: which law costs how much in which scenario, draw by draw."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from fair_conditions import HELD_OUT, Scenario
from fair_laws import Entrant
from fair_objective import TERMS, Term, both, cost

from workbench.core.layout import Array
from workbench.study.evidence import Comparison, Paired, compare, paired, same_draws
from workbench.study.sample import Sample
from workbench.study.study import Results
from workbench.study.tuning import Tuned

ABLATED = ("paper", "payload")  # the scenarios in which AOSMC-RGS loses its parts
CARD, OTHER = "_card", "_other"  # kinds of sweeps
CARDED = "paper"  # that in which the numbers of the card are tried
MARGIN = 0.02  # of the smaller value: what is closer is no difference to an engineer, however sure
FAMILY = 0.95  # that all intervals of a measure hold at once, in all held-out scenarios
CONFIDENCE = 1 - (1 - FAMILY) / len(HELD_OUT)  # of those of one scenario (Bonferroni)
RESAMPLES = 4000
SEED = 88


def name_of(scenario: Scenario, key: str) -> str:
    """The name of a sweep: of a law by its key, or of a part that was left out."""
    return f"{scenario.name}_{''.join(c if c.isalnum() else '_' for c in key.lower())}"


def of_other_search(tuned: Tuned) -> dict[str, float]:
    """The best numbers, at the step h, of the searches that the best point of all is not from.

    Raises
    ------
    ValueError
        If these found none that is admissible.
    """
    searches = np.arange(len(tuned.objectives)) // tuned.tuning.evaluations
    others = np.where(searches == searches[tuned.place], np.inf, tuned.objectives)
    if not np.isfinite(others).any():
        raise ValueError(f"The other search of '{tuned.name}' found no admissible point: take more evaluations.")
    names = (factor.name for factor in tuned.tuning.factors)
    return dict(zip(names, map(float, tuned.numbers[int(np.argmin(others))]), strict=True))


def samples(results: Results, scenario: Scenario, laws: Sequence[Entrant], kind: str = "") -> dict[str, Sample]:
    """The runs of some laws in a scenario, by the laws' names; of a kind, as with the numbers of the card."""
    return {law.name: results.sample(name_of(scenario, f"{law.key}{kind}")) for law in laws}


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
    """Medians over the draws, and all differences, sure enough for verdicts over all scenarios."""
    return compare(values, confidence=CONFIDENCE, margin=MARGIN, resamples=RESAMPLES, seed=SEED)


def ratio(values: Paired, a: str, b: str) -> tuple[float, float, float]:
    """The median over the draws of law a over that of law b, with the ends of its interval."""
    columns = {law: np.log(values.values[:, values.place(law)]) for law in (a, b)}
    found = compare(paired(columns, metric="log"), resamples=RESAMPLES, seed=SEED).difference
    return tuple(float(np.exp(part[0, 1])) for part in (found.value, found.low, found.high))


def step_errors(sample: Sample, metric: str) -> Array:
    """By how much a metric of both joints may change from h to h / 2, in each run that was run again and is finite."""
    places = [i for i, (name, _, _) in enumerate(sample.columns) if name == metric]
    errors = sample.errors[:, -1, places][np.isnan(sample.diverged_at[sample.again])]
    return np.hypot(*np.where(np.isnan(errors), np.inf, errors).T) if len(errors) else np.empty(0)


def _error(sample: Sample, metric: str) -> float:
    """The largest of the runs that were run again: no median moves farther than its runs; NaN if all diverged."""
    errors = step_errors(sample, metric)
    return float(errors.max()) if len(errors) else float("nan")

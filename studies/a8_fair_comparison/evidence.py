"""From the runs of a8 to evidence: which law costs how much in which scenario, draw by draw."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from studies.a8_fair_comparison.conditions import HELD_OUT, HORIZON, Computed, Scenario, uncertain
from studies.a8_fair_comparison.entrants import Entrant
from studies.a8_fair_comparison.laws import PROPOSED, Numbers
from studies.a8_fair_comparison.objective import TERMS, Term, both, cost, metrics
from workbench.study.contract import Run
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
    same_draws,
)
from workbench.study.evidence.causes import Causes, causes_in_sweep
from workbench.study.sample import Sample
from workbench.study.study import Results
from workbench.study.sweep import Sweep
from workbench.study.tuning import Tuned
from workbench.study.uncertainty import MonteCarlo
from workbench.validation.refusals import Array

ABLATED = ("paper", "payload")  # the scenarios in which AOSMC-RGS loses its parts
CARD = "_card"  # a kind of sweeps
CARDED = "paper"  # that in which the numbers of the card are tried
ACCEPTABLE = float(len(TERMS))  # a cost at which all terms are acceptable, or make up for each other
ASKED = Mean()
OTHERS = (Median(), Quantile(0.9), Tail(0.9), Success(ACCEPTABLE))
MARGIN = 0.02  # of the smaller value: what is closer is no difference to an engineer, however sure
FAMILY = 0.95  # that all intervals of a measure hold at once, in all held-out scenarios
CONFIDENCE = 1 - (1 - FAMILY) / len(HELD_OUT)  # of those of one scenario (Bonferroni)
RESAMPLES = 4000
SEED = 88
DRAWS, DRAWN = 160, 8  # of each scenario, and their seed
CONTENDERS = 3  # laws of least training cost, and AOSMC-RGS


def other_search(tuned: Tuned) -> Numbers:
    """The best of the search with the least objective among those that the best numbers of all are not from."""
    own = int(np.searchsorted(np.cumsum(tuned.used), tuned.place, side="right"))
    others = (one for one in tuned.searches if one.search != own)
    return tuned.best_of(min(others, key=lambda one: float(one.bests[-1])).seed)


def half_budget(tuned: Tuned) -> Numbers:
    """The best of the first evaluations of each search, half as many as the shortest of them used."""
    return tuned.best_within(min(tuned.used) // 2)


AGAIN: Mapping[str, Callable[[Tuned], Numbers]] = {"_other": other_search, "_half": half_budget}
FEW = "_few"  # the same laws as tuned
WORDS = {FEW: "as tuned, fewer laws", "_other": "another search", "_half": "half of the budget"}
TOGETHER = "all scenarios together"


def contenders(entrants: Sequence[Entrant], tuned: Mapping[str, Tuned]) -> tuple[Entrant, ...]:
    """The laws of least training cost of those that are given the same, and AOSMC-RGS."""
    least = sorted(entrants, key=lambda one: tuned[one.key].objective)[:CONTENDERS]
    return tuple(one for one in entrants if one in least or one.name == PROPOSED)


def sweep(name: str, loop: Computed, scenario: Scenario) -> Sweep:
    """A loop over the draws of a scenario, the same for all."""
    factors = uncertain(scenario, loop)
    design = MonteCarlo(len(factors), DRAWS, DRAWN)
    return Sweep(name, Run(loop, metrics(scenario), HORIZON, h=scenario.period, seed=DRAWN), factors, design)


def causes_of(sample: Sample, loop: Computed, scenario: Scenario) -> Causes:
    """Why runs of a law were lost: by its integrator, if they last where the memories move near their exact flow."""
    lost = np.flatnonzero(np.isfinite(sample.diverged_at))
    ways = {"declared": loop, "fine": replace(loop, integrator="fine")}
    return causes_in_sweep(sweep(sample.name, loop, scenario), lost, ways)


def name_of(scenario: Scenario, key: str) -> str:
    """The name of a sweep: of a law by its key, or of a part that was left out."""
    return f"{scenario.name}_{''.join(c if c.isalnum() else '_' for c in key.lower())}"


def samples(results: Results, scenario: Scenario, laws: Sequence[Entrant], kind: str = "") -> dict[str, Sample]:
    """The runs of some laws in a scenario, by the laws' names; of a kind, as with the numbers of the card."""
    return {law.name: results.sample(name_of(scenario, f"{law.key}{kind}")) for law in laws}


def cost_of(held: Mapping[str, Sample], name: str = "cost", terms: tuple[Term, ...] = TERMS) -> Paired:
    """The cost of each run."""
    values = {law: cost(sample, terms) for law, sample in held.items()}
    errors = {law: sum(_error(s, term.metric) / term.acceptable for term in terms) for law, s in held.items()}
    return paired(values, metric=name, errors=errors, note=same_draws(held))


def metric_of(held: Mapping[str, Sample], term: Term) -> Paired:
    """One metric of each run, both joints together."""
    values = {law: both(sample, term.metric) for law, sample in held.items()}
    errors = {law: _error(sample, term.metric) for law, sample in held.items()}
    return paired(values, metric=term.metric, unit=term.unit, errors=errors, note=same_draws(held))


def judged(values: Paired) -> Judgement:
    """By the mean and by all else, sure enough for verdicts over all scenarios."""
    return judge(values, ASKED, OTHERS, confidence=CONFIDENCE, margin=MARGIN, resamples=RESAMPLES, seed=SEED)


def by_mean(values: Paired) -> Judgement:
    """By the mean alone: for what stands beside a judgement."""
    return judge(values, ASKED, confidence=CONFIDENCE, margin=MARGIN, resamples=RESAMPLES, seed=SEED)


def standings(
    runs: Mapping[str, Mapping[str, Sample]],
    judged: Callable[[Paired], Judgement] = judged,
    values: Callable[[Mapping[str, Sample]], Paired] = cost_of,
) -> Standings:
    """The runs of some laws by scenario, judged."""
    return Standings({scenario: judged(values(held)) for scenario, held in runs.items()})


def step_errors(sample: Sample, metric: str) -> Array:
    """By how much a metric of both joints may change from h to h / 2, in each run that was run again and is finite."""
    places = [i for i, (name, _, _) in enumerate(sample.columns) if name == metric]
    errors = sample.errors[:, -1, places][np.isnan(sample.diverged_at[sample.again])]
    return np.hypot(*np.where(np.isnan(errors), np.inf, errors).T) if len(errors) else np.empty(0)


def _error(sample: Sample, metric: str) -> float:
    """The largest of the runs that were run again: no statistic moves farther than its runs; NaN if all diverged."""
    errors = step_errors(sample, metric)
    return float(errors.max()) if len(errors) else float("nan")

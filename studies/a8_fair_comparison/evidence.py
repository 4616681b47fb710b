"""The evidence of a8: the cost of each law draw by draw, judged by its mean and by all that could change an answer."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

import workbench as wb
from studies.a8_fair_comparison.ablations import PARTS, RETUNED_ENTRANTS, STEADY
from studies.a8_fair_comparison.other_numbers import AGAIN, NUMBERS, PLAIN, RIVALS, contenders, run_name
from studies.paper.costs import PRIMARY, WEIGHTS, Samples, cost_of, judge_laws, judge_means, weighted_cost
from studies.paper.entrants import (
    ALL,
    ALL_INFORMATION,
    BOTH,
    ENTRANTS,
    PROPOSAL,
    PROPOSED_LAW,
    READINGS,
    Entrant,
)
from studies.paper.fitted_arm import FIT, fitted_factors, unless_fitted, with_fit
from studies.paper.scenarios import HELD_OUT, HORIZON, TERMS, Scenario, Term, metrics
from studies.paper.scenarios import uncertain as uncertain_on_paper

DRAWS, DRAW_SEED = 160, 8  # of each scenario, and their seed
REWEIGHTED_KEYS = (BOTH.key, READINGS.key)  # what is given to the laws that are judged with other weights, too


def uncertain_of_fit(scenario: Scenario, loop: wb.DigitalLoop) -> tuple[wb.Factor, ...]:
    """The factors that are drawn anew in each run, with the directions of the fit in place of its numbers' ranges."""
    return fitted_factors(uncertain_on_paper(scenario, loop), loop)


uncertain = unless_fitted(uncertain_of_fit)(uncertain_on_paper)


def sweep(name: str, loop: wb.DigitalLoop, scenario: Scenario) -> wb.Sweep:
    """A loop over the draws of a scenario, the same for all."""
    factors = uncertain(scenario, loop)
    design = wb.uncertainty.MonteCarlo(len(factors), DRAWS, DRAW_SEED)
    return wb.Sweep(name, wb.Run(loop, metrics(scenario), HORIZON, h=scenario.period, seed=DRAW_SEED), factors, design)


def name_of(scenario: Scenario, key: str) -> str:
    """The name of a sweep: of a law by its key, or of a part that was left out."""
    return f"{scenario.name}_{''.join(c if c.isalnum() else '_' for c in key.lower())}"


@dataclass(frozen=True)
class Evidence:
    """All judgements, made once from the runs."""

    runs: Mapping[str, Mapping[str, Samples]]  # by the key of what a law is given, and by scenario
    cost: Mapping[str, wb.evidence.Standings]  # by the same key
    # by key: all scenarios together, and without each
    pooled_judgements: Mapping[str, Mapping[wb.evidence.Way, wb.evidence.PooledJudgement]]
    # by key and by what was changed for the laws of least training cost
    changed_standings: Mapping[str, Mapping[str, wb.evidence.Standings]]
    # by key of REWEIGHTED_KEYS: the cost with other weights of its terms
    weighted_standings: Mapping[str, Mapping[str, wb.evidence.Standings]]
    # of lost runs, by scenario, law and words of what it is given
    causes: Mapping[tuple[str, str, str], wb.evidence.Causes]
    parts: Parts


@dataclass(frozen=True)
class Parts:
    """AOSMC-RGS beside itself without each of its parts, and beside plain ASMC, over all scenarios."""

    # with the numbers of the whole law; P at P(0) without (34), and at its steady value
    frozen_parts: wb.evidence.PooledJudgement
    retuned_parts: Mapping[wb.evidence.Way, wb.evidence.PooledJudgement]  # tuned again without the part
    # the whole law, the law without (34) and plain ASMC, each with other numbers, by `run_name`
    searches: wb.evidence.PooledJudgement
    by_term: tuple[wb.evidence.Comparison, ...]  # the same by the cost and each of its terms, by the geometric mean


def evidence(results: wb.Results) -> Evidence:
    """All judgements of the runs."""
    runs = {key: {s.name: samples(results, s, entrants) for s in HELD_OUT} for key, entrants in ENTRANTS.items()}
    cost = {key: {s: cost_of(held) for s, held in by.items()} for key, by in runs.items()}
    return Evidence(
        runs,
        {key: wb.evidence.Standings({s: judge_laws(one) for s, one in by.items()}) for key, by in cost.items()},
        {
            key: {way: wb.evidence.leave_one_out(by, judge_means, way) for way in wb.evidence.WAYS}
            for key, by in cost.items()
        },
        {key: with_other_numbers(results, key, runs[key]) for key in ENTRANTS},
        {
            key: {
                words: wb.evidence.Standings({s: judge_means(weighted_cost(held, weights)) for s, held in by.items()})
                for words, weights in WEIGHTS.items()
            }
            for key, by in runs.items()
            if key in REWEIGHTED_KEYS
        },
        dict(zip(losses(results), results.work("causes"), strict=True)),
        without_parts(results, runs[BOTH.key]),
    )


def samples(
    results: wb.Results, scenario: Scenario, laws: Sequence[Entrant], kind: str = ""
) -> dict[str, wb.study.Sample]:
    """The runs of laws in a scenario, by the names of the laws."""
    return {law.name: results.sample(name_of(scenario, f"{law.key}{kind}")) for law in laws}


def with_other_numbers(results: wb.Results, key: str, runs: Mapping[str, Samples]) -> dict[str, wb.evidence.Standings]:
    """The laws of least training cost with other numbers, beside the other laws as tuned, and by themselves.

    Among fewer laws there are fewer comparisons, with narrower intervals, so that laws alone are a change of their own.
    """
    some = contenders(ENTRANTS[key], {one.key: results.tuning(one.key) for one in ENTRANTS[key]})
    count = NUMBERS[len(some)]
    found = {}
    for words, kind in {"": "", **{words: kind for kind, (words, _) in AGAIN.items()}}.items():
        changed = {s.name: samples(results, s, some, kind) for s in HELD_OUT}
        if kind:
            beside = {
                name: {law: changed[name].get(law, one) for law, one in held.items()} for name, held in runs.items()
            }
            found[f"{words} of each of {count} laws"] = standings(beside)
        found[", ".join(filter(None, (words, f"{count} laws alone")))] = standings(changed)
    return found


def standings(runs: Mapping[str, Samples]) -> wb.evidence.Standings:
    """Laws by their mean costs in each scenario."""
    return wb.evidence.Standings({name: judge_means(cost_of(held)) for name, held in runs.items()})


@dataclass(frozen=True)
class LostRuns:
    """The runs of a law that diverged in a scenario, by the names of both, their numbers, and the law as tuned."""

    scenario: str
    entrant: str
    runs: tuple[int, ...]
    best: tuple[tuple[str, float], ...]


def losses(results: wb.Results) -> dict[tuple[str, str, str], LostRuns]:
    """The lost runs by scenario, law and words of what it is given."""
    lost = {}
    for given in ALL_INFORMATION:
        for scenario in HELD_OUT:
            for one in ENTRANTS[given.key]:
                sample = results.sample(name_of(scenario, one.key))
                if sample.diverged_count:
                    runs = np.flatnonzero(np.isfinite(sample.diverged_at)).tolist()
                    best = tuple(results.tuning(one.key).best.items())
                    lost[scenario.name, one.name, given.words] = LostRuns(scenario.name, one.key, tuple(runs), best)
    return lost


def works(results: wb.Results) -> tuple[wb.Work, ...]:
    """The lost runs again, with the memories near their exact flow."""
    return (
        wb.Work("causes", cause_of if FIT is None else cause_with_fit, tuple(losses(results).values()), seconds=0.5),
    )


def cause_of(runs: LostRuns) -> wb.evidence.Causes:
    """The causes of lost runs: the integrator, if they last where the memories move near their exact flow."""
    scenario = next(one for one in HELD_OUT if one.name == runs.scenario)
    loop = next(one for one in ALL if one.key == runs.entrant).loop(scenario, dict(runs.best))
    ways = {"declared": loop, "fine": replace(loop, integrator="fine")}
    swept = sweep(name_of(scenario, runs.entrant), loop, scenario)
    return wb.evidence.causes_in_sweep(swept, np.array(runs.runs), ways)


def cause_with_fit(runs: LostRuns) -> wb.evidence.Causes:
    """The causes of lost runs of loops that have the estimates of a fit."""
    scenario = next(one for one in HELD_OUT if one.name == runs.scenario)
    loop = with_fit(next(one for one in ALL if one.key == runs.entrant).loop(scenario, dict(runs.best)))
    ways = {"declared": loop, "fine": replace(loop, integrator="fine")}
    swept = sweep(name_of(scenario, runs.entrant), loop, scenario)
    return wb.evidence.causes_in_sweep(swept, np.array(runs.runs), ways)


def without_parts(results: wb.Results, runs: Mapping[str, Samples]) -> Parts:
    """AOSMC-RGS beside itself without each of its parts, over all scenarios."""
    less = {**{part: part for part in PARTS}, STEADY: STEADY}
    again = {part: one.key for part, one in RETUNED_ENTRANTS.items()}

    def beside(others: Mapping[str, str], *laws: str) -> dict[str, Samples]:
        """The laws as they are judged above, with other runs, by scenario."""
        return {
            s.name: {law: runs[s.name][law] for law in laws}
            | {name: results.sample(name_of(s, key)) for name, key in others.items()}
            for s in HELD_OUT
        }

    frozen, retuned = (
        {name: cost_of(held) for name, held in beside(others, PROPOSED_LAW, PLAIN).items()} for others in (less, again)
    )
    alone = beside(again, PROPOSED_LAW)
    costs: list[Callable[[Samples], wb.evidence.PairedSamples]] = [
        cost_of,
        *(partial(term_of, term=term) for term in TERMS),
    ]
    return Parts(
        wb.evidence.leave_one_out(frozen, judge_means),
        {way: wb.evidence.leave_one_out(retuned, judge_means, way) for way in wb.evidence.WAYS},
        wb.evidence.leave_one_out({s.name: cost_of(search_samples(results, s)) for s in HELD_OUT}, judge_means),
        tuple(
            judge_means(wb.evidence.pool({name: of(held) for name, held in alone.items()})).by[PRIMARY.words]
            for of in costs
        ),
    )


def search_samples(results: wb.Results, scenario: Scenario) -> dict[str, wb.study.Sample]:
    """The runs of AOSMC-RGS, of the law without (34) and of plain ASMC, as tuned and with other numbers."""
    return {
        run_name(law, kind): results.sample(name_of(scenario, one.key + kind))
        for law, one in ((PROPOSED_LAW, PROPOSAL), *RIVALS.items())
        for kind in ("", *AGAIN)
    }


def together(standings: wb.evidence.Standings) -> wb.evidence.LawJudgement:
    """The laws of several scenarios by the geometric mean of their costs, mean over the draws."""
    return judge_means(wb.evidence.pool({name: one.samples for name, one in standings.judgements.items()}))


def by_mean_costs(members: Mapping[str, wb.evidence.PairedSamples]) -> wb.evidence.LawJudgement:
    """The laws by the geometric mean over the scenarios of their mean costs m_s, G = (prod_s m_s)^(1/S).

    Draw k counts as G (1/S) sum_s y_sk / m_s, of which the mean is G, so that intervals hold to first order. The errors
    of the steps are those of the runs that have them, treated alike. A law with a failed run is left out.
    """
    means = {name: one.values.mean(axis=0) for name, one in members.items()}
    level = np.exp(np.log(list(means.values())).mean(axis=0))
    kept = np.flatnonzero(np.isfinite(level))
    parts = {}
    for name, one in members.items():
        factor = level[kept] / means[name][kept]
        off = None if one.step_errors is None else one.step_errors[:, kept] * factor
        parts[name] = replace(
            one,
            laws=tuple(one.laws[i] for i in kept),
            values=one.values[:, kept] * factor,
            errors=one.errors[kept] * factor,
            failures=one.failures[kept],
            sources=(),
            step_errors=off,
        )
    return judge_means(wb.evidence.pool(parts, "arithmetic mean"))


def term_of(samples: Samples, term: Term) -> wb.evidence.PairedSamples:
    """A term of the cost in its own unit."""
    return cost_of(samples, (replace(term, acceptable=1.0),), term.metric, term.unit)

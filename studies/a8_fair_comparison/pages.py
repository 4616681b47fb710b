"""The page of a8: pictures and findings first, then what they rest on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from studies.a8_fair_comparison import conditions, findings
from studies.a8_fair_comparison.conditions import HELD_OUT, LATE, TERMS, both
from studies.a8_fair_comparison.entrants import (
    BOTH,
    ENTRANTS,
    FILTER,
    GIVEN,
    OBSERVER,
    PROPOSAL,
    PROPOSED,
    READINGS,
    Given,
)
from studies.a8_fair_comparison.evidence import ASKED, CONFIDENCE, FAMILY, Evidence, evidence
from workbench.notation.formula import symbol
from workbench.study.document.document import Column, Figure, Measured, Paragraph, Phrase, Reference, Section, Table
from workbench.study.document.phrases import raised
from workbench.study.evidence import ablation_table, statistics_table
from workbench.study.evidence.law_tables import information_table
from workbench.study.pictures import budget_curves, pareto_fronts, standings_figure
from workbench.study.pictures.traces import loops_section
from workbench.study.study import Results
from workbench.study.tuning import Tuned
from workbench.study.uncertainty.factors import Space
from workbench.validation.refusals import Array

TURNED = (
    "Each law as it was tuned behind both observers, in the first held-out scenario with one draw of the noise. In the "
    "page of this report the conditions that are drawn are knobs."
)


def sections(results: Results) -> Sequence[Section]:
    held = evidence(results)
    return (
        answer(held),
        dependence(held),
        conditions_section(),
        parts(held),
        tuning(results),
        trust(results),
        loops_section("The laws, to be turned", TURNED, results.outcomes),
    )


def answer(held: Evidence) -> Section:
    return Section(
        "What was found",
        (
            standings(held, BOTH),
            short(standings(held, READINGS)),
            *(findings.winner(held, given) for given in reversed(GIVEN)),
            findings.proposed(held),
            findings.diverged(held),
            findings.parts_matter(held),
            short(standings(held, FILTER)),
            short(standings(held, OBSERVER)),
        ),
    )


def standings(held: Evidence, given: Given) -> Figure:
    judgements = held.cost[given.key].judgements
    return standings_figure(
        f"standings_{given.key}",
        f"Cost of the laws in each held-out scenario, all given {given.words}.",
        {scenario: one.by for scenario, one in judgements.items()},
        ASKED.words,
    )


def short(shown: Figure) -> Figure:
    """A figure without the note that the first of its kind has."""
    return replace(shown, caption=shown.numbers.caption)


def dependence(held: Evidence) -> Section:
    """The laws over all scenarios together by each statistic, and with other weights of the cost."""
    weights = Table(
        "weights",
        f"In how many held-out scenarios each law has the least {findings.MEASURE}, with other weights of the terms.",
        (Column("weights"), Column("best in")),
        tuple((words, findings.counts(one)) for words, one in held.weighted.items()),
        ("The runs are those of laws tuned for the first row. Open: no law is significantly best.",),
    )
    together = (
        statistics_table(
            f"together_{given.key}", f"Cost over all scenarios together, given {given.words}.", held.together[given.key]
        )
        for given in GIVEN
    )
    return Section("What the verdicts depend on", (*together, weights))


def conditions_section() -> Section:
    """All that is the same for all laws, and what each is given."""
    first = HELD_OUT[0]
    loop = PROPOSAL.loop(first)
    equation = loop.ode()
    drawn = Space(conditions.uncertain(first, loop), equation.parameters, equation.states)
    return Section(
        "What is the same for all laws",
        (
            Paragraph(
                "A law's model has the paper's masses and lengths; the arm has others, and friction, which no model "
                "knows. AOSMC-RGS is repaired as in a1. In place of (24), which needs the unknown D, stands an "
                "observer of the momentum, which can be built; D_hat is added to the torque of every law behind it. "
                "The first estimate of (10) is the arm's start, as a first reading without noise gives it. PID alone "
                "has no model. Memories move by explicit Euler, but for three that are stiff: (34) and observer (10) "
                "move by a Cayley step, the filter of the velocity and the leak of the network exactly."
            ),
            information(),
            scenarios(),
            drawn.table("drawn", "What is drawn anew in each of the runs of a held-out scenario, shown for the first."),
            Table(
                "objective",
                "The terms of the cost: each metric, both joints together, over what is called acceptable.",
                (Column("metric"), Column("acceptable", align="right"), Column("unit"), Column("what it stands for")),
                tuple((term.metric, term.acceptable, term.unit, term.why) for term in TERMS),
            ),
            Paragraph(
                (
                    "The cost is the sum of the terms: one objective for all, linear, so that no law gains by giving "
                    "up motion for a still torque. What is acceptable is our choice; ",
                    Reference("weights"),
                    " shows who is best under others.",
                )
            ),
        ),
    )


def information() -> Table:
    entrants = {one.name: one for one in ENTRANTS[BOTH.key]}
    others = (one for given in GIVEN if given != BOTH for one in ENTRANTS[given.key] if one.name in ("SMC", "PID"))
    entrants |= {f"{one.name}, {one.given.name}": one for one in others}
    return information_table(
        "information",
        "Who is given what: all laws behind both observers, and two of them behind the rest.",
        {name: one.loop(HELD_OUT[0]).loop for name, one in entrants.items()},
        {name: len(one.tuned) for name, one in entrants.items()},
    )


def scenarios() -> Table:
    usual = HELD_OUT[0]
    limit, viscous, coulomb = (f"{a:g} and {b:g}" for a, b in (conditions.LIMIT, usual.viscous, usual.coulomb))
    rows = [(one.name, "training", one.words) for one in conditions.TRAINING]
    rows += [(one.name, "held out", one.words) for one in HELD_OUT]
    return Table(
        "scenarios",
        "The scenarios.",
        (Column("name"), Column("for"), Column("what is wanted, and what is unusual")),
        tuple(rows),
        (
            f"Unless said otherwise: the model's masses, {limit} N m of torque, a period of "
            f"{1e3 * conditions.PERIOD:g} ms, friction of {viscous} N m s/rad and {coulomb} N m, the paper's "
            f"disturbance, and normal noise of {conditions.NOISE_Q:g} rad and {conditions.NOISE_QD:g} rad/s, fresh at "
            "each reading. 'A slower motion' has amplitudes of 0.6 and 0.8 rad at 1.5 and 2.2 rad/s, 'a faster motion' "
            f"0.9 and 0.6 rad at 3.5 and 5 rad/s. A run takes {conditions.HORIZON:g} s.",
        ),
    )


def parts(held: Evidence) -> Section:
    words = (
        "AOSMC-RGS as tuned, less one part at a time, without tuning it again: a law is not better or worse for a part "
        "alone, but for the part at these numbers. Without its state observer it takes the noisy readings; without its "
        "boundary layer it switches once a period."
    )
    tables = (
        ablation_table(
            f"parts_{key}",
            f"AOSMC-RGS less each of its parts, scenario '{key}'.",
            [one.by[ASKED.words] for one in judgements],
            PROPOSED,
        )
        for key, judgements in held.parts.items()
    )
    return Section("What makes the difference", (Paragraph(words), *tables))


def trust(results: Results) -> Section:
    return Section(
        "How far to trust this",
        (
            Paragraph(
                f"Intervals are those of chance in the draws. Those of a scenario hold at once with "
                f"{100 * CONFIDENCE:g} %, so that all of a statistic and of what is given do in all {len(HELD_OUT)} "
                f"scenarios with {100 * FAMILY:g} %, about: of a skewed sample of 160 draws 99.5 % held 98.7 % in a "
                "trial. The draws are the same in all scenarios, so that these are not as many independent trials. "
                "Intervals do not hold the chance of a search, which may end far from another of the same law, nor "
                "the choice of objective, scenarios and ranges. Errors of the step are the largest of the runs that "
                "were run again, one of sixteen: the arm is integrated by RK4 once a period, and there twice. The laws "
                "were tuned for two masses; a tuning over draws would make all of them more robust, at many times the "
                "cost. Not tuned were the nodes of the network of RBF-ASMC and the rules of Fuzzy-ASMC, those of a1."
            ),
            *(tuned_numbers(results, given) for given in GIVEN),
        ),
    )


NOTE = (
    "Here and in the tables below. Least cost: the mean over both training scenarios and the training noises of all "
    "searches; in brackets its error by the step. Of each search: its least cost under its own noise."
)


def tuning(results: Results) -> Section:
    shown = {one.name: results.tuned(one.key) for one in ENTRANTS[BOTH.key]}
    note = next(iter(shown.values())).note
    budget = budget_curves(
        "budget",
        "The least cost so far, all laws behind both observers. Bands: between the searches.",
        {name: curves(one) for name, one in shown.items()},
        f"Of {next(iter(shown))}: {note}",
        "cost",
    )
    late_error, chattering = (
        lambda runs, metric=metric: np.mean([both(sample, metric) for sample in runs.values()], axis=0)
        for metric in (LATE, "TV")
    )
    front = pareto_fronts(
        "front_chattering",
        "Error against chattering in the training scenarios: points of the searches that none beats in both.",
        {name: one.measures(late_error, chattering) for name, one in shown.items()},
        "The runs of the figure above",
        "late RMSE [rad]",
        "TV [N m/s]",
    )
    tables = (searches(results, given, (NOTE,) if given == GIVEN[0] else ()) for given in GIVEN)
    return Section("Tuning with the same budget", (budget, front, *tables))


def searches(results: Results, given: Given, notes: tuple[str, ...]) -> Table:
    rows = []
    for entrant in ENTRANTS[given.key]:
        tuned = results.tuned(entrant.key)
        cost, bests = Measured(tuned.objective, tuned.step_error), ", ".join(f"{best:.4g}" for best in tuned.bests)
        physical = (f"'{name}' is at a physical limit: {why}." for name, why in tuned.at_physical.items())
        rows.append((entrant.name, len(entrant.tuned), cost, bests, " ".join((*tuned.warnings, *physical))))
    heads = (Column("law"), *(Column(name, align="right") for name in ("numbers", "least cost")))
    columns = (*heads, Column("of each search"), Column("doubts, and limits"))
    return Table(f"searches_{given.key}", f"The searches of all laws given {given.words}.", columns, tuple(rows), notes)


def tuned_numbers(results: Results, given: Given) -> Table:
    rows = []
    for entrant in ENTRANTS[given.key]:
        best = results.tuned(entrant.key).best
        for one in entrant.tuned:
            spread, tuned = f"{one.low:g} to {one.high:g}", f"{best[one.name]:.7g}"
            rows.append((entrant.name, letter(one.name), raised(one.unit), spread, tuned))
    heads = tuple(map(Column, ("law", "number", "unit", "begins within", "as tuned")))
    note = (
        "Sought on a scale of logarithms, from where a search begins to a thousandth of its lower and a thousand times "
        "its upper end, where no physical limit comes before."
    )
    notes = (note,) if given == GIVEN[0] else ()
    return Table(f"numbers_{given.key}", f"The numbers as tuned, given {given.words}.", heads, tuple(rows), notes)


def letter(name: str) -> Phrase:
    """A number's name as it is printed: K(0) by its letter too."""
    stem, bracket, rest = name.partition("(")
    return (symbol(stem), bracket + rest) if bracket else name if name == "lag" else symbol(name)


def curves(one: Tuned) -> tuple[Array, Array]:
    """The evaluations, and the best so far of each search; one that ended early stays where it was."""
    longest = max(one.searches, key=lambda search: len(search.bests)).spent
    bests = [np.append(s.bests, np.full(len(longest) - len(s.bests), s.bests[-1])) for s in one.searches]
    return longest, np.stack(bests)

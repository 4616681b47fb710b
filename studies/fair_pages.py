"""The page of a8, in the order in which a reader asks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import fair_findings as findings
import fair_tables as tables
import numpy as np
from fair_conditions import HELD_OUT, uncertain
from fair_evidence import ASKED, CONFIDENCE, FAMILY
from fair_found import Found, found_of
from fair_given import BOTH, ENTRANTS, GIVEN, PROPOSAL, TOLD, Given
from fair_laws import PROPOSED
from fair_objective import LATE, both
from fair_published import order_kept, published_section

from workbench.core.layout import Array
from workbench.study.document import Figure, Paragraph, Reference, Section
from workbench.study.evidence import ablation_table, comparison_table, statistics_table
from workbench.study.factors import Space
from workbench.study.information import information_table
from workbench.study.pictures import budget_curves, pareto_fronts, standings_figure
from workbench.study.sample import Sample
from workbench.study.study import Results
from workbench.study.tuning import Tuned


def sections(results: Results) -> Sequence[Section]:
    """The page."""
    found = found_of(results)
    return (
        answer(results, found),
        terms(),
        *(given_the_same(found, given) for given in GIVEN),
        dependence(found),
        causes(found),
        tuning(results),
        published_section(results),
        trust(results),
    )


def headlines(results: Results) -> Sequence[str]:
    """Who wins, and what that depends on."""
    found = found_of(results)
    verdicts = (*(findings.winner(found, given) for given in GIVEN), findings.proposed(found), findings.diverged(found))
    return [str(one.statement) for one in verdicts]


def answer(results: Results, found: Found) -> Section:
    """The answers first."""
    return Section(
        "What was found",
        (
            _standings(found, BOTH),
            _information(),
            *(findings.winner(found, given) for given in reversed(GIVEN)),
            findings.proposed(found),
            *findings.tails(found),
            findings.success(found),
            findings.diverged(found),
            findings.parts_matter(found),
            order_kept(results),
        ),
    )


def _standings(found: Found, given: Given) -> Figure:
    """Laws by scenarios, given the same."""
    judgements = found.cost[given.key].judgements
    return standings_figure(
        f"standings_{given.key}",
        f"Cost of the laws in each held-out scenario, all given {given.words}.",
        {scenario: one.by for scenario, one in judgements.items()},
        ASKED.words,
    )


def _information() -> Section:
    """Who is given what."""
    scenario = HELD_OUT[0]
    loops = {one.name: one.loop(scenario, one.card).loop for one in (*ENTRANTS[BOTH.key], TOLD)}
    return information_table("information", "Who is given what, behind both observers.", loops)


def terms() -> Section:
    """What is the same for all."""
    scenario = HELD_OUT[0]
    loop = PROPOSAL.loop(scenario, PROPOSAL.card)
    equation = loop.ode()
    drawn = Space(uncertain(scenario, loop), equation.parameters, equation.states)
    return Section(
        "What is the same for all laws",
        (
            Paragraph(
                "A law runs on a computer that reads positions and velocities with noise, and commands a torque that "
                "is limited and held for a period. Its model has the paper's masses and lengths; the arm has others, "
                "and friction, which no model knows. AOSMC-RGS is repaired as in a1. In place of (24), which needs the "
                "unknown D, stands an observer of the momentum, which can be built; D_hat is added to the torque of "
                "every law behind it. The first estimate of (10) is the arm's start, as a first reading without noise "
                "gives it. PID alone has no model."
            ),
            Paragraph(
                "The computer moves the memory of a law and of an observer by explicit Euler, but for three that are "
                "stiff: (34) and observer (10) move by a Cayley step, which keeps P positive definite and the "
                "observer's decay at any period, and the filter of the velocity and the leak of the network move "
                "exactly."
            ),
            tables.scenarios(),
            drawn.table("drawn", "What is drawn anew in each of the runs of a held-out scenario, shown for the first."),
            tables.terms(),
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


def given_the_same(found: Found, given: Given) -> Section:
    """The laws behind one observer."""
    judgement = found.cost[given.key].judgements["paper"]
    table = statistics_table(
        f"paper_{given.key}", f"Cost in the scenario 'paper', all laws given {given.words}.", judgement
    )
    picture = () if given == BOTH else (_standings(found, given),)
    return Section(f"Given {given.words}", (*picture, table))


def dependence(found: Found) -> Section:
    """What turns a verdict round."""
    return Section(
        "What the verdicts depend on",
        (
            tables.dependence(found),
            tables.worth(found),
            tables.weights(found),
            *_by_scenario("late_error", "Late RMSE of each law behind both observers, by scenario.", found.late),
            *_by_scenario(
                "chattering", "Chattering (TV) of each law behind both observers, by scenario.", found.chattering
            ),
        ),
    )


def _by_scenario(name: str, caption: str, held: findings.Standings) -> tuple[tables.Table, ...]:
    """Laws by scenarios, in two tables, as one would be too wide for a page."""
    all_of = [(scenario, one.by[ASKED.words]) for scenario, one in held.judgements.items()]
    half = (len(all_of) + 1) // 2
    return tuple(
        comparison_table(f"{name}_{i}", f"{caption[:-1]}: {', '.join(s for s, _ in part)}.", [one for _, one in part])
        for i, part in enumerate((all_of[:half], all_of[half:]), start=1)
    )


def causes(found: Found) -> Section:
    """Why."""
    told = {scenario: one.by[ASKED.words] for scenario, one in found.told.judgements.items()}
    return Section(
        "What makes the difference",
        (
            Paragraph(
                "The last law is AOSMC-RGS with (24) as repaired: a filter of the true disturbance, which no "
                "instrument gives: an oracle. It does not know of friction or wrong masses, which an observer of the "
                "momentum takes for disturbance too."
            ),
            standings_figure(
                "told",
                "Cost of AOSMC-RGS behind an observer of the momentum, and with the oracle.",
                {scenario: {ASKED.words: one} for scenario, one in told.items()},
                ASKED.words,
            ),
            Paragraph(
                "AOSMC-RGS as tuned, less one part at a time, without tuning it again: a law is not better or worse "
                "for a part alone, but for the part at these numbers. Without its state observer it takes the noisy "
                "readings; without its boundary layer it switches once a period."
            ),
            *(
                ablation_table(
                    f"parts_{key}",
                    f"AOSMC-RGS less each of its parts, scenario '{key}'.",
                    [one.by[ASKED.words] for one in all_of],
                    PROPOSED,
                )
                for key, all_of in found.parts.items()
            ),
            Paragraph(
                "What tuning is worth, by the same draws. The card's layers of 0.01 rad/s are the paper's, for "
                "continuous time and exact readings."
            ),
            statistics_table(
                "card",
                "Cost with the numbers of a1's card, behind both observers, scenario 'paper'.",
                found.card,
            ),
        ),
    )


def tuning(results: Results) -> Section:
    """The searches."""
    tuned = {one.key: results.tuned(one.key) for entrants in ENTRANTS.values() for one in entrants}
    tuned[TOLD.key] = results.tuned(TOLD.key)
    shown = {one.name: tuned[one.key] for one in ENTRANTS[BOTH.key]}
    asked = next(iter(shown.values())).tuning
    note = (
        f"{len(asked.seeds)} searches a law of at most {asked.evaluations_per_number:.3g} evaluations a number; seeds "
        f"{', '.join(map(str, asked.seeds))}; step {1e3 * asked.trials[0].h:g} ms, at half of which the least cost "
        f"changes by at most {max(one.step_error for one in shown.values()):.1g}"
    )
    fronts = {name: one.front(_late, _chattering) for name, one in shown.items()}
    costs = {name: one.front(_late, _effort) for name, one in shown.items()}
    return Section(
        "Tuning with the same budget",
        (
            *(
                tables.searches(
                    f"searches_{given.key}", f"The searches of all laws given {given.words}.", tuned, entrants
                )
                for given in GIVEN
                for entrants in (ENTRANTS[given.key] + ((TOLD,) if given == BOTH else ()),)
            ),
            budget_curves(
                "budget",
                "The least cost so far, all laws behind both observers. Bands: between the searches.",
                {name: _curves(one) for name, one in shown.items()},
                note,
                "cost",
            ),
            pareto_fronts(
                "front_chattering",
                "Error against chattering in the training scenarios: points of the searches that none beats in both.",
                fronts,
                note,
                "late RMSE [rad]",
                "TV [N m/s]",
            ),
            pareto_fronts(
                "front_effort", "Error against effort, likewise.", costs, note, "late RMSE [rad]", "effort [N m]"
            ),
        ),
    )


def trust(results: Results) -> Section:
    """How far to trust it."""
    tuned = {one.key: results.tuned(one.key) for entrants in ENTRANTS.values() for one in entrants}
    return Section(
        "How far to trust this",
        (
            Paragraph(
                f"Intervals are those of chance in the draws. Those of a scenario hold at once with "
                f"{100 * CONFIDENCE:g} %, so that all of a statistic and of what is given do in all {len(HELD_OUT)} "
                f"scenarios with {100 * FAMILY:g} %; each statistic is a family of its own. The draws are the same "
                "in all scenarios, so that these are not as many independent trials. Intervals do not hold the chance "
                "of a search: so the laws that could win ran with the numbers of each search too. Nor do they "
                "hold the choice of objective, scenarios and ranges. Errors of the step are the largest of the runs "
                "that were run again: the arm is integrated by RK4 once a period, and in one run of sixteen twice. A "
                "run that was not may be farther off. The laws were tuned for masses 20 % above the model's and for no "
                "others; a tuning over draws would make all of them more robust, at many times the cost. "
                "What is not in these tables was not tuned: the nodes of the network of RBF-ASMC and the rules of "
                "Fuzzy-ASMC are those of a1."
            ),
            *(
                tables.numbers(
                    f"numbers_{given.key}", f"The numbers as tuned, given {given.words}.", tuned, ENTRANTS[given.key]
                )
                for given in GIVEN
            ),
        ),
    )


def _curves(one: Tuned) -> tuple[Array, Array]:
    """The evaluations, and the best so far of each search; one that ended early stays where it was."""
    longest = max(one.searches, key=lambda search: len(search.bests)).spent
    bests = [np.append(s.bests, np.full(len(longest) - len(s.bests), s.bests[-1])) for s in one.searches]
    return longest, np.stack(bests)


def _late(held: Mapping[str, Sample]) -> Array:
    return _mean(held, LATE)


def _chattering(held: Mapping[str, Sample]) -> Array:
    return _mean(held, "TV")


def _effort(held: Mapping[str, Sample]) -> Array:
    return _mean(held, "effort")


def _mean(held: Mapping[str, Sample], metric: str) -> Array:
    """A metric of both joints, the mean over the training scenarios."""
    return np.mean([both(sample, metric) for sample in held.values()], axis=0)

"""The page of a8, in the order in which a reader asks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from studies.a8_fair_comparison import findings as findings
from studies.a8_fair_comparison import tables as tables
from studies.a8_fair_comparison.conditions import HELD_OUT, uncertain
from studies.a8_fair_comparison.entrants import BOTH, ENTRANTS, GIVEN, PROPOSAL, TOLD, Given
from studies.a8_fair_comparison.evidence import ASKED, CONFIDENCE, FAMILY
from studies.a8_fair_comparison.laws import PROPOSED
from studies.a8_fair_comparison.published_numbers import order_kept, published_section
from studies.a8_fair_comparison.results import Found, found_of
from studies.a8_fair_comparison.searches import numbers, tuning
from workbench.study.document.document import Figure, Paragraph, Reference, Section, Table
from workbench.study.evidence import Comparison, ablation_table, comparison_table, statistics_table
from workbench.study.evidence.law_tables import information_table
from workbench.study.pictures import standings_figure
from workbench.study.study import Results
from workbench.study.uncertainty.factors import Space


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


def _information() -> Table:
    """Who is given what."""
    scenario = HELD_OUT[0]
    entrants = {one.name: one for one in ENTRANTS[BOTH.key]} | {f"{PROPOSED}, oracle": TOLD}
    others = (one for given in GIVEN if given != BOTH for one in ENTRANTS[given.key] if one.name in ("SMC", "PID"))
    entrants |= {f"{one.name}, {one.given.name}": one for one in others}
    loops = {name: one.loop(scenario, one.card).loop for name, one in entrants.items()}
    tuned = {name: len(one.tuned) for name, one in entrants.items()}
    return information_table(
        "information",
        "Who is given what: all laws behind both observers, and two of them behind the rest.",
        loops,
        tuned,
    )


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


def _by_scenario(name: str, caption: str, held: findings.Standings) -> tuple[Table, ...]:
    """Laws by scenarios, in two tables, as one would be too wide for a page."""
    all_of = [(scenario, one.by[ASKED.words]) for scenario, one in held.judgements.items()]
    half = (len(all_of) + 1) // 2
    return tuple(
        comparison_table(f"{name}_{i}", caption, [_headed(*pair) for pair in part])
        for i, part in enumerate((all_of[:half], all_of[half:]), start=1)
    )


def _headed(scenario: str, one: Comparison) -> Comparison:
    """With the scenario as the head of its column."""
    return replace(one, paired=replace(one.paired, metric=scenario))


def causes(found: Found) -> Section:
    """Why."""
    told = {scenario: one.by[ASKED.words] for scenario, one in found.told.judgements.items()}
    return Section(
        "What makes the difference",
        (
            Paragraph(
                "'AOSMC-RGS, oracle' is AOSMC-RGS with (24) as repaired: a filter of the true disturbance, which no "
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


def trust(results: Results) -> Section:
    """How far to trust it."""
    tuned = {one.key: results.tuned(one.key) for entrants in ENTRANTS.values() for one in entrants}
    return Section(
        "How far to trust this",
        (
            Paragraph(
                f"Intervals are those of chance in the draws. Those of a scenario hold at once with "
                f"{100 * CONFIDENCE:g} %, so that all of a statistic and of what is given do in all {len(HELD_OUT)} "
                f"scenarios with {100 * FAMILY:g} %, about: of a skewed sample of 160 draws 99.5 % held 98.7 % in a "
                f"trial; each statistic is a family of its own. The draws are the same "
                "in all scenarios, so that these are not as many independent trials. Intervals do not hold the chance "
                "of a search: so the laws of least training cost ran with the numbers of another search too. Nor do "
                "they "
                "hold the choice of objective, scenarios and ranges. Errors of the step are the largest of the runs "
                "that were run again: the arm is integrated by RK4 once a period, and in one run of sixteen twice. A "
                "run that was not may be farther off. The laws were tuned for masses 20 % below the model's in one "
                "scenario and 20 % above in the other; a tuning over draws would make all of them more robust, at many "
                "times the cost. Searches of one law may end far apart, as the tables of the searches show: where the "
                "worst is much above the best, the best may not be the end either. "
                "What is not in these tables was not tuned: the nodes of the network of RBF-ASMC and the rules of "
                "Fuzzy-ASMC are those of a1."
            ),
            *(
                numbers(
                    f"numbers_{given.key}", f"The numbers as tuned, given {given.words}.", tuned, ENTRANTS[given.key]
                )
                for given in GIVEN
            ),
        ),
    )

"""What the page of a8 says."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import fair_findings as findings
import fair_tables as tables
import numpy as np
from fair_conditions import HELD_OUT, uncertain
from fair_evidence import CONFIDENCE, FAMILY, ratio
from fair_found import Found, found_of
from fair_laws import ENTRANTS, MAIN, OBSERVED, PROPOSALS, PROPOSED, TOLD
from fair_objective import LATE, both
from fair_published import order_kept, published_section

from workbench.core.layout import Array
from workbench.study.document import Paragraph, Reference, Section, Table
from workbench.study.evidence import ablation_table, comparison_table, rank_table
from workbench.study.factors import Space
from workbench.study.pictures import budget_curves, pareto_fronts, rank_figure
from workbench.study.sample import Sample
from workbench.study.study import Results
from workbench.study.tuning import Tuned


def sections(results: Results) -> Sequence[Section]:
    """The page."""
    found = found_of(results)
    return (
        answer(results, found),
        terms(),
        tuning(results),
        held_out(found),
        causes(found),
        published_section(results),
        trust(results, found),
    )


def headlines(results: Results) -> Sequence[str]:
    """Who wins, by how much, and how surely."""
    found = found_of(results)
    ours, observed = (findings.standing(held, PROPOSED) for held in (found.cost, found.observed))
    return (
        f"Tuned with the same budget, by cost in {len(found.cost)} held-out scenarios: {PROPOSED} is {ours.sentence}.",
        f"Best in more scenarios than any other: {findings.champion(found.cost) or 'no law'}.{_lead(found)}",
        f"Runs of {PROPOSED} that diverged: {findings.diverged(found.cost, PROPOSED) or 'none'}.",
        f"Where {len(OBSERVED)} rivals have its observers too, {PROPOSED} is {observed.sentence}.",
    )


def _lead(found: Found) -> str:
    """How far the next law is behind the one that is best most often, where it is best."""
    law = findings.champion(found.cost)
    held = [one for one in found.cost.values() if law is not None and one.best == law]
    if not held:
        return ""
    seconds = (one.paired.laws[int(np.argsort(one.level.value)[1])] for one in held)
    more = [100 * (ratio(one.paired, second, str(law))[0] - 1) for one, second in zip(held, seconds, strict=True)]
    return f" Where it is best, the next law costs {min(more):.0f} to {max(more):.0f} % more, median of the draws."


def answer(results: Results, found: Found) -> Section:
    """The answers first."""
    return Section(
        "What was found",
        (
            findings.mostly(found.cost, PROPOSED),
            findings.everywhere(found.cost, PROPOSED, "cost"),
            findings.everywhere(found.late, PROPOSED, "late RMSE"),
            findings.everywhere(found.chattering, PROPOSED, "chattering (TV)"),
            findings.fails_nowhere(found.cost, PROPOSED),
            findings.by_its_law(found.observed, PROPOSED),
            findings.parts_matter({name: all_of[0] for name, all_of in found.parts.items()}, PROPOSED),
            findings.whichever_search(found.cost, found.other),
            order_kept(results),
            tables.margins(found.cost, found.chances),
        ),
    )


def terms() -> Section:
    """What is the same for all."""
    scenario = HELD_OUT[0]
    loop = PROPOSALS[0].loop(scenario, PROPOSALS[0].card)
    equation = loop.ode()
    drawn = Space(uncertain(scenario, loop), equation.parameters, equation.states)
    return Section(
        "What is the same for all laws",
        (
            Paragraph(
                "A law runs on a computer that reads positions and velocities with noise, and commands a torque that "
                "is limited and held for a period. Its model has the paper's masses and lengths; the arm has others, "
                "and friction, which no model knows. AOSMC-RGS is repaired as in a1. It brings its own observer, "
                "(10), which sees positions alone, and in place of (24), which needs the unknown D, an observer of "
                "the momentum, which can be built; its first estimate is the arm's start, as a first reading without "
                "noise gives it. The other laws take the readings as they are, with no filter of the noisy velocity. "
                "PID alone has no model. Beside the paper's six laws stand super-twisting and a law without any "
                "sliding surface: the model's torque along the reference, and PD."
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


def tuning(results: Results) -> Section:
    """The searches."""
    tuned = {one.key: results.tuned(one.key) for one in ENTRANTS}
    shown = {one.name: tuned[one.key] for one in MAIN}
    asked = next(iter(shown.values())).tuning
    lost = ", ".join(f"{one.failed:,} of {name}" for name, one in shown.items() if one.failed) or "none"
    note = (
        f"{len(asked.seeds)} searches of {asked.evaluations:,} evaluations a law, not admissible: {lost}; seeds "
        f"{', '.join(map(str, asked.seeds))}; step {1e3 * asked.trials[0].h:g} ms, at half of which the least cost "
        f"changes by at most {max(one.step_error for one in shown.values()):.1g}"
    )
    curves = {name: _curves(one) for name, one in shown.items()}
    fronts = {name: one.front(_late, _chattering) for name, one in shown.items()}
    costs = {name: one.front(_late, _effort) for name, one in shown.items()}
    return Section(
        "Tuning with the same budget",
        (
            tables.searches(tuned, ENTRANTS),
            budget_curves("budget", "The least cost so far. Bands: between the searches.", curves, note, "cost"),
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


def held_out(found: Found) -> Section:
    """Who is best where."""
    mean = np.mean([one.ranks.value for one in found.chances.values()], axis=0)
    runs = [one.paired for one in found.cost.values()]
    lost, total = (sum(counts) for counts in zip(*((one.failed.sum(), one.values.size) for one in runs), strict=True))
    note = (
        f"{len(runs[0])} draws in each of {len(runs)} scenarios, {lost} of {total:,} runs diverged and rank last; the "
        f"step changes the cost of a run by at most {max(np.nanmax(one.errors) for one in runs):.1g}, where that was "
        "looked at; "
        f"{runs[0].note.removesuffix('.')}"
    )
    shown = {"cost": found.cost, "late_error": found.late, "chattering": found.chattering}
    return Section(
        "Where nobody was tuned",
        (
            *(table for words, held in shown.items() for table in _by_scenario(words, held)),
            rank_figure(
                "ranks",
                "Probability of each rank by cost, in a scenario and a draw taken at random.",
                dict(zip(runs[0].laws, mean, strict=True)),
                note,
            ),
            rank_table("ranks_paper", "Probability of each rank by cost, scenario 'paper'.", found.chances["paper"]),
            tables.weights(found.weighted),
        ),
    )


def causes(found: Found) -> Section:
    """Why."""
    return Section(
        "What makes the difference",
        (
            Paragraph(
                "Two rivals get the observers of AOSMC-RGS, and the estimated disturbance is added to their torque as "
                "it is in (28); they are tuned with the same budget. What is left of a lead is due to the law."
            ),
            *_by_scenario("observed", found.observed),
            Paragraph(
                f"'{TOLD}' has the repaired (24): a filter of the true disturbance, which no instrument gives. It does "
                "not know of friction or wrong masses, which an observer of the momentum takes for disturbance too."
            ),
            *_by_scenario("told", found.told),
            Paragraph(
                "AOSMC-RGS as tuned, less one part at a time, without tuning it again: a law is not better or worse "
                "for a part alone, but for the part at these numbers. Without its state observer it takes the noisy "
                "readings; without its boundary layer it switches once a period."
            ),
            *(
                ablation_table(f"parts_{key}", f"AOSMC-RGS less each of its parts, scenario '{key}'.", all_of, PROPOSED)
                for key, all_of in found.parts.items()
            ),
            Paragraph(
                "What tuning is worth, by the same draws. The card's layers of 0.01 rad/s are the paper's, for "
                "continuous time and exact readings."
            ),
            comparison_table(
                "card", "Cost with the numbers of a1's card and as tuned, scenario 'paper'.", (found.card,)
            ),
        ),
    )


def trust(results: Results, found: Found) -> Section:
    """How far to trust it."""
    tuned = {one.key: results.tuned(one.key) for one in ENTRANTS}
    return Section(
        "How far to trust this",
        (
            Paragraph(
                f"Intervals are those of chance in the draws. Those of a scenario hold at once with "
                f"{100 * CONFIDENCE:g} %, so that all of a measure do in all {len(HELD_OUT)} scenarios with "
                f"{100 * FAMILY:g} %; each measure and each weighting is a family of its own. The draws are the same "
                "in all scenarios, so that these are not as many independent trials. Intervals do not hold the chance "
                "of a search: so all laws ran with the numbers of the other search too. Nor do they "
                "hold the choice of objective, scenarios and ranges. Errors of the step are the largest of the runs "
                "that were run again: the arm is integrated by RK4 once a period, and in one run of sixteen twice. A "
                "run that was not may be farther off. The laws were tuned for masses 20 % above the model's and for no "
                "others; a tuning over draws would make all of them more robust, at many times the cost. AOSMC-RGS has "
                "more numbers than any rival, and all got the same budget. What is not in the last table was not "
                "tuned: the nodes of the network of RBF-ASMC and the rules of Fuzzy-ASMC are those of a1."
            ),
            tables.numbers(tuned, ENTRANTS),
        ),
    )


def _curves(one: Tuned) -> tuple[Array, Array]:
    """The evaluations, and the best so far of each search."""
    pairs = tuple(one.curves.values())
    return pairs[0][0], np.stack([best for _, best in pairs])


def _late(held: Mapping[str, Sample]) -> Array:
    return _mean(held, LATE)


def _chattering(held: Mapping[str, Sample]) -> Array:
    return _mean(held, "TV")


def _effort(held: Mapping[str, Sample]) -> Array:
    return _mean(held, "effort")


def _mean(held: Mapping[str, Sample], metric: str) -> Array:
    """A metric of both joints, the mean over the training scenarios."""
    return np.mean([both(sample, metric) for sample in held.values()], axis=0)


def _by_scenario(words: str, held: findings.Held) -> tuple[Table, ...]:
    """Laws x scenarios, in two tables, as one would be too wide for a page."""
    all_of = list(held.values())
    half = (len(all_of) + 1) // 2
    captions = {
        "cost": "Cost of each law by scenario.",
        "late_error": "Late RMSE of each law by scenario.",
        "chattering": "Chattering (TV) of each law by scenario.",
        "observed": "Cost of AOSMC-RGS and of rivals behind its observers, by scenario.",
        "told": "Cost of AOSMC-RGS, and of the same law told the true disturbance, by scenario.",
    }
    return tuple(
        comparison_table(f"{words}_{i}", captions[words], part)
        for i, part in enumerate((all_of[:half], all_of[half:]), start=1)
    )

"""The paper's two tables three times: as published, with the numbers assumed in a1, and with those tuned here."""

from __future__ import annotations

from collections.abc import Mapping

from studies.a1_paper_tables.study import PRINTED, PROPOSED_STEP, STEPS
from studies.a8_fair_comparison.conditions import PERIOD, Scenario
from studies.a8_fair_comparison.entrants import BOTH, ENTRANTS
from studies.a8_fair_comparison.evidence import MARGIN
from studies.a8_fair_comparison.laws import PROPOSED
from studies.paper.card import CARD, LAWS, PUBLISHED
from studies.paper.laws import REFERENCES, proposed_repaired, rival
from workbench.study.contract import Run
from workbench.study.document.document import Cell, Column, Diverged, Measured, Paragraph, Section, Table, Verdict
from workbench.study.evidence.law_tables import ranking
from workbench.study.study import Case, Outcome, Results
from workbench.study.tuning import Tuned

WORDS = {"FS": "first scenario", "SS": "second scenario"}
EVERY = 0.01  # s between kept states


def cases(tuned: Mapping[str, Tuned]) -> tuple[Case, ...]:
    """The six laws in both scenarios: as a1 assumes them, and as tuned, on the computer with its readings."""
    steps = {PROPOSED: PROPOSED_STEP} | STEPS
    entrants = {one.name: one for one in ENTRANTS[BOTH.key]}
    made = []
    for key, words in WORDS.items():
        horizon = CARD[f"{key}: horizon"]
        for law in LAWS:
            assumed = proposed_repaired(key) if law == PROPOSED else rival(key, law)
            made.append(Case(f"{key} assumed", law, Run(assumed, (PRINTED,), horizon, EVERY, steps[law] / 2)))
        scenario = Scenario(key.lower(), words, REFERENCES[key], CARD[f"{key}: q(0)"])
        for law in LAWS:
            loop = entrants[law].loop(scenario, tuned[entrants[law].key].best)
            made.append(Case(f"{key} tuned", law, Run(loop, (PRINTED,), horizon, EVERY, PERIOD / 2)))
    return tuple(made)


def published_section(results: Results) -> Section:
    """A table a joint and scenario."""
    return Section(
        "The paper's tables: as published, as assumed, as tuned",
        (
            Paragraph(
                "RMSE by (43), over the horizons that a1 finds. As assumed: the numbers of a1's card, in continuous "
                "time on exact readings, AOSMC-RGS repaired and told the true disturbance. As tuned: the numbers found "
                "here, on the computer, all laws behind observer (10) and an observer of the disturbance. No law was "
                "tuned for RMSE alone, nor for so long a run. Errors in brackets are those of the step."
            ),
            *(published_table(results, key, joint) for key in WORDS for joint in (1, 2)),
        ),
    )


def order_of_six(results: Results) -> Verdict:
    """The printed order of the six laws that survives tuning."""
    rankings = [
        ranking(PUBLISHED[key, joint], {law: results[f"{key} tuned", law] for law in LAWS}, MARGIN)
        for key in WORDS
        for joint in (1, 2)
    ]
    same, turned, close = (sum(len(getattr(one, kind)) for one in rankings) for kind in ("holds", "fails", "undecided"))
    each = ", ".join(
        f"{one.published.where}: {len(one.holds)}, {len(one.fails)} and {len(one.undecided)}" for one in rankings
    )
    return Verdict(
        "found",
        f"Given the same and tuned alike, of the {same + turned + close} printed pairs of the paper's six laws {same} "
        f"are in the printed order, {turned} are turned round, and {close} are too close to call.",
        f"In order, turned and close by RMSE (43), a difference counting beyond {100 * MARGIN:g} %: {each}.",
        estimand="One run of each law in each scenario, without a draw and with one noise.",
        given="Behind observer (10) and an observer of the disturbance; no law was tuned for RMSE alone.",
        reversal="The printed order may hold for the numbers of the authors, which the paper does not state.",
    )


def published_table(results: Results, key: str, joint: int) -> Table:
    """The RMSE of a joint in a scenario three times."""
    printed = PUBLISHED[key, joint]

    def cell(outcome: Outcome) -> Cell:
        lost = outcome.diverged_at
        return Measured(*outcome.score(PRINTED.name, joint - 1)) if lost is None else Diverged(lost)

    rows = tuple(
        (
            law,
            f"{printed.values[law]:.{printed.digits}f}",
            cell(results[f"{key} assumed", law]),
            cell(results[f"{key} tuned", law]),
        )
        for law in LAWS
    )
    columns = (Column("law"), *(Column(f"as {how}", "rad", "right") for how in ("published", "assumed", "tuned")))
    return Table(f"published_{key.lower()}_q{joint}", f"RMSE of joint {joint}, {WORDS[key]}.", columns, rows)

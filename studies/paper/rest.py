"""AOSMC-RGS as it holds the arm still: a case that a study keeps apart, and the section of its linear pictures."""

from __future__ import annotations

import workbench as wb
from studies.paper.card import CARD, PROPOSED_LAW, SCENARIOS
from studies.paper.linearization import still

REST = "at rest"  # the scenario of this case: no table, count or ranking of a study has it
POSE = tuple(map(float, CARD["FS: q(0)"]))  # both links stand upright or hang, so that no mass moves the rest
UNTIL, STATE_INTERVAL = 0.1, 0.01  # s: nothing moves
WHY = (
    "The runs above track a moving reference, and a loop gain exists only about an equilibrium. In these pictures "
    f"{PROPOSED_LAW} therefore holds the arm at rest at its initial position in the paper's first scenario. The "
    "reference stays there, and there is no disturbance."
)
ELSEWHERE = "Report d0 has the loop gains of six laws at several poses."


def rest_case(h: float, remark: str = "") -> wb.Case:
    """The repaired law at the start of the first scenario, at rest, with steps of h in s."""
    return wb.Case(
        REST, PROPOSED_LAW, wb.Run(still(PROPOSED_LAW, POSE), (wb.rmse(),), UNTIL, STATE_INTERVAL, h), remark=remark
    )


def rest_section(outcome: wb.study.Outcome, pushed_outcome: wb.study.Outcome, law: str, knobs: str) -> wb.Section:
    """The linear pictures of the law at rest, and how far its gain K grows in a `pushed_outcome` run of it.

    A sentence says which numbers the `law` has, and another which `knobs` of the page move the pictures.
    """
    text = f"{WHY} {law} {growth(pushed_outcome)} {knobs} {ELSEWHERE}"
    pictures = wb.loop_gain_pictures(outcome, "rest", width=0.75)
    return wb.Section(f"The loop gain of {PROPOSED_LAW} at rest", (wb.Paragraph(text), *pictures))


def growth(pushed_outcome: wb.study.Outcome) -> str:
    """The diagonal of K at the start and at the end of a run."""
    K = pushed_outcome.measurement.trajectories["controller.K"][0]
    first, last = (" and ".join(f"{entry:.3g}" for entry in k.diagonal()) for k in (K[0], K[-1]))
    named = pushed_outcome.case.scenario
    where = f"the {SCENARIOS[named]}" if named in SCENARIOS else f"scenario '{named}'"
    return (
        f"The gain K is constant at K(0), with {first} N m on its diagonal. At the end of the run in {where} the "
        f"diagonal has {last} N m."
    )

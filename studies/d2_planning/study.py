"""Planned motions, and predictive laws beside linear ones and those of the paper: their worth, and their cost.

Takes about five minutes of processor time, on two cores at once.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import workbench as wb
from studies.d2_planning import (
    batches,
    conditions_section,
    findings,
    followed_section,
    followers,
    machine_section,
    settings_section,
)
from studies.d2_planning.certificates import PIECES, prove_conflict, published_piece
from studies.d2_planning.choices import choose, items
from studies.d2_planning.evidence import Evidence, gather
from studies.d2_planning.laws_section import cost_section, limits_section
from studies.d2_planning.motions import MOTIONS, plan_motion
from studies.d2_planning.posed_problems import INFEASIBLE, POSED
from studies.d2_planning.settings import compare_settings


def sweeps(answers: Mapping[str, Any]) -> tuple[wb.Sweep, ...]:
    """All runs."""
    return (*followers.sweeps(answers), *batches.sweeps(answers))


def sections(results: wb.Results) -> wb.Page:
    """The whole page."""
    evidence, arrivals, costs = gather(results), followed_section.gather(results), machine_section.gather(results)
    return wb.Page(
        answer(evidence, arrivals),
        (
            followed_section.finding(arrivals),
            findings.predictive(evidence),
            findings.limits(evidence),
            findings.arm_laws(evidence),
            machine_section.finding(costs),
        ),
        (
            followed_section.section(arrivals),
            cost_section(evidence),
            limits_section(evidence),
            machine_section.section(costs),
            settings_section.section(results),
            conditions_section.section(evidence),
        ),
    )


def answer(evidence: Evidence, arrivals: followed_section.Arrivals) -> str:
    """The answer of the page in at most forty words."""
    least = min(arrivals.share(key, followers.ALONG).value for key in MOTIONS)
    usual, tight = (findings.orders(evidence, at, "lqr") for at in (findings.usual(), findings.tightest()))
    share = "All" if least == 1 else f"At least {100 * least:.0f} % of"
    wins, losses = ([one.count(side) for one in (usual, tight)] for side in ("below", "above"))
    told = [f" and loses on {count}" if count else "" for count in losses]
    return (
        f"{share} loops arrive with gains along the plan and numbers within {100 * followers.USUAL:g} %. At usual "
        f"limits MPC beats clipped LQR on {wins[0]} of {len(usual)} plants{told[0]}; at the tightest it wins on "
        f"{wins[1]}{told[1]}."
    )


study = wb.Study(
    name="d2_planning",
    title="Planned motions and predictive laws: what they are worth, and what they cost",
    question=(
        "Do swing-ups and a motion in minimum time arrive when a computer with noise and delay follows their plans? Is "
        "MPC better than clipped LQR, LQI with anti-windup, a reference governor and the paper's laws with equal "
        "information, and at which limits? What does it cost on a Cortex-M7?"
    ),
    method=(
        "Swing-ups of a cart-pole and a Furuta pendulum and a motion of the paper's arm in minimum time are planned "
        "for the model. Loops whose numbers, start and noise are drawn follow them in four ways, and the hardest by "
        "nonlinear MPC, too. Then the arm, a quadruple "
        "tank and a planar quadrotor are brought to drawn targets by linear, predictive and the paper's laws, with the "
        "same readings, observer, period and limits. Each law is tuned on the same training runs with as many "
        "candidates for its own numbers, and judged on other draws at six levels of the limits. Where runs are lost "
        "their share decides, else the mean cost. All laws are exported to C, and their instructions are counted on an "
        "emulated Cortex-M7."
    ),
    works=(
        wb.Work("plans", plan_motion, tuple(MOTIONS), seconds=5.0),
        wb.Work("choices", choose, items(), seconds=12.0),
        wb.Work("settings", compare_settings, tuple(POSED), seconds=6.0),
        wb.Work("conflicts", prove_conflict, tuple(INFEASIBLE), seconds=2.0),
        wb.Work("published", published_piece, tuple(PIECES), seconds=0.1),
    ),
    sweeps=sweeps,
    sections=sections,
    seed=batches.SEED,
)

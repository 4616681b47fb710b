"""Planned motions and predictive laws beside the paper's laws."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import workbench as wb
from studies.d2_planning import batches, conditions_section, findings, followed_section, followers, machine_section
from studies.d2_planning.choices import choose, items
from studies.d2_planning.evidence import Evidence, gather
from studies.d2_planning.laws_section import cost_section, limits_section
from studies.d2_planning.machine import cost_on_machine, costs_items
from studies.d2_planning.motions import MOTIONS, planned


def sweeps(answers: Mapping[str, Any]) -> tuple[wb.Sweep, ...]:
    """All runs."""
    return (*followers.sweeps(answers), *batches.sweeps(answers))


def sections(results: wb.Results) -> wb.Page:
    """The whole page."""
    evidence, followed, costs = gather(results), followed_section.gather(results), machine_section.gather(results)
    return wb.Page(
        answer(evidence, followed),
        (
            followed_section.finding(followed),
            findings.predictive(evidence),
            findings.limits(evidence),
            findings.arm_laws(evidence),
            machine_section.finding(costs),
        ),
        (
            followed_section.section(followed),
            cost_section(evidence),
            limits_section(evidence),
            machine_section.section(costs),
            conditions_section.section(evidence),
        ),
    )


def answer(evidence: Evidence, followed: followed_section.Followed) -> str:
    """The answer of the page in at most forty words."""
    return "x"


study = wb.Study(
    name="d2_planning",
    title="Planned motions and predictive laws",
    question="?",
    method="m",
    works=(
        wb.Work("plans", planned, tuple(MOTIONS), seconds=5.0),
        wb.Work("choices", choose, items(), seconds=2.0),
        wb.Work("costs", cost_on_machine, costs_items(), seconds=3.0),
    ),
    sweeps=sweeps,
    sections=sections,
    seed=batches.SEED,
)

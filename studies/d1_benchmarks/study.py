"""Benchmarks of designs: PID laws for a batch of processes, robust problems, and linear laws for the paper's arm."""

from __future__ import annotations

import workbench as wb
from studies.d1_benchmarks import arm_section, batch_section, robust_section
from studies.d1_benchmarks.arm_designs import TUNED
from studies.d1_benchmarks.arm_runs import SEED, sweeps
from studies.d1_benchmarks.batch import batch
from studies.d1_benchmarks.batch_designs import designs
from studies.d1_benchmarks.robust_problems import COMPLEIB, PUBLISHED, figure_of, static_design
from studies.paper.costs import OTHERS, PRIMARY


def sections(results: wb.Results) -> wb.Page:
    """The whole page."""
    evidence = arm_section.ArmEvidence.of(results)
    return wb.Page(
        answer="An answer.",
        findings=(batch_section.finding(results), robust_section.finding(results), arm_section.finding(evidence)),
        sections=(
            batch_section.section(results),
            robust_section.section(results),
            arm_section.section(results, evidence),
        ),
    )


study = wb.Study(
    name="d1_benchmarks",
    title="Designs from specifications: a batch of processes, robust benchmarks, and the paper's arm",
    question="Q?",
    method="M.",
    sweeps=sweeps,
    least_samples=wb.evidence.least_draws((PRIMARY, *OTHERS)),
    works=(
        wb.Work("batch", designs, batch(), seconds=1.0),
        wb.Work("robust", figure_of, tuple(one.key for one in PUBLISHED), seconds=3.0),
        wb.Work("static", static_design, tuple(COMPLEIB), seconds=30.0),
        wb.Work("arm_designs", arm_section.arm_designs, tuple(TUNED), seconds=8.0),
    ),
    sections=sections,
    seed=SEED,
)

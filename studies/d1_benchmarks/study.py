"""Benchmarks of designs: PID laws for a batch of processes, robust problems, and linear laws for the paper's arm.

Runs in about eight minutes on two cores.
"""

from __future__ import annotations

import numpy as np

import workbench as wb
from studies.d1_benchmarks import arm_section, batch_section, robust_section
from studies.d1_benchmarks.arm_designs import TUNED
from studies.d1_benchmarks.arm_runs import SEED, sweeps
from studies.d1_benchmarks.batch import batch
from studies.d1_benchmarks.batch_designs import LIMIT, designs
from studies.d1_benchmarks.robust_problems import COMPLEIB, PUBLISHED, figure_of, static_design
from studies.paper.costs import OTHERS, PRIMARY


def sections(results: wb.Results) -> wb.Page:
    """The whole page."""
    evidence = arm_section.ArmEvidence.of(results)
    return wb.Page(
        answer=answer(results, evidence),
        findings=(batch_section.finding(results), robust_section.finding(results), arm_section.finding(evidence)),
        sections=(
            batch_section.section(results),
            robust_section.section(results),
            arm_section.section(results, evidence),
        ),
    )


def answer(results: wb.Results, evidence: arm_section.ArmEvidence) -> str:
    """The answer of the page in at most forty words."""
    rows = batch_section.rows_of(results)
    gain = float(np.median(batch_section.quotient(rows, "PID", "PI", "ki")))
    met, count = robust_section.count_read(results)
    less, more, _ = arm_section.counts(evidence.cost, arm_section.EQUAL)
    return (
        f"A derivative multiplies the integral gain by {gain:.2g} (median of {len(rows)} processes). {met} of {count} "
        f"figures read in print are reached. Beside linear laws of equal crossovers and information, six laws cost "
        f"less in {less} cases, more in {more}."
    )


study = wb.Study(
    name="d1_benchmarks",
    title="Designs from specifications: a batch of processes, robust benchmarks, and the paper's arm",
    question=(
        "How good are the designs of the workbench beside the best that is published? What does a derivative give a PI "
        "law, how far are tuning rules from an optimum, and what are the six laws of the paper worth beside linear "
        "laws with the same crossovers?"
    ),
    method=(
        f"The batch: each process gets the PI and the PID law with the largest integral gain for which the peaks of S "
        f"and T stay at or below {LIMIT:g}, and PI laws by two rules. Each peak is certified by margins that share no "
        "code with the design. The published problems: norms, structured singular values and controllers of given "
        "structure, computed between bounds, stand beside the figures in print. The arm: two linear laws are designed "
        "for the crossovers of each of the six laws of the paper. All run in the scenarios, with the draws and in the "
        "computer of report a8, with the same noisy readings."
    ),
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

"""Linear analysis of the arm and of each law: poles, margins, and what they leave out.

Runs in about 15 seconds on two cores.
"""

from collections.abc import Sequence

from studies.a1_paper_tables.study import comparison
from studies.a5_linear_analysis import findings, pages
from studies.a5_linear_analysis.findings import SEED, alpha, delay, thinnest
from studies.paper.linearization import LEVEL, PROPOSED, SEVEN, at_rest, late_gain
from workbench.study.document.document import Section
from workbench.study.study import Results, Study


def sections(results: Results) -> Sequence[Section]:
    """The whole page."""
    verdicts = (
        findings.rests(),
        findings.delays(results),
        findings.observer(),
        findings.slow(),
        findings.twisting(),
        findings.adaptation(),
        findings.frozen(results),
    )
    first = Section("What was found", (pages.along_path(results), pages.responses(), *verdicts))
    return (first, pages.arm_section(), pages.at_rest_section(results))


def headlines(results: Results) -> Sequence[str]:
    """The findings in a line each."""
    late = at_rest("ASMC", LEVEL, late_gain(results["FS", "ASMC"]))
    margins = ", ".join(f"{law} {alpha(at_rest(law)):.2f}" for law in SEVEN)
    return (
        f"Disk margins at the torque, at rest: {margins}.",
        f"Delay at the torque: SMC stands {delay(at_rest('SMC')):.2f} ms, ASMC late {delay(late):.2g} ms, AOSMC-RGS "
        f"{delay(at_rest(PROPOSED)):.0f} ms.",
        f"The thinnest disk margin of AOSMC-RGS is {alpha(at_rest(PROPOSED, thinnest())):.3f}, {thinnest()}.",
    )


study = Study(
    name="a5_linear_analysis",
    title="Linear analysis of the arm and of seven laws",
    question=(
        "How do the arm and the seven loops behave near rest and along the paper's path, how far are they from "
        "instability at the torque, and where does linear analysis say nothing?"
    ),
    method=(
        "Exact Jacobians of the equations; rest points by Newton's method, with intervals to prove that there are "
        "no others. Each loop is cut at the torque. The disk margin is bounded from below by the H-infinity norm of "
        "the scaled (S - T) / 2, found by a Hamiltonian matrix and not on a grid. Along the first scenario of a1 "
        "the equations are linearised at each kept state of its run."
    ),
    cases=comparison("FS"),
    sections=sections,
    headlines=headlines,
    seed=SEED,
)

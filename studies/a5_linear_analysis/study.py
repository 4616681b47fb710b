"""Linear analysis of the arm and of each law: poles, margins, and what they leave out.

Runs in about 15 seconds on two cores.
"""

import workbench as wb
from studies.a5_linear_analysis import pages
from studies.a5_linear_analysis.findings import answer, findings, rest_points
from studies.a5_linear_analysis.pages import SEED
from studies.paper.citation import introduction
from studies.paper.comparison import comparison


def sections(results: wb.Results) -> wb.Page:
    """The whole page."""
    return wb.Page(
        answer=answer(results),
        findings=findings(results),
        sections=(
            wb.Section("Along the path", (pages.along_path(results), pages.path_table(results))),
            wb.Section("Frequency responses at rest", (pages.responses_figure(results),)),
            wb.Section("The arm by itself", (rest_points(results), *pages.arm_blocks(results))),
            pages.at_rest_section(results),
        ),
    )


study = wb.Study(
    name="a5_linear_analysis",
    title="Linear analysis of the arm and of seven laws",
    question=(
        "How do the arm and the seven loops behave near equilibrium and along the paper's path? How far are they from "
        "instability at the torque? Where does linear analysis not apply?"
    ),
    method=(
        f"{introduction(10, 24)} The equations are linearised by exact Jacobians. Equilibria come from Newton's "
        "method, and intervals prove that there are no others. Each loop is cut at the torque. The disk margin is "
        "bounded from below by the H-infinity norm of the scaled (S - T) / 2, which a Hamiltonian matrix gives without "
        "a grid. Along the first scenario of report a1 the equations are linearised at each kept state of the run."
    ),
    cases=comparison("FS"),
    works=pages.works,
    sections=sections,
    seed=SEED,
)

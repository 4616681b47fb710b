"""What does linear analysis say of the arm and of each law: poles, margins, and what they leave out?

Runs in about 15 seconds on two cores.
"""

from studies.a1_paper_tables.study import comparison
from studies.a5_linear_analysis.arm import SEED
from studies.a5_linear_analysis.pages import headlines, sections
from workbench.study.study import Study

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

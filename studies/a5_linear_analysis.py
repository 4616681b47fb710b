"""What does linear analysis say of the arm and of each law: poles, margins, and what they leave out?

Question  How do the arm and the seven loops behave near rest and along the paper's path, how far are they from
          instability at the torque, and where does linear analysis say nothing?
Method    Exact Jacobians of the equations; rest points by Newton's method, with intervals to prove that there are no
          others. Each loop is cut at the torque. The disk margin is bounded from below by the H-infinity norm of the
          scaled (S - T) / 2, found by a Hamiltonian matrix and not on a grid. Along the first scenario of a1 the
          equations are linearised at each kept state of its run.
Runs in   about 15 seconds on two cores.
"""

from a1_paper_tables import comparison
from linear_arm import SEED
from linear_pages import headlines, sections

from workbench.study.study import Study

study = Study(
    name="a5_linear_analysis",
    title="Linear analysis of the arm and of seven laws",
    question=__doc__.split("Question  ")[1].split("Method")[0],
    method=__doc__.split("Method    ")[1].split("Runs in")[0],
    cases=comparison("FS"),
    sections=sections,
    headlines=headlines,
    seed=SEED,
)

"""Eight plants in one loop: LQG and PID, in continuous time, in a computer, and over the plants' parameters.

Runs in about one and a half minutes on two cores.
"""

import workbench as wb
from studies.b3_any_plant.frequency import ITEMS as LOOPS
from studies.b3_any_plant.frequency import frequency_answer
from studies.b3_any_plant.loops import ITEMS, PUSHED_CASES, SEED, cases, margins, recovery, sweeps
from studies.b3_any_plant.pages import sections
from studies.b3_any_plant.tanks import SIDES, TANKS, levels, step_settling

study = wb.Study(
    name="b3_any_plant",
    title="Any plant, one loop: eight plants under LQG and PID",
    question=(
        "Does the same workflow lead from the equations of any plant to a loop that runs in a computer? And how do LQG "
        "and PID compare on eight plants that are no arms, given the same readings?"
    ),
    method=(
        "Each nonlinear plant is linearised at its operating point by exact Jacobians. LQG is a certified regulator "
        "behind a Kalman filter. PID reads the same outputs; where one PID is not enough it is a cascade or a mixture. "
        "Each loop is cut at the inputs of the plant for its margins. It runs from a start off the operating point: in "
        "continuous time, and in a computer with noise, limits and a delay of one period. Sobol indices say which "
        "parameter of the plant decides the error when law and filter keep the numbers that they believe."
    ),
    cases=cases(),
    sweeps=sweeps(),
    works=(
        wb.Work("margins", margins, ITEMS, seconds=0.3),
        wb.Work("recovery", recovery, PUSHED_CASES, seconds=0.3),
        wb.Work("frequency", frequency_answer, LOOPS, seconds=2.0),
        wb.Work("tanks", levels, TANKS, seconds=0.5),
        wb.Work("tank_steps", step_settling, SIDES, seconds=0.5),
    ),
    sections=sections,
    seed=SEED,
)

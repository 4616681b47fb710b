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
        "Does the same workflow lead from the equations of any plant to a loop with a digital controller? And how do "
        "LQG and PID compare on eight plants that are not robot arms, with the same readings?"
    ),
    method=(
        "Each nonlinear plant is linearised at its operating point by exact Jacobians. The four tanks have two "
        "operating points, P\N{MINUS SIGN} and P+, so that there are 9 settings. LQG is an LQR with a Kalman filter; "
        "the solutions of both Riccati equations are checked numerically. PID reads the same outputs; where one PID "
        "controller is not enough, it is a cascade or a mixture of several. For its margins, each loop is cut at the "
        "inputs of the plant. Each loop runs from a start "
        "off the operating point: in continuous time, and with a digital controller. The digital controller has noisy "
        "readings, limits and a delay of one period; the names of its runs end with 'in a computer'. Sobol indices "
        "show which parameter of the plant causes the scatter of the error if law and filter keep the "
        "nominal numbers."
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

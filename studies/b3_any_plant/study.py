"""Eight plants in one loop: LQG and PID, in continuous time, in a computer, and over the plants' parameters.

Runs in about half a minute on two cores.
"""

from studies.b3_any_plant.loops import ITEMS, SEED, cases, margins, sweeps
from studies.b3_any_plant.pages import headlines, sections
from workbench.study import Study, Work

study = Study(
    name="b3_any_plant",
    title="Any plant, one loop: eight plants under LQG and PID",
    question=(
        "Does one and the same way lead from the equations of any plant to a loop that runs in a computer, and what "
        "do LQG and PID, given the same readings, stand and reach on eight plants that are no arms?"
    ),
    method=(
        "Each nonlinear plant is linearised at its operating point by exact Jacobians. LQG is a certified regulator "
        "behind a Kalman filter; PID reads the same outputs, and is a cascade or a mixture where one does not do. "
        "Each loop is cut at the inputs of the plant for its margins, and runs from off the operating point: in "
        "continuous time, and in a computer with noise, limits and a delay of one period. Sobol indices say which "
        "parameter of the plant decides the error, where law and filter keep what they believe."
    ),
    cases=cases(),
    sweeps=sweeps(),
    works=(Work("margins", margins, ITEMS, seconds=0.3),),
    sections=sections,
    headlines=headlines,
    seed=SEED,
)

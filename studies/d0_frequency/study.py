"""The paper's loops over frequency: what their linear parts say, and where they mislead.

Runs in about two minutes on two cores.
"""

from __future__ import annotations

from studies.d0_frequency.draws import ITEMS, drawn_loops
from studies.d0_frequency.limit_cycles import PERIODS, limit_cycle
from studies.d0_frequency.loops import DRAWN, EVERY, RUNS
from studies.d0_frequency.pages import LIVE, cases, sections
from studies.d0_frequency.period_limits import period_limit
from studies.d0_frequency.rest_answers import curves, rest_answers
from studies.d0_frequency.step_sizes import ITEMS as SIZES
from studies.d0_frequency.step_sizes import settling
from workbench.study import Study, Work

study = Study(
    name="d0_frequency",
    title="The paper's loops over frequency: what linear answers say, and where they mislead",
    question=(
        "How do the loops of six laws look over frequency, in continuous time and in a computer? And which of their "
        "linear answers hold for the nonlinear loop: the longest period, the settling time, the limit cycle?"
    ),
    method=(
        "Each loop rests at poses that its law holds, and is made linear there by exact Jacobians, adapting gains held "
        "at K(0); in a computer by those of the map of the period. It is cut at the torques. The same loops then run "
        "without being made linear: in computers, about the period at which the linear map becomes unstable, from a "
        "start within the layer and one outside; and in continuous time from starts of nine sizes."
    ),
    cases=cases(),
    works=(
        Work("curves", curves, DRAWN, seconds=3.0),
        Work("rests", rest_answers, EVERY, seconds=1.0),
        Work("limit_cycles", limit_cycle, PERIODS, seconds=0.5),
        Work("period_limits", period_limit, RUNS, seconds=5.0),
        Work("step_sizes", settling, SIZES, seconds=2.0),
        Work("draws", drawn_loops, ITEMS, seconds=4.0),
    ),
    sections=sections,
    live=LIVE,
)

"""The paper's loops over frequency: what their linear parts say, and where they mislead.

Runs in about two and a half minutes on two cores.
"""

from __future__ import annotations

import workbench as wb
from studies.d0_frequency.draws import ITEMS, drawn_loops
from studies.d0_frequency.limit_cycles import PERIODS, limit_cycle
from studies.d0_frequency.loops import DRAWN_LAWS, EVERY, RUNS
from studies.d0_frequency.pages import LIVE, cases, sections
from studies.d0_frequency.period_limits import period_limit
from studies.d0_frequency.rest_answers import curves, rest_answers
from studies.d0_frequency.step_sizes import ITEMS as SIZES
from studies.d0_frequency.step_sizes import settling
from studies.paper.citation import introduction

study = wb.Study(
    name="d0_frequency",
    title="Six laws for a robot arm over frequency: where linear answers hold, and where they mislead",
    question=(
        "How do the loops of six control laws for an arm of two links behave over frequency, in continuous time and in "
        "a computer? Which linear answers hold for the nonlinear loop: the longest sampling period, the settling time, "
        "the limit cycle?"
    ),
    method=(
        f"{introduction(10, 24)} Each law holds the arm at rest at several poses. There the loop is linearised by "
        "exact Jacobians, in a computer by those of one whole period, and cut at the torques. Adaptive gains are "
        "constant at their first value, K(0). Then the nonlinear loops run. In computers they run with periods near "
        "the one at which the linear loop becomes unstable, from starts 10 µrad and 0.3 rad from equilibrium. In "
        "continuous time they run from nine distances. FS and SS are the first and the second scenario of the paper."
    ),
    cases=cases(),
    works=(
        wb.Work("curves", curves, DRAWN_LAWS, seconds=3.0),
        wb.Work("rests", rest_answers, EVERY, seconds=1.0),
        wb.Work("limit_cycles", limit_cycle, PERIODS, seconds=0.5),
        wb.Work("period_limits", period_limit, RUNS, seconds=5.0),
        wb.Work("step_sizes", settling, SIZES, seconds=2.0),
        wb.Work("draws", drawn_loops, ITEMS, seconds=4.0),
    ),
    sections=sections,
    live=LIVE,
)

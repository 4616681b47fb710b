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

study = wb.Study(
    name="d0_frequency",
    title="Six laws for a robot arm over frequency: where linear answers hold, and where they mislead",
    question=(
        "How do the loops of six control laws for an arm of two links look over frequency, in continuous time and in a "
        "computer? And which of their linear answers hold for the nonlinear loop: the longest sampling period, the "
        "settling time, the limit cycle?"
    ),
    method=(
        "Each law holds the arm at rest at several poses. There its loop is made linear by exact Jacobians, in a "
        "computer by those of one whole period, and cut at the torques. Gains that adapt are held at their first "
        "value, K(0). Then the nonlinear loops run: in computers, with periods about the one at which the linear loop "
        "becomes unstable, from a start 10 µrad off rest and from one 0.3 rad off; and in continuous time from nine "
        "distances. FS and SS are the first and the second scenario of the paper."
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

"""From the report to the machine: six laws replayed bit by bit, and what a computer may do to each of them.

Runs in about five minutes on two idle cores.
"""

import workbench as wb
from studies.b4_handover.loops import SEED
from studies.b4_handover.machines import replay_works
from studies.b4_handover.margins import scan_works, sweeps
from studies.b4_handover.missed_periods import shared_sweeps
from studies.b4_handover.operations import operations_work
from studies.b4_handover.pages import sections

study = wb.Study(
    name="b4_handover",
    title="From the report to the machine: six laws handed over",
    question=(
        "Does a law that was designed, checked and compared here run with the same bits on other machines? Does it fit "
        "its period there, from a start on the reference and from the paper's start? What do single precision and an "
        "imperfect clock cost?"
    ),
    method=(
        "Each law is taken out of its loop with its observer, limits and delay. All targets that are installed here "
        "replay it on the same inputs, and the bits are compared with the portable arithmetic. The loops then run with "
        "coarser readings, jitter, missed periods, single precision, longer delays and longer periods, from two starts."
    ),
    sweeps=(*sweeps(), *shared_sweeps()),
    works=(*replay_works(), *scan_works(), operations_work()),
    sections=sections,
    seed=SEED,
    live=None,
)

"""From the report to the machine: six laws replayed bit by bit, and the effects of a computer on each of them.

Runs in about ten minutes on two idle cores; with the sources of TinyMPC, in fifteen.
"""

import workbench as wb
from studies.b4_handover.filter_law import filter_work
from studies.b4_handover.loops import SEED
from studies.b4_handover.machines import replay_works
from studies.b4_handover.margins import scan_works, sweeps
from studies.b4_handover.missed_periods import shared_sweeps
from studies.b4_handover.operations import operations_work
from studies.b4_handover.pages import sections
from studies.b4_handover.predictive_laws import predictive_work
from studies.paper.citation import introduction

study = wb.Study(
    name="b4_handover",
    title="From the report to the machine: six laws handed over",
    question=(
        "Does a law that was designed, checked and compared here compute the same bits on other machines? Does it fit "
        "into its period there, from a start on the reference and from the paper's start? By how much do single "
        "precision and an imperfect clock raise the error?"
    ),
    method=(
        f"{introduction(rivals=False)} Each law is taken out of its loop together with its observer, limits and "
        "delay. All targets that are installed here replay the law on the same inputs, and the bits are compared with "
        "those of the reference implementation: IEEE 754 double precision, each operation rounded to nearest, and "
        "functions of our own for sine, cosine and others. The loops then run with coarser readings, jitter, missed "
        "periods, single precision, longer delays and longer periods. Each loop has two starts, a near one and a far "
        "one. For the laws of the paper's arm, the near start is on the reference and the far start is the paper's."
    ),
    sweeps=(*sweeps(), *shared_sweeps()),
    works=(*replay_works(), *scan_works(), operations_work(), predictive_work(), filter_work()),
    sections=sections,
    seed=SEED,
    live=None,
)

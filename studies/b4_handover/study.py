"""From the report to the machine: six laws replayed bit by bit, and what a computer may do to each of them.

Runs in about two minutes on two cores.
"""

from studies.b4_handover.loops import SEED
from studies.b4_handover.machines import replay_works
from studies.b4_handover.margins import scan_works, sweeps
from studies.b4_handover.operations import operations_work
from studies.b4_handover.pages import headlines, sections
from workbench.study import Study

study = Study(
    name="b4_handover",
    title="From the report to the machine: six laws handed over",
    question=(
        "Does a law that was designed, checked and compared here run with the same bits on the machines that it is "
        "handed to, does it fit its period there, and what is lost by leaving double precision and a perfect clock?"
    ),
    method=(
        "Each law is taken out of its loop with its observer, limits and delay, and replayed on every target that is "
        "installed here: the same inputs, compared bit by bit with the portable arithmetic. The loops are then swept "
        "over what computers do: coarser readings, jitter, missed periods, single precision, delay and a longer period."
    ),
    sweeps=sweeps(),
    works=(*replay_works(), *scan_works(), operations_work()),
    sections=sections,
    headlines=headlines,
    seed=SEED,
    live=None,
)

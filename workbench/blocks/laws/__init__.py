"""Control laws for any plant, one a file: PID, cascade and state feedback.

A law reads estimates and references, and gives commands; it does not know the plant, the observer or the simulator.
Its ports say which signals it reads, follows and drives. Read `regulator.py` first, then `pid2.py`.
"""

from workbench.blocks.laws.cascade import Cascade
from workbench.blocks.laws.pid2 import PID2
from workbench.blocks.laws.regulator import Regulator
from workbench.blocks.loop.linear_blocks import LinearLaw

__all__ = [
    "Cascade",
    "PID2",
    "Regulator",
    "LinearLaw",
]

"""References and disturbances as expressions in time, with their exact derivatives.

This package uses time, names and units, and no plant and no law. Read `signal.py` first, then `waveforms.py`.
"""

from workbench.blocks.signals.planned_reference import PlannedReference
from workbench.blocks.signals.profiles import Trapezoid, WayPoints
from workbench.blocks.signals.signal import AbstractSignal, CombinedReference
from workbench.blocks.signals.sine_torque import SineTorque
from workbench.blocks.signals.table import Table
from workbench.blocks.signals.waveforms import Chirp, Constant, PulseTrain, Ramp, Sines, SquareWave, Step

__all__ = [
    "AbstractSignal",
    "Chirp",
    "Constant",
    "PlannedReference",
    "PulseTrain",
    "Ramp",
    "SineTorque",
    "Sines",
    "SquareWave",
    "Step",
    "Table",
    "CombinedReference",
    "Trapezoid",
    "WayPoints",
]

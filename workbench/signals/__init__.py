"""References and disturbances as expressions in time, with their exact derivatives.

The room knows time, names and units; it knows no plant and no law. Read `signal.py` first, then `steps.py`.
"""

from workbench.signals.periodic import Chirp, PulseTrain, Sines, SineTorque, SquareWave
from workbench.signals.profiles import Table, Trapezoid, WayPoints
from workbench.signals.signal import AbstractSignal, Together
from workbench.signals.steps import Hold, Ramp, Step

__all__ = [
    "AbstractSignal",
    "Chirp",
    "Hold",
    "PulseTrain",
    "Ramp",
    "SineTorque",
    "Sines",
    "SquareWave",
    "Step",
    "Table",
    "Together",
    "Trapezoid",
    "WayPoints",
]

"""References and disturbances as expressions in time, with their exact derivatives."""

from workbench.signals.broadband import Chirp, ColouredNoise
from workbench.signals.periodic import PulseTrain, Sines, SmoothSquareWave, SquareWave
from workbench.signals.profiles import Trapezoid, WayPoints
from workbench.signals.signal import AbstractSignal, Together
from workbench.signals.steps import Hold, Ramp, Step
from workbench.signals.table import Table
from workbench.signals.torque import SineTorque

__all__ = [
    "AbstractSignal",
    "Chirp",
    "ColouredNoise",
    "Hold",
    "PulseTrain",
    "Ramp",
    "SineTorque",
    "Sines",
    "SmoothSquareWave",
    "SquareWave",
    "Step",
    "Table",
    "Together",
    "Trapezoid",
    "WayPoints",
]

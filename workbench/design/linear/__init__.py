"""Linear models of an `Ode`, and their properties: equilibria, modes, paths and margins.

This package takes equations and systems of python-control; it knows no robot, law or loop by name. Read
`linearization.py` first, then `linear_modes.py` for poles, `loop_cuts.py` and `loop_margins.py` for loops that are cut.

Examples
--------
>>> motor = wb.linearize(wb.open_loop(wb.DCMotor()), 0.0, [0.0, 0.0])
>>> len(wb.linear.poles(motor))
2
"""

from workbench.design.linear.compensators import Placement, lead_lag, place
from workbench.design.linear.equilibria import Equilibria, Equilibrium, equilibria
from workbench.design.linear.feedback_loops import frequency_response, one_loop, sensitivity
from workbench.design.linear.linear_modes import Hautus, HautusMode, Pole, controllability, observability, poles
from workbench.design.linear.linear_path import LinearPath, LyapunovExponents, along, freeze, lyapunov_exponents
from workbench.design.linear.linearization import linearize, to_control
from workbench.design.linear.loop_cuts import broken_loop, broken_loops
from workbench.design.linear.loop_margins import DiskMargin, LoopMargins, disk_margin, loop_margins
from workbench.design.linear.operating_point import TrimPoint, operating_point
from workbench.design.linear.realizations import realize
from workbench.design.linear.sampled_models import sampled_model
from workbench.design.matrices import DesignError

__all__ = [
    "DiskMargin",
    "Equilibria",
    "Equilibrium",
    "Hautus",
    "LinearPath",
    "LoopMargins",
    "LyapunovExponents",
    "HautusMode",
    "TrimPoint",
    "Placement",
    "Pole",
    "DesignError",
    "along",
    "broken_loop",
    "broken_loops",
    "controllability",
    "disk_margin",
    "equilibria",
    "freeze",
    "frequency_response",
    "lead_lag",
    "linearize",
    "loop_margins",
    "lyapunov_exponents",
    "observability",
    "one_loop",
    "operating_point",
    "place",
    "poles",
    "realize",
    "sampled_model",
    "sensitivity",
    "to_control",
]

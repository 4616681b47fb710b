"""Linear models of an `Ode`, and what they say: rest points, modes, paths and margins.

`exchange` goes to python-control and back; `points` linearises at a state and finds the inputs that hold one;
`equilibria` finds rest points, and `proofs` shows that they are some, and all; `modes` has poles and the tests of
Popov, Belevitch and Hautus; `paths` and `lyapunov` follow a motion; `loops` cuts
a loop, and `margins` says how far it is from instability; `compensators` places poles and margins.
"""

from workbench.design.linear.compensators import Placement, lead_lag, place
from workbench.design.linear.equilibria import Equilibria, Equilibrium, equilibria
from workbench.design.linear.exchange import forward_differences, from_control, to_control
from workbench.design.linear.held import held
from workbench.design.linear.loops import broken_loop, broken_loops, frequency_response, one_loop, sensitivity
from workbench.design.linear.lyapunov import LyapunovExponents, lyapunov_exponents
from workbench.design.linear.margins import DiskMargin, LoopMargins, disk_margin, loop_margins
from workbench.design.linear.modes import (
    Hautus,
    Mode,
    Pole,
    controllability,
    detectability,
    observability,
    poles,
    stabilisability,
)
from workbench.design.linear.paths import LinearPath, Transition, along, transition
from workbench.design.linear.points import OperatingPoint, linearize, operating_point

__all__ = [
    "DiskMargin",
    "Equilibria",
    "Equilibrium",
    "Hautus",
    "LinearPath",
    "LoopMargins",
    "LyapunovExponents",
    "Mode",
    "OperatingPoint",
    "Placement",
    "Pole",
    "Transition",
    "along",
    "broken_loop",
    "broken_loops",
    "controllability",
    "detectability",
    "disk_margin",
    "equilibria",
    "forward_differences",
    "frequency_response",
    "from_control",
    "held",
    "lead_lag",
    "linearize",
    "loop_margins",
    "lyapunov_exponents",
    "observability",
    "one_loop",
    "operating_point",
    "place",
    "poles",
    "sensitivity",
    "stabilisability",
    "to_control",
    "transition",
]

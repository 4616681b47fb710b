"""The waist of the hourglass: small frozen objects in which makers and users of equations meet.

`core` knows no robot, no law and no plot.
"""

from workbench.core.block import block, initial, option, parameter
from workbench.core.claim import Claim
from workbench.core.combine import with_quadrature, with_sensitivity
from workbench.core.dynamics import AbstractArm, Dynamics
from workbench.core.layout import Entry, Layout
from workbench.core.lift import Lifted, lift
from workbench.core.linear import LinearSystem
from workbench.core.ode import Ode
from workbench.core.port import layout
from workbench.core.roles import Roles, grouped, same_information
from workbench.core.rule import Rule
from workbench.core.sampled import Sampled
from workbench.core.signals import Signals
from workbench.core.stabilised import rkc, stepper
from workbench.core.step import Step, rk4

__all__ = [
    "AbstractArm",
    "Claim",
    "Dynamics",
    "Entry",
    "Layout",
    "Lifted",
    "LinearSystem",
    "Ode",
    "Roles",
    "Rule",
    "Sampled",
    "Signals",
    "Step",
    "block",
    "grouped",
    "initial",
    "layout",
    "lift",
    "option",
    "parameter",
    "rk4",
    "rkc",
    "same_information",
    "stepper",
    "with_quadrature",
    "with_sensitivity",
]

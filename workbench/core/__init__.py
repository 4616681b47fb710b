"""The small frozen objects that all packages share: layouts of signals, units, differential equations and steps.

`blocks` and `arms` make these objects from plants and laws. `engine`, `design`, `proofs`, `study` and `handover` use
only these objects of a plant or a law. `notation` prints expressions as formulas, and `validation` refuses bad
arguments. Read `layout` first, then `block` and `lift`, then `ode` and `step`.

Examples
--------
>>> wb.core.Layout((wb.core.Entry("x", 1.0, "m"),)).labels
('x',)
"""

from workbench.core.augmented_ode import with_quadrature, with_sensitivity
from workbench.core.block import Column, Matrix, Scalar, Vector, block, initial, option, parameter
from workbench.core.claim import BlockClaim, Claim
from workbench.core.layout import Entry, Layout
from workbench.core.linear import LinearSystem
from workbench.core.motion_record import GainRecord, MotionRecord
from workbench.core.ode import Ode
from workbench.core.port import Roles, Signals, information_classes, layout
from workbench.core.sampled_law import SampledLaw, Stage
from workbench.core.sampled_system import SampledSystem
from workbench.core.shapes import Circle, Drawing, Line, Word
from workbench.core.step import StepMap, StepRule, rk4, runge_kutta_step
from workbench.core.symbolic_twin import SymbolicTwin, lift
from workbench.core.validation.refusals import Integers

__all__ = [
    "Circle",
    "Claim",
    "Column",
    "BlockClaim",
    "Drawing",
    "Entry",
    "GainRecord",
    "Integers",
    "Layout",
    "SymbolicTwin",
    "Line",
    "LinearSystem",
    "Matrix",
    "MotionRecord",
    "Ode",
    "Roles",
    "StepRule",
    "SampledSystem",
    "SampledLaw",
    "Scalar",
    "Signals",
    "Stage",
    "StepMap",
    "Vector",
    "Word",
    "block",
    "information_classes",
    "initial",
    "layout",
    "lift",
    "option",
    "parameter",
    "rk4",
    "runge_kutta_step",
    "with_quadrature",
    "with_sensitivity",
]

"""The waist of the hourglass: small frozen objects in which makers and users of equations meet.

They know names, units, expressions of CasADi and their numbers, but no robot, no law and no plot; `drawers` has the
functions that draw objects, which `report` enters. Read `layout` first, then `block` and `lift`, then `ode` and `step`.

Examples
--------
>>> wb.core.Layout((wb.core.Entry("x", 1.0, "m"),)).labels
('x',)
"""

from workbench.core.block import Column, Matrix, Scalar, Vector, block, initial, option, parameter
from workbench.core.claim import Claim, Declared
from workbench.core.layout import Entry, Layout
from workbench.core.lift import Lifted, lift
from workbench.core.linear import LinearSystem
from workbench.core.ode import Ode, with_quadrature, with_sensitivity
from workbench.core.port import Roles, Signals, grouped, layout
from workbench.core.sampled import Sampled
from workbench.core.sampled_law import SampledLaw, Stage
from workbench.core.shapes import Circle, Drawing, Line, Word
from workbench.core.step import Rule, Step, rk4, runge_kutta_step
from workbench.core.validation.refusals import Integers

__all__ = [
    "Circle",
    "Claim",
    "Column",
    "Declared",
    "Drawing",
    "Entry",
    "Integers",
    "Layout",
    "Lifted",
    "Line",
    "LinearSystem",
    "Matrix",
    "Ode",
    "Roles",
    "Rule",
    "Sampled",
    "SampledLaw",
    "Scalar",
    "Signals",
    "Stage",
    "Step",
    "Vector",
    "Word",
    "block",
    "grouped",
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

"""The equations of an arm written out: M, C and G for reading, and as functions that other machines compute.

This package uses `Dynamics` and printed formulas, and no loops. Read `arm_equations` first, then
`arm_functions`, whose laws without memory the command line hands over as C, Python or CasADi.
"""

from collections.abc import Callable, Mapping

from workbench.arms.code.arm_equations import as_latex, as_mathml, as_text, as_typst, in_numbers
from workbench.arms.code.arm_functions import functions_of
from workbench.arms.dynamics import Dynamics

READABLE: Mapping[str, Callable[[Dynamics], str]] = {
    "text": as_text,
    "latex": as_latex,
    "typst": as_typst,
    "mathml": as_mathml,
}

__all__ = ["READABLE", "as_latex", "as_mathml", "as_text", "as_typst", "functions_of", "in_numbers"]

"""The equations of an arm written out: for reading, and as programs that compute the same numbers.

The room knows `Dynamics` and how a formula is printed, and nothing of laws or loops. Read `arm_equations` first, then
`arm_code`.
"""

from collections.abc import Callable, Mapping

from workbench.arms.code.arm_code import as_c, as_casadi, as_python
from workbench.arms.code.arm_equations import as_latex, as_mathml, as_text, as_typst, in_numbers
from workbench.arms.dynamics import Dynamics

FORMS: Mapping[str, Callable[[Dynamics], str]] = {
    "text": as_text,
    "latex": as_latex,
    "typst": as_typst,
    "mathml": as_mathml,
    "python": as_python,
    "casadi": as_casadi,
    "c": as_c,
}

__all__ = ["FORMS", "as_c", "as_casadi", "as_latex", "as_mathml", "as_python", "as_text", "as_typst", "in_numbers"]

"""The equations of an arm written out: for reading, and as programs that compute the same numbers."""

from collections.abc import Callable, Mapping

from workbench.core import Dynamics
from workbench.handover.c_code import as_c
from workbench.handover.casadi_code import as_casadi
from workbench.handover.numbers import in_numbers
from workbench.handover.page import as_latex, as_mathml, as_text, as_typst
from workbench.handover.python_code import as_python

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

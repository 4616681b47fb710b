"""The equations of an arm written out: for reading, and as programs that compute the same numbers."""

from collections.abc import Callable, Mapping

from workbench.core import Dynamics
from workbench.derivation.c_code import as_c
from workbench.derivation.casadi_code import as_casadi
from workbench.derivation.numbers import in_numbers
from workbench.derivation.page import as_latex, as_mathml, as_text, as_typst
from workbench.derivation.python_code import as_python

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

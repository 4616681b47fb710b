"""Formulas as Python: an expression for each formula, an assignment for each equation."""

from __future__ import annotations

import keyword
import re
from collections.abc import Sequence
from dataclasses import dataclass

from workbench.notation.flat import AbstractFlat
from workbench.notation.formula import Formula, Symbol, System, letters, name_of
from workbench.notation.layout import rows
from workbench.validation.signatures import door

# Functions whose NumPy name is not the one they have in mathematics.
NUMPY = {
    "min": "minimum",
    "max": "maximum",
    "mod": "fmod",
    "asin": "arcsin",
    "acos": "arccos",
    "atan": "arctan",
    "atan2": "arctan2",
    "asinh": "arcsinh",
    "acosh": "arccosh",
    "atanh": "arctanh",
    "copysign": "copysign",
}
SAME = {"sin", "cos", "tan", "sinh", "cosh", "tanh", "exp", "log", "sqrt", "abs", "sign", "floor", "ceil", "hypot"}


@door
def emit(formula: Formula, *, width: float = 100, module: str = "np") -> str:
    """A formula as Python over NumPy, which is known as `module`; symbols are variables.

    The names of the variables are those of `identifier`. An equation becomes an assignment, a
    `System` several.

    Raises
    ------
    ValueError
        If two symbols would become one variable, or if NumPy lacks a function (it is named).
    """
    _refuse_confusion(formula, module)
    if isinstance(formula, System):
        return "\n".join(emit(relation, width=width, module=module) for relation in formula.relations)
    lines = rows(formula, _Python(module), width - 4)
    if len(lines) == 1:
        return lines[0].left + lines[0].right
    head = lines[0].left + (" = " if lines[0].left else "")
    first = lines[0].right.removeprefix(" = ")
    body = "\n".join(f"    {line.lstrip()}" for line in [first, *(line.right for line in lines[1:])])
    return f"{head}(\n{body}\n)"


@door
def identifier(symbol: Symbol) -> str:
    """The variable for a symbol: its name, with what no variable may hold spelt out in hexadecimal."""
    name = re.sub(r"[^A-Za-z0-9_]", lambda match: f"_x{ord(match[0]):x}_", name_of(symbol))
    if not name or name[0].isdigit():
        name = f"_{name}"
    return f"{name}_" if keyword.iskeyword(name) else name


def _refuse_confusion(formula: Formula, module: str) -> None:
    owners: dict[str, Symbol] = {}
    for symbol in letters(formula):
        name = identifier(symbol)
        if name == module or owners.setdefault(name, symbol) != symbol:
            raise ValueError(f"`emit(formula)` needs a variable for each symbol, but two things would be '{name}'.")


@dataclass(frozen=True)
class _Python(AbstractFlat):
    module: str
    names_entries = False
    power_sign = "**"

    def symbol(self, symbol: Symbol, exponent: str = "") -> str:
        return identifier(symbol)

    def sign(self, sign: str, *, unary: bool = False) -> str:
        sign = {"and": "&", "or": "|"}.get(sign, sign)
        return sign if unary else f" {sign} "

    def opening(self, function: str = "") -> str:
        if function == "sat":
            return f"{self.module}.clip(a_min=-1, a_max=1, a="
        return f"{self.module}.{_function(function)}(" if function else "("

    def matrix(self, rows: Sequence[Sequence[str]]) -> str:
        body = ", ".join("[" + ", ".join(row) + "]" for row in rows)
        return f"{self.module}.array([{body}])"

    def cases(self, branches: Sequence[tuple[str, str]], otherwise: str) -> str:
        for value, when in reversed(branches):
            otherwise = f"{self.module}.where({when}, {value}, {otherwise})"
        return otherwise


def _function(name: str) -> str:
    if name not in NUMPY and name not in SAME:
        raise ValueError(f"`emit(formula)` writes functions of NumPy, which has no '{name}'.")
    return NUMPY.get(name, name)

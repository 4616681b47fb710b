"""Formulas in plain ASCII, for terminals and log files: `m_2*l_1*l_2*cos(q_2)`."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from workbench.notation.formula import Formula, Symbol, name_of
from workbench.notation.line_breaking import rows
from workbench.notation.markup import AbstractMarkup, Space
from workbench.validation.signatures import door


@door
def emit(formula: Formula, *, width: float = 100) -> str:
    """A formula in lines of at most `width` characters, the later ones indented."""
    lines = rows(formula, _Text(), width - len(INDENT))
    return "\n".join(
        line.left + line.right if line.left or i == 0 else INDENT + line.right.lstrip() for i, line in enumerate(lines)
    )


INDENT = "    "


class _Text(AbstractMarkup):
    flat = True

    def number(self, value: Fraction | float) -> str:
        return str(value) if isinstance(value, Fraction) else repr(value)

    def symbol(self, symbol: Symbol, exponent: str = "") -> str:
        return ascii(name_of(symbol))[1:-1]

    def sign(self, sign: str, *, unary: bool = False) -> str:
        return sign if unary else f" {sign} "

    def times(self, space: Space) -> str:
        return "*"

    def row(self, parts: Sequence[str]) -> str:
        return "".join(parts)

    def quotient(self, numerator: str, denominator: str) -> str:
        return f"{numerator}/{denominator}"

    def power(self, base: str, exponent: str) -> str:
        return f"{base}^{exponent}"

    def call(self, function: str, arguments: Sequence[str], *, exponent: str = "", bare: bool = False) -> str:
        return f"{function}({', '.join(arguments)})"

    def group(self, inner: str) -> str:
        return f"({inner})"

    def opening(self, function: str = "") -> str:
        return f"{function}("

    def closing(self, exponent: str = "") -> str:
        return self.power(")", exponent) if exponent else ")"

    def matrix(self, rows: Sequence[Sequence[str]]) -> str:
        return "[" + ", ".join("[" + ", ".join(row) + "]" for row in rows) + "]"

    def cases(self, branches: Sequence[tuple[str, str]], otherwise: str) -> str:
        return "".join(f"{value} if {when} else " for value, when in branches) + otherwise

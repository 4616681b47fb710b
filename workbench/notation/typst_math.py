"""Formulas in the mathematics of Typst: `dot(q)_(1)`, `frac(1, 2)`, lines aligned at `&`."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from workbench.notation.formula import Formula, Symbol
from workbench.notation.line_breaking import rows
from workbench.notation.markup import KNOWN, PRINTED, AbstractMarkup, Space, runs, scientific, style, visible
from workbench.validation.signatures import door

SIGNS = {"==": "=", "and": "and", "or": "or"}
GREEK = {"phi": "phi.alt"}
ACCENTS = {"hat": "hat", "tilde": "tilde", "bar": "macron"}
DOTS = {1: "dot", 2: "dot.double"}
FENCES = {"sqrt", "abs", "floor", "ceil"}


@door
def emit(formula: Formula, *, width: float = 80) -> str:
    """A formula for an equation, broken into lines of `width` digits (80 are 15.5 cm at 11 pt)."""
    lines = rows(formula, TYPST, width)
    if len(lines) == 1:
        return TYPST.row([lines[0].left, lines[0].right])
    # After an empty string a plus at the start of a line is a sign between two terms.
    return " \\\n".join(
        f"{line.left} & {line.right}" if line.left or i == 0 else f'& quad "" {line.right}'
        for i, line in enumerate(lines)
    )


class _Typst(AbstractMarkup):
    flat = False

    def number(self, value: Fraction | float) -> str:
        if isinstance(value, Fraction):
            return f"frac({value.numerator}, {value.denominator})" if value.denominator > 1 else str(value)
        digits, exponent = scientific(value)
        power = f"10^({exponent})"
        return digits if not exponent else power if digits == "1" else f"{digits} dot.op {power}"

    def symbol(self, symbol: Symbol, exponent: str = "") -> str:
        text = _letter(symbol.letter)
        if symbol.bold:
            text = f"bold({text})"
        if symbol.accent:
            text = f"{ACCENTS[symbol.accent]}({text})"
        if symbol.dots:
            text = f"{DOTS[symbol.dots]}({text})"
        index, mark = _index(symbol.index), exponent or _index(symbol.mark)
        return text + (f"_({index})" if index else "") + (f"^({mark})" if mark else "")

    def sign(self, sign: str, *, unary: bool = False) -> str:
        return SIGNS.get(sign, sign)

    def times(self, space: Space) -> str:
        return "dot.op" if space == "dot" else ""

    def row(self, parts: Sequence[str]) -> str:
        return " ".join(filter(None, parts))

    def quotient(self, numerator: str, denominator: str) -> str:
        return f"frac({numerator}, {denominator})"

    def power(self, base: str, exponent: str) -> str:
        return f"{base}^({exponent})"

    def call(self, function: str, arguments: Sequence[str], *, exponent: str = "", bare: bool = False) -> str:
        inner = ", ".join(arguments)
        if function in FENCES:
            return f"{function}({inner})"
        name = _function(function) + (f"^({exponent})" if exponent else "")
        return f"{name} {inner}" if bare else name + self.group(inner)

    def group(self, inner: str) -> str:
        return f"({inner})"

    def opening(self, function: str = "") -> str:
        return (_function(function) if function else "") + r"\("

    def closing(self, exponent: str = "") -> str:
        return r"\)" + (f"^({exponent})" if exponent else "")

    def matrix(self, rows: Sequence[Sequence[str]]) -> str:
        return f'mat(delim: "[", column-gap: #1em, {"; ".join(", ".join(row) for row in rows)})'

    def cases(self, branches: Sequence[tuple[str, str]], otherwise: str) -> str:
        lines = [f'{value} & quad "if" {when}' for value, when in branches]
        body = ", ".join([*lines, f'{otherwise} & quad "otherwise"'])
        return f"cases({body})"


TYPST = _Typst()


def _letter(text: str) -> str:
    match style(text):
        case "greek":
            return GREEK.get(text, text)
        case "letter" if text.isascii():
            return text
        case "number":
            return text
        case _:
            return f"upright({_string(text)})"


def _string(text: str) -> str:
    """A string literal, in which nothing is code."""
    escaped = visible(text).replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


def _index(index: str) -> str:
    return " ".join(text if text in ",*" else _letter(text) for _, text in runs(index)) if index else ""


def _function(name: str) -> str:
    name = PRINTED.get(name, name)
    return name if name in KNOWN else f"op({_string(name)})"

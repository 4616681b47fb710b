r"""Formulas in LaTeX, with amsmath: `\dot{q}_{1}`, `\frac{1}{2}`, `\begin{aligned} ... \end{aligned}`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction

from workbench.notation.formula import Formula, Relation, Symbol, System
from workbench.notation.line_breaking import Row, rows
from workbench.notation.markup import KNOWN, PRINTED, AbstractMarkup, Space, runs, scientific, style, visible
from workbench.validation.signatures import door

SPECIAL = {c: f"\\{c}" for c in "{}$#%&_"} | {
    "\\": r"\textbackslash{}",
    "^": r"\textasciicircum{}",
    "~": r"\textasciitilde{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
}
SIGNS = {"==": "=", "!=": r"\neq", "<=": r"\leq", ">=": r"\geq", "and": r"\land", "or": r"\lor"}
GREEK = {"epsilon": r"\varepsilon"}
FENCES = {"abs": ("|", "|"), "floor": (r"\lfloor", r"\rfloor"), "ceil": (r"\lceil", r"\rceil")}


@door
def emit(formula: Formula, *, width: float = 80) -> str:
    r"""A formula for display mathematics, broken into lines of `width` digits (80 are 15.5 cm at 11 pt)."""
    lines = rows(formula, LATEX, width)
    if len(lines) == 1:
        return LATEX.row([lines[0].left, lines[0].right])
    return f"\\begin{{aligned}}\n{_aligned(lines)}\n\\end{{aligned}}"


@door
def display(relations: Iterable[Relation], *, width: float = 80) -> str:
    r"""Equations one below the other, aligned at their signs, between which a page may end (`\allowdisplaybreaks`)."""
    return f"\\begin{{align*}}\n{_aligned(rows(System(tuple(relations)), LATEX, width))}\n\\end{{align*}}"


def _aligned(lines: Sequence[Row]) -> str:
    # The empty group makes a plus at the start of a line a sign between two terms.
    return " \\\\\n".join(
        f"{line.left} & {line.right}" if line.left or i == 0 else rf"& \quad {{}} {line.right}"
        for i, line in enumerate(lines)
    )


class _Latex(AbstractMarkup):
    flat = False

    def number(self, value: Fraction | float) -> str:
        if isinstance(value, Fraction):
            return rf"\frac{{{value.numerator}}}{{{value.denominator}}}" if value.denominator > 1 else str(value)
        digits, exponent = scientific(value)
        power = f"10^{{{exponent}}}"
        return digits if not exponent else power if digits == "1" else rf"{digits} \cdot {power}"

    def symbol(self, symbol: Symbol, exponent: str = "") -> str:
        text = _letter(symbol.letter)
        if symbol.bold:
            text = rf"\boldsymbol{{{text}}}"
        if symbol.accent:
            text = rf"\{symbol.accent}{{{text}}}"
        if symbol.dots:
            text = rf"\{'d' * symbol.dots}ot{{{text}}}"
        index, mark = _index(symbol.index), exponent or _index(symbol.mark)
        return text + (f"_{{{index}}}" if index else "") + (f"^{{{mark}}}" if mark else "")

    def sign(self, sign: str, *, unary: bool = False) -> str:
        return SIGNS.get(sign, sign)

    def times(self, space: Space) -> str:
        return r"\cdot" if space == "dot" else ""

    def row(self, parts: Sequence[str]) -> str:
        return " ".join(filter(None, parts))

    def quotient(self, numerator: str, denominator: str) -> str:
        return rf"\frac{{{numerator}}}{{{denominator}}}"

    def power(self, base: str, exponent: str) -> str:
        return f"{base}^{{{exponent}}}"

    def call(self, function: str, arguments: Sequence[str], *, exponent: str = "", bare: bool = False) -> str:
        inner = ", ".join(arguments)
        if function == "sqrt":
            return rf"\sqrt{{{inner}}}"
        if function in FENCES:
            left, right = FENCES[function]
            return rf"\left{left} {inner} \right{right}"
        name = _function(function) + (f"^{{{exponent}}}" if exponent else "")
        return f"{name} {inner}" if bare else name + self.group(inner)

    def group(self, inner: str) -> str:
        return rf"\left( {inner} \right)"

    def opening(self, function: str = "") -> str:
        return (_function(function) if function else "") + r"\bigl("

    def closing(self, exponent: str = "") -> str:
        return r"\bigr)" + (f"^{{{exponent}}}" if exponent else "")

    def matrix(self, rows: Sequence[Sequence[str]]) -> str:
        body = r" \\ ".join(" & ".join(row) for row in rows)
        return rf"\left[ \begin{{array}}{{{'c' * len(rows[0])}}} {body} \end{{array}} \right]"

    def cases(self, branches: Sequence[tuple[str, str]], otherwise: str) -> str:
        lines = [*(rf"{value} & \text{{if }} {when}" for value, when in branches), rf"{otherwise} & \text{{otherwise}}"]
        body = r" \\ ".join(lines)
        return rf"\begin{{cases}} {body} \end{{cases}}"


LATEX = _Latex()


def _letter(text: str) -> str:
    match style(text):
        case "greek":
            return GREEK.get(text, f"\\{text}")
        case "word":
            return _word(text)
        case _:
            return text


def _word(text: str) -> str:
    if text.isascii() and text.isalnum():
        return rf"\mathrm{{{text}}}"
    return rf"\text{{{''.join(SPECIAL.get(c, c) for c in visible(text))}}}"


def _index(index: str) -> str:
    return "".join(text if text in ",*" else _letter(text) for _, text in runs(index)) if index else ""


def _function(name: str) -> str:
    name = PRINTED.get(name, name)
    if name in KNOWN:
        return f"\\{name}"
    return rf"\operatorname{{{name if name.isascii() and name.isalnum() else _word(name)}}}"

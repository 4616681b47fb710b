"""Formulas in MathML Core, which browsers typeset by themselves."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from html import escape

from workbench.notation.formula import GREEK, Formula, Symbol
from workbench.notation.line_breaking import Row, rows
from workbench.notation.markup import PRINTED, AbstractMarkup, Space, runs, scientific, style, visible
from workbench.validation.signatures import door

SIGNS = {"-": "−", "==": "=", "!=": "≠", "<=": "≤", ">=": "≥", "and": "∧", "or": "∨"}
# Spacing marks of their own, not combining ones: browsers misplace those.
ACCENTS = {"hat": "^", "tilde": "~", "bar": "¯"}
DOTS = {1: "˙", 2: "¨"}
SPACES = {
    "none": '<mo lspace="0" rspace="0">&#x2062;</mo>',
    "thin": '<mo lspace="0" rspace="0">&#x2062;</mo><mspace width="0.17em"/>',
    "dot": "<mo>⋅</mo>",
}
APPLY = '<mo lspace="0" rspace="0">&#x2061;</mo>'
FENCES = {"abs": ("|", "|"), "floor": ("⌊", "⌋"), "ceil": ("⌈", "⌉")}


@door
def emit(formula: Formula, *, width: float = 80, display: bool = True) -> str:
    """A formula as a `<math>` element, on lines of its own of `width` digits unless `display` is False."""
    lines = rows(formula, MATHML, width if display else float("inf"))
    block = ' display="block"' if display else ""
    if len(lines) == 1:
        return f"<math{block}>{MATHML.row([lines[0].left, lines[0].right])}</math>"
    body = "".join(_line(line, i > 0) for i, line in enumerate(lines))
    return f'<math{block}><mtable displaystyle="true">{body}</mtable></math>'


def _line(line: Row, later: bool) -> str:
    indent = '<mspace width="1em"/>' if later and not line.left else ""
    left = f'<mtd style="text-align: right; padding-right: 0">{MATHML.row([line.left])}</mtd>'
    right = f'<mtd style="text-align: left; padding-left: 0">{MATHML.row([indent, line.right])}</mtd>'
    return f"<mtr>{left}{right}</mtr>"


class _MathMl(AbstractMarkup):
    flat = False

    def number(self, value: Fraction | float) -> str:
        if isinstance(value, Fraction):
            above, below = f"<mn>{value.numerator}</mn>", f"<mn>{value.denominator}</mn>"
            return f"<mfrac>{above}{below}</mfrac>" if value.denominator > 1 else above
        digits, exponent = scientific(value)
        if not exponent:
            return f"<mn>{digits}</mn>"
        sign = "<mo>−</mo>" if exponent.startswith("-") else ""
        power = f"<msup><mn>10</mn><mrow>{sign}<mn>{exponent.lstrip('-')}</mn></mrow></msup>"
        return power if digits == "1" else self.row([f"<mn>{digits}</mn>", SPACES["dot"], power])

    def symbol(self, symbol: Symbol, exponent: str = "") -> str:
        text = _letter(symbol.letter, bold=symbol.bold)
        if symbol.accent:
            text = _over(text, ACCENTS[symbol.accent])
        if symbol.dots:
            text = _over(text, DOTS[symbol.dots])
        index, mark = _index(symbol.index), exponent or _index(symbol.mark)
        if index and mark:
            return f"<msubsup>{text}{index}{mark}</msubsup>"
        return f"<msub>{text}{index}</msub>" if index else f"<msup>{text}{mark}</msup>" if mark else text

    def sign(self, sign: str, *, unary: bool = False) -> str:
        form = ' form="prefix"' if unary else ' form="infix"'
        return f"<mo{form}>{escape(SIGNS.get(sign, sign))}</mo>"

    def times(self, space: Space) -> str:
        return SPACES[space]

    def row(self, parts: Sequence[str]) -> str:
        shown = [part for part in parts if part]
        return shown[0] if len(shown) == 1 else f"<mrow>{''.join(shown)}</mrow>"

    def quotient(self, numerator: str, denominator: str) -> str:
        return f"<mfrac>{numerator}{denominator}</mfrac>"

    def power(self, base: str, exponent: str) -> str:
        return f"<msup>{base}{exponent}</msup>"

    def call(self, function: str, arguments: Sequence[str], *, exponent: str = "", bare: bool = False) -> str:
        inner = '<mo separator="true">,</mo>'.join(arguments)
        if function == "sqrt":
            return f"<msqrt>{inner}</msqrt>"
        if function in FENCES:
            left, right = FENCES[function]
            return self.row([_fence("prefix", left), inner, _fence("postfix", right)])
        name = f"<msup>{_function(function)}{exponent}</msup>" if exponent else _function(function)
        space = '<mspace width="0.17em"/>'
        return self.row([name, APPLY, space, inner] if bare else [name, APPLY, self.group(inner)])

    def group(self, inner: str) -> str:
        return self.row([_fence("prefix", "("), inner, _fence("postfix", ")")])

    def opening(self, function: str = "") -> str:
        return (_function(function) + APPLY if function else "") + '<mo form="prefix" stretchy="false">(</mo>'

    def closing(self, exponent: str = "") -> str:
        bracket = '<mo form="postfix" stretchy="false">)</mo>'
        return self.power(bracket, exponent) if exponent else bracket

    def matrix(self, rows: Sequence[Sequence[str]]) -> str:
        body = "".join(f"<mtr>{''.join(f'<mtd>{entry}</mtd>' for entry in row)}</mtr>" for row in rows)
        return self.row([_fence("prefix", "["), f"<mtable>{body}</mtable>", _fence("postfix", "]")])

    def cases(self, branches: Sequence[tuple[str, str]], otherwise: str) -> str:
        pairs = [*((value, f"<mrow><mtext>if&#xA0;</mtext>{when}</mrow>") for value, when in branches)]
        pairs.append((otherwise, "<mtext>otherwise</mtext>"))
        cell = '<mtd style="text-align: left">{}</mtd>'
        body = "".join(f"<mtr>{cell.format(value)}{cell.format(when)}</mtr>" for value, when in pairs)
        return self.row([_fence("prefix", "{"), f"<mtable>{body}</mtable>"])


MATHML = _MathMl()


def _over(base: str, accent: str) -> str:
    return f'<mover accent="true">{base}<mo>{accent}</mo></mover>'


def _fence(form: str, sign: str) -> str:
    return f'<mo form="{form}" fence="true" stretchy="true">{sign}</mo>'


def _letter(text: str, *, bold: bool = False) -> str:
    kind = style(text)
    if kind == "number":
        return f"<mn>{text}</mn>"
    attributes = ' style="font-weight: bold"' if bold else ""
    # One letter alone is slanted unless told otherwise; capital Greek letters and words are upright.
    if (len(text) == 1 and kind == "word") or (kind == "greek" and text[0].isupper()):
        attributes += ' mathvariant="normal"'
    return f"<mi{attributes}>{GREEK[text] if kind == 'greek' else escape(visible(text))}</mi>"


def _index(index: str) -> str:
    if not index:
        return ""
    parts = [
        '<mo separator="true" rspace="0">,</mo>' if text == "," else "<mo>*</mo>" if text == "*" else _letter(text)
        for _, text in runs(index)
    ]
    return parts[0] if len(parts) == 1 else f"<mrow>{''.join(parts)}</mrow>"


def _function(name: str) -> str:
    return f"<mi>{escape(visible(PRINTED.get(name, name)))}</mi>"

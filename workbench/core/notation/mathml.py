"""Formulas in MathML Core, which browsers typeset by themselves."""

from __future__ import annotations

from html import escape

from workbench.core.notation.formula import ACCENTS, GREEK, Formula
from workbench.core.notation.line_breaking import Row, rows
from workbench.core.notation.markup import PRINTED_FUNCTIONS, Grid, Markup, style, visible
from workbench.core.validation.signatures import check_arguments

SIGNS = {"-": "−", "==": "=", "!=": "≠", "<": "&lt;", ">": "&gt;", "<=": "≤", ">=": "≥", "and": "∧", "or": "∨"}
PRODUCT, APPLY = (f'<mo lspace="0" rspace="0">&#x206{digit};</mo>' for digit in (2, 1))
THIN, DOT = '<mspace width="0.17em"/>', "<mo>⋅</mo>"
OVER = '<mover accent="true">{{}}<mo>{}</mo></mover>'
OPENING_FENCE = '<mrow><mo form="prefix" fence="true" stretchy="true">{}</mo>{}'
CLOSING_FENCE = '<mo form="postfix" fence="true" stretchy="true">{}</mo></mrow>'


@check_arguments
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


def _letter(text: str, bold: bool) -> str:
    kind = style(text)
    if kind == "number":
        return f"<mn>{text}</mn>"
    attributes = ' style="font-weight: bold"' if bold else ""
    # One letter alone is slanted unless told otherwise; capital Greek letters and words are upright.
    if (len(text) == 1 and kind == "word") or (kind == "greek" and text[0].isupper()):
        attributes += ' mathvariant="normal"'
    return f"<mi{attributes}>{GREEK[text] if kind == 'greek' else escape(visible(text))}</mi>"


def _fence(left: str, inner: str, right: str = "") -> str:
    return OPENING_FENCE.format(left, inner) + (CLOSING_FENCE.format(right) if right else "</mrow>")


MATHML = Markup(
    letter=_letter,
    function=lambda name: f"<mi>{escape(visible(PRINTED_FUNCTIONS.get(name, name)))}</mi>",
    signs=SIGNS,
    before='<mo form="prefix">{}</mo>',
    amid='<mo form="infix">{}</mo>',
    spaces={"none": PRODUCT, "thin": PRODUCT + THIN, "dot": DOT},
    between="",
    several="<mrow>{}</mrow>",
    digits="<mn>{}</mn>",
    ten="<msup><mn>10</mn><mrow>{}<mn>{}</mn></mrow></msup>",
    minus="<mo>−</mo>",
    # Spacing marks of their own, not combining ones: browsers misplace those.
    over={sign: OVER.format(mark) for sign, mark in zip((*ACCENTS, "dot", "ddot"), "^~¯˙¨", strict=True)},
    subscript="<msub>{}{}</msub>",
    both="<msubsup>{}{}{}</msubsup>",
    marks={",": '<mo separator="true" rspace="0">,</mo>', "*": "<mo>*</mo>", "+": '<mo lspace="0" rspace="0">+</mo>'},
    quotient="<mfrac>{}{}</mfrac>",
    power="<msup>{}{}</msup>",
    group=_fence("(", "{}", ")"),
    opening_fence='<mo form="prefix" stretchy="false">(</mo>',
    closing_fence='<mo form="postfix" stretchy="false">)</mo>',
    applies=APPLY,
    application=f"<mrow>{{}}{APPLY}{{}}</mrow>",
    bare=f"<mrow>{{}}{APPLY}{THIN}{{}}</mrow>",
    comma='<mo separator="true">,</mo>',
    enclosures={
        "sqrt": "<msqrt>{}</msqrt>",
        "abs": _fence("|", "{}", "|"),
        "floor": _fence("⌊", "{}", "⌋"),
        "ceil": _fence("⌈", "{}", "⌉"),
    },
    grid=Grid("", "", _fence("[", "<mtable>{}</mtable>", "]"), "<mtd>{}</mtd>", "<mtr>{}</mtr>"),
    case_grid=Grid(
        "", "", _fence("{{", "<mtable>{}</mtable>"), '<mtd style="text-align: left">{}</mtd>', "<mtr>{}</mtr>"
    ),
    condition="<mrow><mtext>if&#xA0;</mtext>{}</mrow>",
    otherwise="<mtext>otherwise</mtext>",
)

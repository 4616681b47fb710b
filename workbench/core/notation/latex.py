r"""Formulas in LaTeX, with amsmath: `\dot{q}_{1}`, `\frac{1}{2}`, `\begin{aligned} ... \end{aligned}`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from workbench.core.notation.formula import ACCENTS, Formula, Relation, System
from workbench.core.notation.line_breaking import Row, rows
from workbench.core.notation.markup import KNOWN_FUNCTIONS, PRINTED_FUNCTIONS, Grid, Markup, style, visible
from workbench.core.validation.signatures import check_arguments

SPECIAL = {c: f"\\{c}" for c in "{}$#%&_"} | {
    "\\": r"\textbackslash{}",
    "^": r"\textasciicircum{}",
    "~": r"\textasciitilde{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
}
GREEK = {"epsilon": r"\varepsilon"}


@check_arguments
def emit(formula: Formula, *, width: float = 80) -> str:
    r"""A formula for display mathematics, broken into lines of `width` digits (80 are 15.5 cm at 11 pt)."""
    lines = rows(formula, LATEX, width)
    if len(lines) == 1:
        return LATEX.row([lines[0].left, lines[0].right])
    return f"\\begin{{aligned}}\n{_align_rows(lines)}\n\\end{{aligned}}"


@check_arguments
def display(relations: Iterable[Relation], *, width: float = 80) -> str:
    r"""Equations one below the other, aligned at their signs, between which a page may end (`\allowdisplaybreaks`)."""
    return f"\\begin{{align*}}\n{_align_rows(rows(System(tuple(relations)), LATEX, width))}\n\\end{{align*}}"


def _align_rows(lines: Sequence[Row]) -> str:
    # The empty group makes a plus at the start of a line a sign between two terms.
    return " \\\\\n".join(
        f"{line.left} & {line.right}" if line.left or i == 0 else rf"& \quad {{}} {line.right}"
        for i, line in enumerate(lines)
    )


def _letter(text: str, bold: bool) -> str:
    kind = style(text)
    shown = GREEK.get(text, f"\\{text}") if kind == "greek" else _word(text) if kind == "word" else text
    return rf"\boldsymbol{{{shown}}}" if bold else shown


def _word(text: str) -> str:
    if text.isascii() and text.isalnum():
        return rf"\mathrm{{{text}}}"
    return rf"\text{{{''.join(SPECIAL.get(c, c) for c in visible(text))}}}"


def _function(name: str) -> str:
    name = PRINTED_FUNCTIONS.get(name, name)
    if name in KNOWN_FUNCTIONS:
        return f"\\{name}"
    return rf"\operatorname{{{name if name.isascii() and name.isalnum() else _word(name)}}}"


LATEX = Markup(
    letter=_letter,
    function=_function,
    signs={"==": "=", "!=": r"\neq", "<=": r"\leq", ">=": r"\geq", "and": r"\land", "or": r"\lor"},
    spaces={"none": "", "thin": "", "dot": r"\cdot"},
    between=" ",
    ten="10^{{{}{}}}",
    over={sign: "\\" + sign + "{{{}}}" for sign in (*ACCENTS, "dot", "ddot")},
    subscript="{}_{{{}}}",
    both="{}_{{{}}}^{{{}}}",
    marks={",": ",", "*": "*", "+": "+"},
    quotient=r"\frac{{{}}}{{{}}}",
    power="{}^{{{}}}",
    group=r"\left( {} \right)",
    opening_fence=r"\bigl(",
    closing_fence=r"\bigr)",
    bare="{} {}",
    enclosures={
        "sqrt": r"\sqrt{{{}}}",
        "abs": r"\left| {} \right|",
        "floor": r"\left\lfloor {} \right\rfloor",
        "ceil": r"\left\lceil {} \right\rceil",
    },
    grid=Grid(" & ", r" \\ ", r"\left[ \begin{{array}}{{{1}}} {0} \end{{array}} \right]"),
    case_grid=Grid(" & ", r" \\ ", r"\begin{{cases}} {0} \end{{cases}}"),
    condition=r"\text{{if }} {}",
    otherwise=r"\text{otherwise}",
)

"""Formulas in the mathematics of Typst: `dot(q)_(1)`, `frac(1, 2)`, lines aligned at `&`."""

from __future__ import annotations

from workbench.core.notation.formula import Formula
from workbench.core.notation.line_breaking import rows
from workbench.core.notation.markup import KNOWN_FUNCTIONS, PRINTED_FUNCTIONS, Grid, Markup, style, visible
from workbench.core.validation.signatures import check_arguments


@check_arguments
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


def _letter(text: str, bold: bool) -> str:
    match style(text):
        case "greek":
            shown = "phi.alt" if text == "phi" else text
        case "number":
            shown = text
        case "letter" if text.isascii():
            shown = text
        case _:
            shown = f"upright({_string(text)})"
    return f"bold({shown})" if bold else shown


def _string(text: str) -> str:
    escaped = visible(text).replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


def _function(name: str) -> str:
    name = PRINTED_FUNCTIONS.get(name, name)
    return name if name in KNOWN_FUNCTIONS else f"op({_string(name)})"


TYPST = Markup(
    letter=_letter,
    function=_function,
    signs={"==": "="},
    spaces={"none": "", "thin": "", "dot": "dot.op"},
    between=" ",
    ten="10^({}{})",
    over={"hat": "hat({})", "tilde": "tilde({})", "bar": "macron({})", "dot": "dot({})", "ddot": "dot.double({})"},
    subscript="{}_({})",
    both="{}_({})^({})",
    marks={",": ",", "*": "*", "+": "+"},
    apart=" ",
    quotient="frac({}, {})",
    power="{}^({})",
    group="({})",
    opening_fence=r"\(",
    closing_fence=r"\)",
    bare="{} {}",
    enclosures={name: f"{name}({{}})" for name in ("sqrt", "abs", "floor", "ceil")},
    grid=Grid(", ", "; ", 'mat(delim: "[", column-gap: #1em, {})'),
    case_grid=Grid(" & ", ", ", "cases({})"),
    condition='quad "if" {}',
    otherwise='quad "otherwise"',
)

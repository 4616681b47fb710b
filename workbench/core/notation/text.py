"""Formulas in plain ASCII, for terminals and log files: `m_2*l_1*l_2*cos(q_2)`."""

from __future__ import annotations

from workbench.core.notation.formula import Formula
from workbench.core.notation.line_breaking import rows
from workbench.core.notation.markup import Grid, Markup
from workbench.core.validation.signatures import check_arguments

INDENT = "    "


@check_arguments
def emit(formula: Formula, *, width: float = 100) -> str:
    """A formula in lines of at most `width` characters, the later ones indented."""
    lines = rows(formula, TEXT, width - len(INDENT))
    return "\n".join(
        line.left + line.right if line.left or i == 0 else INDENT + line.right.lstrip() for i, line in enumerate(lines)
    )


TEXT = Markup(
    flat=True,
    letter=lambda text, bold: text,
    function=str,
    signs={},
    amid=" {} ",
    spaces=dict.fromkeys(("none", "thin", "dot"), "*"),
    between="",
    over={},
    marks={},
    quotient="{}/{}",
    power="{}^{}",
    group="({})",
    opening_fence="(",
    closing_fence=")",
    enclosures={},
    grid=Grid(", ", ", ", "[{}]", row="[{}]"),
    case_grid=Grid(" if ", " else ", "{}"),
    condition="{}",
    otherwise="",
)

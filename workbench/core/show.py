"""How the objects of the waist show themselves in a notebook."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape

import casadi as ca

from workbench.core.layout import Layout
from workbench.notation import mathml
from workbench.notation.formula import Formula, Relation, symbol
from workbench.notation.normal_form import NotInClass, to_formula
from workbench.notation.reader import read


def formula_of(expression: ca.SX, names: Mapping[str, str]) -> Formula:
    """An expression as one prints it: in its textbook form where it has one, as it stands elsewhere."""
    symbols = {name: symbol(printed) for name, printed in names.items()}
    try:
        return to_formula(expression, symbols)
    except NotInClass:
        return read(expression, symbols)


def matrices_to_html(matrices: Mapping[str, ca.SX], names: Mapping[str, str]) -> str:
    """Display equations `M = ...`, one a matrix, in MathML."""
    return "\n".join(
        mathml.emit(Relation(symbol(letter), "=", formula_of(matrix, names))) for letter, matrix in matrices.items()
    )


def layouts_to_html(title: str, layouts: Mapping[str, Layout]) -> str:
    """One table of names, shapes, units and values for each layout."""
    rows = [
        f"<tr><td>{escape(kind)}</td><td><code>{escape(e.name)}</code></td><td>{e.shape or ''}</td>"
        f"<td>{escape(e.unit)}</td><td>{escape(str(e.default.tolist()))}</td></tr>"
        for kind, layout in layouts.items()
        for e in layout.entries
    ]
    head = "<tr><th>kind</th><th>name</th><th>shape</th><th>unit</th><th>value</th></tr>"
    return f"<table><caption>{escape(title)}</caption>{head}{''.join(rows)}</table>"

"""How the objects of the waist show themselves in a notebook."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
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
    """One table of names, letters, values and units for each layout."""
    rows = [
        (kind, entry.name, letters(entry.symbol or entry.name.rpartition(".")[2]), entry.default.tolist(), entry.unit)
        for kind, layout in layouts.items()
        for entry in layout.entries
    ]
    return table_to_html(title, ("kind", "name", "letter", "value", "unit"), rows)


def letters(name: str) -> Markup:
    """A name of the code as the book's letter, in MathML within a line."""
    return Markup(mathml.emit(symbol(name), display=False))


def table_to_html(title: str, head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table whose cells are text, escaped, or markup that already is."""
    body = "".join(f"<tr>{''.join(f'<td>{_cell(cell)}</td>' for cell in row)}</tr>" for row in rows)
    top = "".join(f"<th>{escape(word)}</th>" for word in head)
    return f"<table><caption>{escape(title)}</caption><tr>{top}</tr>{body}</table>"


class Markup(str):
    """Text that is HTML already."""

    __slots__ = ()


def _cell(cell: object) -> str:
    return cell if isinstance(cell, Markup) else escape(str(cell))

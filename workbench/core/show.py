"""Printed forms of expressions and layouts: formulas, equations in MathML, and tables for a notebook."""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca

from workbench.core.layout import Layout
from workbench.notation import mathml
from workbench.notation.formula import Formula, Matrix, Relation, System, children, symbol
from workbench.notation.normal_form import NotInClass, to_formula
from workbench.notation.reader import read, read_shared
from workbench.notation.writer import measure
from workbench.validation.views import Markup, table_to_html

# A textbook form is expanded, so it is tried on small expressions only, and printed where no entry takes
# more than some five lines of a page, in widths of a digit.
MOST_NODES_OF_TEXTBOOKS, LONGEST_ENTRY = 2_000, 400.0


def formula_of(expression: ca.SX, names: Mapping[str, str]) -> Formula:
    """An expression as a formula, in its textbook form if it has one."""
    symbols = {name: symbol(printed) for name, printed in names.items()}
    try:
        return to_formula(expression, symbols)
    except NotInClass:
        return read(expression, symbols)


def equations_of(
    matrices: Mapping[str, ca.SX], names: Mapping[str, str]
) -> tuple[tuple[Relation, ...], list[Relation]]:
    """Matrices with equal numbers of rows in print: definitions of shared parts, and an equation for each matrix.

    If no entry in its textbook form is longer than `LONGEST_ENTRY`, that form is taken, and nothing is defined.
    """
    symbols = {name: symbol(printed) for name, printed in names.items()}
    together = ca.horzcat(*matrices.values())
    if ca.n_nodes(together) <= MOST_NODES_OF_TEXTBOOKS:
        try:
            formulas = [to_formula(matrix, symbols) for matrix in matrices.values()]
        except NotInClass:
            formulas = []
        entries = (entry for formula in formulas for entry in (children(formula) or (formula,)))
        if formulas and max(map(measure, entries)) <= LONGEST_ENTRY:
            return (), [Relation(symbol(letter), "=", x) for letter, x in zip(matrices, formulas, strict=True)]
    definitions, formula = read_shared(together, symbols)
    rows = formula.rows if isinstance(formula, Matrix) else ((formula,),)
    equations, start = [], 0
    for letter, matrix in matrices.items():
        stop = start + matrix.shape[1]
        equations.append(Relation(symbol(letter), "=", Matrix(tuple(row[start:stop] for row in rows))))
        start = stop
    return definitions, equations


def matrices_to_html(matrices: Mapping[str, ca.SX], names: Mapping[str, str]) -> str:
    """Display equations `M = ...`, one a matrix, in MathML, after the definitions of the parts that they share."""
    definitions, equations = equations_of(matrices, names)
    first = [mathml.emit(System(definitions))] if definitions else []
    return "\n".join([*first, *map(mathml.emit, equations)])


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

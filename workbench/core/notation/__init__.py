"""Equations on paper: expressions of CasADi read as formulas, proved equal, and written in four markups.

This package takes expressions and formulas, and knows no model. Read `formula` first, then `reader` (from CasADi to a
formula), `normal_form` (exact proofs of equality) and `writer` (signs and parentheses for every markup).

Examples
--------
>>> wb.notation.symbol("q_1").letter
'q'
"""

from workbench.core.notation.formula import (
    Formula,
    Number,
    Power,
    Product,
    Quotient,
    Relation,
    Symbol,
    entry_symbol,
    symbol,
)
from workbench.core.notation.program import walk
from workbench.core.notation.reader import formula_of

__all__ = [
    "Formula",
    "Number",
    "Power",
    "Product",
    "Quotient",
    "Relation",
    "Symbol",
    "entry_symbol",
    "formula_of",
    "symbol",
    "walk",
]

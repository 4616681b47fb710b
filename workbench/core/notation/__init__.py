"""Printed equations: CasADi expressions become formulas, which are compared exactly and written in four markups.

This package has expressions and formulas, and no models. Read `formula` first, then `reader` (from CasADi to a
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
from workbench.core.notation.loop_recursions import formula_of
from workbench.core.notation.program import walk

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

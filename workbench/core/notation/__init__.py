"""Equations on paper: expressions of CasADi read as formulas, proved equal, and written in four markups.

The room knows expressions and formulas, but no model. Read `formula` first, then `reader` (from CasADi to a formula),
`normal_form` (exact proofs of equality) and `writer` (signs and parentheses for every markup).
"""

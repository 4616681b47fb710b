"""Proofs by computer: interval and rational arithmetic, certified extremes and eigenvalues over boxes.

The room knows expressions of CasADi and boxes of their symbols, and nothing of loops or papers. Read `interval` first,
then `bounds`.
"""

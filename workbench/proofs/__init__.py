"""Proofs by computer, and claims about closed loops with their verdicts.

Interval and rational arithmetic bound expressions and eigenvalues over boxes; a claim is searched within stated bounds
for a run that breaks it. The room knows equations, and nothing of arms or papers. Read `interval.py` first, then
`bounds.py` and `falsify.py`.
"""

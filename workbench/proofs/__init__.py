"""Proofs by computer, and claims about closed loops with their verdicts.

Interval and rational arithmetic bound expressions and eigenvalues over boxes. A search within stated bounds looks for a
run that refutes a claim. This package knows equations, and nothing of arms or papers. Read `interval.py` first, then
`bounds.py` and `falsify.py`.

Examples
--------
>>> wb.proofs.bound_text(1.23456, 1)
'1.23456'
"""

from workbench.core.lazy_names import lazy_names

_FILES = {
    "bounds": "disturbance_bounds bound_text",
    "claim_ledger": "BREAKING_KINDS WITNESS_KINDS Check Kind ClaimLedger ClaimEntry Quantifier Ruling",
    "claim_margins": "SignalsOf derivative violation with_violations",
    "counterexample": "CounterExample StepPair hypotheses_kept in_reference_mode",
    "equality": "judge_equal",
    "falsify": "Budget SearchResult RunSearch",
    "interval": "guarantee",
    "rest_points": "RestPoint growing_modes rest_point",
}
__all__, __getattr__, __dir__ = lazy_names(__name__, _FILES)

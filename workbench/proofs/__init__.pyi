"""The room for editors and mypy: each of its names, and the file that it comes from."""

from workbench.proofs.bounds import bound_text, disturbance_bounds
from workbench.proofs.claim_ledger import (
    BREAKING_KINDS,
    WITNESS_KINDS,
    Check,
    ClaimEntry,
    ClaimLedger,
    Kind,
    Quantifier,
    Ruling,
)
from workbench.proofs.claim_margins import SignalsOf, derivative, violation, with_violations
from workbench.proofs.counterexample import CounterExample, StepPair, hypotheses_kept, in_reference_mode
from workbench.proofs.equality import judge_equal
from workbench.proofs.falsify import Budget, RunSearch, SearchResult
from workbench.proofs.interval import guarantee
from workbench.proofs.rest_points import RestPoint, growing_modes, rest_point

__all__ = [
    "BREAKING_KINDS",
    "Budget",
    "Check",
    "ClaimEntry",
    "ClaimLedger",
    "CounterExample",
    "Kind",
    "Quantifier",
    "RestPoint",
    "Ruling",
    "RunSearch",
    "SearchResult",
    "SignalsOf",
    "StepPair",
    "WITNESS_KINDS",
    "bound_text",
    "derivative",
    "disturbance_bounds",
    "growing_modes",
    "guarantee",
    "hypotheses_kept",
    "in_reference_mode",
    "judge_equal",
    "rest_point",
    "violation",
    "with_violations",
]

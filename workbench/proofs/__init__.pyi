"""The room for editors and mypy: each of its names, and the file that it comes from."""

from workbench.proofs.bounds import disturbance_bounds, shown
from workbench.proofs.claim_ledger import BROKEN, WITNESSED, Check, Kind, Ledger, Line, Quantifier, Ruling
from workbench.proofs.claim_margins import SignalsOf, derivative, violation, watching
from workbench.proofs.counterexample import CounterExample, Pair, hypotheses_kept, in_reference_mode
from workbench.proofs.equality import judge_equal
from workbench.proofs.falsify import Budget, Found, Hunt
from workbench.proofs.interval import guarantee
from workbench.proofs.rest_points import RestPoint, growing_modes, rest_point

__all__ = [
    "BROKEN",
    "Budget",
    "Check",
    "CounterExample",
    "Found",
    "Hunt",
    "Kind",
    "Ledger",
    "Line",
    "Pair",
    "Quantifier",
    "RestPoint",
    "Ruling",
    "SignalsOf",
    "WITNESSED",
    "derivative",
    "disturbance_bounds",
    "growing_modes",
    "guarantee",
    "hypotheses_kept",
    "in_reference_mode",
    "judge_equal",
    "rest_point",
    "shown",
    "violation",
    "watching",
]

from __future__ import annotations

import tempfile
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from workbench.arms import identity_proofs, properties
from workbench.arms.dynamics import Dynamics
from workbench.arms.mechanics import robot
from workbench.arms.paper_equations import (
    arm_letters,
    printed_equations,
)
from workbench.arms.paper_equations import entry_comparison as printed  # fmt: skip
from workbench.cli import printed_comparison
from workbench.core import Claim
from workbench.core.claim import BlockClaim
from workbench.core.notation.program import walk
from workbench.engine.metrics.contract import Integral
from workbench.proofs import (
    bounds,
    claim_margins,
    counterexample,
    differential_evolution,
    equality,
    exact_arithmetic,
    falsify,
    interval,
    rest_points,
)
from workbench.proofs import claim_ledger as claims

from ..parts import ODE

ARM = Dynamics.of(robot("planar-1r"), "planar-1r")
X = ca.SX.sym("x", 2)
WAVE = ca.sin(X[0]) * X[1]
MATRIX = ca.blockcat([[2 + ca.cos(X[0]), 0.5], [0.5, X[1]]])
SHEET = "M_11 = m_1*c_1^2 + 2*I_1\nG_1 = m_1*g*c_1*cos(q_1)"
STAYS = Claim("it stays", "x stays below 2.", "a book", (), lambda signals: 2 - signals["x"])
WORTH = Integral("size", "s", "integral of |y|", lambda t, y: ca.fabs(y["y"]), lambda whole, until: whole, ("y",))
FALLS = Claim("it falls", "x' is never positive.", "a book", (), lambda signals: -signals["x'"])
RANGES = {"x": (0.5, 1.0), "k": (1.0, 2.0)}
FOLDER = Path(tempfile.mkdtemp())
(FOLDER / "sheet.txt").write_text(SHEET, encoding="utf-8")


def calls() -> dict[str, Any]:
    return {**_of_claims(), **_of_bounds(), **_of_sheets()}


def _of_claims() -> dict[str, Any]:
    hunt = falsify.RunSearch(ODE, BlockClaim(STAYS), RANGES, 0.2, 0.05)
    example = hunt.search(1, falsify.Budget(4, 1, 1)).worst
    assert example is not None
    example.write(FOLDER / "example.json")
    looked, row = claim_margins.Box.of(ODE, RANGES), (np.array([[2.0]]), np.array([[1.0]]))
    violated, watched = claim_margins.violation(STAYS), claim_margins.with_violations(ODE, [BlockClaim(STAYS)])
    ruling = claims.Ruling("refuted", "it fails", "here")
    return {
        "slope_of": partial(claim_margins.slope_of, watched, violated, looked, np.array([0.5, 0.5]), 0.2, 0.05),
        "Box.of": partial(claim_margins.Box.of, ODE, RANGES),
        "Ruling": partial(claims.Ruling, "not refuted", "seen", "", 3),
        "Line": partial(claims.ClaimEntry, STAYS, ruling),
        "Ledger": partial(claims.ClaimLedger, (claims.ClaimEntry(STAYS, ruling),)),
        "ClaimLedger.of": partial(claims.ClaimLedger.of, [(STAYS, lambda: ruling)]),
        "CounterExample": partial(counterexample.CounterExample, **vars(example)),
        "CounterExample.read": partial(counterexample.CounterExample.read, FOLDER / "example.json"),
        "run": partial(counterexample.run, watched, violated, (), *row, 0.2, 0.05),
        "in_reference_mode": partial(counterexample.in_reference_mode, ODE, "y", row[0][0], row[1][0], [0.0, 0.1]),
        "hypotheses_kept": partial(counterexample.hypotheses_kept, ODE, [BlockClaim(STAYS)], 0.2, 0.05),
        "Budget": partial(falsify.Budget, 8, 2, 1),
        "Hunt": partial(falsify.RunSearch, ODE, BlockClaim(STAYS), RANGES, 0.2, 0.05, (BlockClaim(FALLS),)),
        "Hunt of a metric": partial(falsify.RunSearch, ODE, WORTH, RANGES, 0.2, 0.05),
        "RunSearch.search": partial(hunt.search, 1, falsify.Budget(4, 1, 1)),
        "SignalsOf": partial(claim_margins.SignalsOf, ODE, "plant."),
        "derivative": partial(claim_margins.derivative, ODE, ODE.x**2),
        "Largest": partial(claim_margins.Largest, "largest y", "m", "the largest y", "y"),
        "rest_point": partial(rest_points.rest_point, ODE, np.array([0.1])),
        "growing_modes": partial(rest_points.growing_modes, ODE, {"x": Fraction(0)}),
    }


def _of_bounds() -> dict[str, Any]:
    edge = [-1.0, -1.0], [1.0, 1.0]
    return {
        "disturbance_bounds": partial(bounds.disturbance_bounds, ca.sin(X[0]), X[0], 1.0),
        "enclose": partial(bounds.enclose, WAVE, X, *edge, tolerance=1e-3, boxes=100, numbers={}),
        "extreme_eigenvalue": partial(bounds.extreme_eigenvalue, MATRIX, X, *edge, 1, tolerance=1e-3, boxes=100),
        "largest_norm": partial(bounds.largest_norm, X, X, *edge),
        "guarantee": partial(bounds.guarantee),
        "shown": partial(bounds.bound_text, 0.1, 1),
        "judge_equal": partial(equality.judge_equal, X, 2 * X),
        "Judged": partial(differential_evolution.TrialValues, np.ones(4), np.zeros(4)),
        "evolve": partial(
            differential_evolution.evolve,
            lambda u: differential_evolution.TrialValues(u[:, 0], u[:, 0] - 2),
            1,
            4,
            2,
            np.random.default_rng(1),
        ),
        "exact_values": partial(exact_arithmetic.exact_values, X**2, {"x_0": Fraction(1), "x_1": Fraction(2)}),
        "characteristic_polynomial": partial(exact_arithmetic.characteristic_polynomial, [[Fraction(1)]]),
        "unstable_modes": partial(exact_arithmetic.unstable_modes, [Fraction(1), Fraction(-2)]),
        "evaluate": partial(
            interval.evaluate, walk(WAVE), dict.fromkeys(("x_0", "x_1"), interval.Interval(np.zeros(1), np.ones(1)))
        ),
        "jumps": partial(interval.jumps, walk(WAVE), ["x_0"]),
    }


def _of_sheets() -> dict[str, Any]:
    read = printed_equations.read_sheet(SHEET, ARM, "text")
    seen = identity_proofs.candidates(ARM)[0]
    return {
        "findings": partial(printed_comparison.findings, FOLDER / "sheet.txt", ARM),
        "narrowed": partial(_narrowed, ARM, {"links[0].mass": 2.0}),
        "judge_zero": partial(identity_proofs.judge_zero, ARM.M - ARM.M.T, ARM.M, ARM),
        "compare_sheet": partial(printed.compare_sheet, read, ARM),
        "judged": partial(printed.entry_verdicts, {("M", 1, 1): ca.SX(1)}, ARM),
        "symmetric": partial(properties.symmetric, ARM),
        "skew": partial(properties.skew, ARM),
        "positive_definite": partial(properties.positive_definite, ARM, -1.0, 1.0),
        "eigenvalues_along": partial(properties.eigenvalues_along, ARM, 1, np.zeros(3)),
        "read_sheet": partial(printed_equations.read_sheet, SHEET, ARM, "text"),
        "eigenvalues": partial(properties.eigenvalues, ARM, np.zeros((3, 1))),
        "Witness": partial(identity_proofs.Witness, seen.q, seen.qd, seen.p, {"links[0].mass": 2.0}),
        "candidates": partial(identity_proofs.candidates, ARM),
        "search": partial(identity_proofs.search, ARM.M, ARM.M, ARM),
    }


def _narrowed(dynamics: Any, fixed: Any) -> None:
    """What it gives is of `core`, where it is called too."""
    arm_letters.fix_parameters(dynamics, fixed)


def arguments() -> dict[str, Any]:
    return {
        "Box.at.u": lambda search_box: np.array([[0.5, 0.5]]),
        "Box.rows.theta": lambda search_box: np.array([[0.5, 1.5]]),
        "Box.of.ranges": lambda search_box: RANGES,
        "ode": lambda thing: ODE,
        "horizon": lambda metric: 1.0,
        "ClaimLedger.count.kind": lambda ledger: "refuted",
        "ClaimLedger.of.checks": lambda ledger: [],
        "name": lambda ledger: "it stays",
        "CounterExample.write.path": lambda example: FOLDER / "written.json",
        "CounterExample.read.path": lambda example: FOLDER / "example.json",
        "metric": lambda example: WORTH,
        "RunSearch.search.seed": lambda hunt: 1,
        "RunSearch.at.numbers": lambda hunt: {"x": 0.7},
        "RunSearch.shorten.result": lambda hunt: hunt.search(1, falsify.Budget(4, 1, 1)),
        "RunSearch.replay.example": lambda hunt: counterexample.CounterExample.read(FOLDER / "example.json"),
        "Largest.memory.size": lambda metric: 1,
        "Largest.update.k": lambda metric: X[0],
        "Largest.update.h": lambda metric: X[0],
        "Largest.update.z": lambda metric: {"largest": X[0]},
        "y": lambda metric: {metric.signal: X[0]},
        "Largest.value.integral": lambda metric: np.zeros((1, 0)),
        "Largest.value.z": lambda metric: {"largest": np.ones((1, 1))},
        "t": lambda metric: X[0],
        "key": lambda signals: "x",
        **{name: lambda thing: [0.1] for name in ("q", "qd", "qdd", "tau", "x")},
        "Ode.rate_at.t": lambda ode: 0.0,
        "Ode.outputs_at.t": lambda ode: 0.0,
    }

"""The exam of the differential Riccati equation, and its case with varying coefficients, which no grader asks for."""

from __future__ import annotations

from typing import Any

import numpy as np

from workbench.design.riccati_flow import fpre

from .graders import Loaded

SHARE = 1e2  # of the 1e3 rtol that the exam allows, what is asked for; the rest is the exam's own rounding


def solve(A: Any, G: Any, Q: Any, P0: Any, times: Any, rtol: float) -> Any:
    """P (N, n, n) at the times, from P0 at time 0; G as B B'."""
    w, V = np.linalg.eigh(np.asarray(G, dtype=float))
    if w[0] < -1e-12 * abs(w).max():
        raise ValueError(f"`fpre(...)` takes G = B R^-1 B', which is semidefinite; its least eigenvalue is {w[0]:g}.")
    B = V * np.sqrt(np.maximum(w, 0))
    return fpre(A, B, Q, np.eye(len(w)), P0, [0.0, *times], rtol=SHARE * rtol).P[1:]


def dre(exam: Loaded) -> tuple[bool, str]:
    """The forward Riccati equation in every case, and its refusal past a finite escape."""
    report = exam.module.grade_dre(solve)
    cases = report["cases"]
    solved = [case for case in cases if "error" in case]
    passed = sum(case["outcome"] == "pass" for case in cases)
    worst = max((case["error"] for case in solved), default=np.nan)
    return bool(report["passed"]) and len(solved) > 0, f"{passed} of {len(cases)}, worst relative error {worst:.1e}"

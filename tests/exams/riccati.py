"""The exams of algebraic Riccati and Lyapunov equations, and of what must be refused."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from workbench.design.riccati import care, dare, discrete_lyapunov, lyapunov

from .graders import Loaded

REFUSALS_ALLOWED = 3  # of 60 continuous equations, one of which has no answer


def continuous(exam: Loaded) -> tuple[bool, str]:
    """`care` on benchmark equations: none wrong, and nearly all solved."""
    report = exam.module.grade_care(lambda A, B, Q, R: care(A, B, Q, R).X)
    return _figure(report, REFUSALS_ALLOWED / 60)


def discrete(exam: Loaded) -> tuple[bool, str]:
    """`dare` on benchmark equations: all solved."""
    return _figure(exam.module.grade_dare(lambda A, B, Q, R, S: dare(A, B, Q, R, S).X), 0)


def linear(exam: Loaded) -> tuple[bool, str]:
    """`lyapunov` and `discrete_lyapunov`, by A'XE + E'XA = Y and A'XA - E'XE = Y: all solved."""

    def transposed(solve: Callable[..., Any]) -> Callable[[Any, Any, Any], Any]:
        return lambda A, Y, E: solve(A.T, -Y, None if E is None else E.T).X

    return _figure(exam.module.grade_lyap(transposed(lyapunov), transposed(discrete_lyapunov)), 0)


def bad(exam: Loaded) -> tuple[bool, str]:
    """What `care` must refuse: all of it, in a sentence."""
    report = exam.module.grade_bad_inputs(lambda A, B, Q, R: care(A, B, Q, R).X)
    refused = report["counts"].get("refused", 0)
    others = [case["id"] for case in report["cases"] if case["outcome"] != "refused"]
    text = f"{refused} of {report['total']} refused"
    return bool(
        report["passed"]
    ) and not others and refused > 0, f"{text}; not: {', '.join(others)}" if others else text


def _figure(report: dict[str, Any], allowed: float) -> tuple[bool, str]:
    """Solved of all, refused, wrong, and the worst forward error over the one allowed."""
    counts, total = report["counts"], report["total"]
    solved, refused = counts.get("solved", 0), counts.get("refused", 0)
    shares = [case["forward"] / case["forward_tol"] for case in report["cases"] if "forward_tol" in case]
    worst = f", worst error {max(shares):.1g} of its limit" if shares else ""
    slowest = max(report["cases"], key=lambda case: float(case["seconds"]), default={"n": 0, "seconds": 0.0})
    text = f"{solved} of {total} solved, {refused} refused, {total - solved - refused} wrong{worst}"
    text += f"; n = {slowest['n']} in {slowest['seconds']:.1f} s"
    failed = [case["id"] for case in report["cases"] if case["outcome"] not in ("solved", "refused")]
    text += f"; failed: {', '.join(failed)}" if failed else ""
    return not failed and solved >= (1 - allowed) * total > 0, text


PARTS: dict[str, tuple[str, Callable[[Loaded], tuple[bool, str]]]] = {
    "grade_care": ("care", continuous),
    "grade_dare": ("dare", discrete),
    "grade_lyap": ("lyapunov", linear),
    "grade_bad_inputs": ("bad inputs", bad),
}

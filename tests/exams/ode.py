"""The exams of simulation: smooth problems, the order of a step, jumps, and what a batch may not change."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import numpy as np

from workbench.core import Ode, rk4
from workbench.engine import simulate
from workbench.engine.reference import reference_of_function, reference_run

from .graders import Loaded
from .tracing import Rate, UntraceableError, chooses, trace

RK4_ORDER = 4


class Candidate:
    """The workbench, as the graders call it: with plain functions f(t, x)."""

    def __init__(self, exam: Loaded) -> None:
        self.exam = exam
        self.odes: dict[int, tuple[Rate, Ode | UntraceableError]] = {}
        self.refusals: list[str] = []

    def ode(self, f: Rate, x0: Any) -> Ode:
        """The function as an `Ode`, traced once."""
        if id(f) not in self.odes:
            try:
                self.odes[id(f)] = f, trace(f, x0, self.exam.modules)
            except UntraceableError as reason:
                self.odes[id(f)] = f, reason
        found = self.odes[id(f)][1]
        if isinstance(found, UntraceableError):
            raise found
        return found

    def integrate(self, f: Rate, x0: Any, times: Any, rtol: float, atol: float) -> Any:
        """The reference mode, (N, n)."""
        try:
            try:
                return reference_run(self.ode(f, x0), x0=x0, times=times, rtol=rtol, atol=atol).x
            except (UntraceableError, ValueError) as refusal:
                if isinstance(refusal, ValueError) and not chooses(self.ode(f, x0)):
                    raise
                return reference_of_function(f, x0, times=times, rtol=rtol, atol=atol).x
        except ValueError as refusal:
            self.refusals.append(str(refusal))
            raise

    def fixed(self, f: Rate, x0: Any, t1: float, n: int) -> Any:
        """x(t1) by n steps of RK4 on the batch engine."""
        try:
            return simulate(rk4(self.ode(f, x0), t1 / n), x0=x0, until=t1, every=t1).x[0, -1]
        except (UntraceableError, ValueError) as refusal:
            self.refusals.append(str(refusal))
            raise

    def sim(self, f: Rate, x0: Any, t1: float, h: float, name: str) -> tuple[Any, Any]:
        """Times and states of every step of RK4; not a number where there is no graph to step with."""
        try:
            runs = simulate(rk4(self.ode(f, x0), t1 / round(t1 / h)), x0=x0, until=t1)
        except (UntraceableError, ValueError) as refusal:
            self.refusals.append(f"{name}: {refusal}")
            return np.zeros(1), np.full((1, np.size(x0)), np.nan)
        return runs.t, runs.x[0]

    def batch(self, x0s: Any, t1: float, n: int) -> Any:
        """x(t1) of many runs; a start that is not finite is refused by `simulate`, and has no end."""
        x0s = np.asarray(x0s, dtype=float)
        finite = np.isfinite(x0s).all(axis=1)
        ode = self.ode(self._batch_problem(x0s.shape[1]), x0s[finite][0])
        ends = np.full(x0s.shape, np.nan)
        ends[finite] = simulate(rk4(ode, t1 / n), x0=x0s[finite], until=t1, every=t1).x[:, -1]
        return ends

    def _batch_problem(self, states: int) -> Rate:
        """The problem that the grader's own text names for batches, else the first smooth one of as many states."""
        for f, _ in self.odes.values():
            return f
        text = f"{self.exam.module.__doc__}\n{self.exam.module.grade_batch.__doc__}"
        lines = [line for line in text.splitlines() if "batch" in line]
        for module in self.exam.modules:
            space = getattr(module, "NP", None)
            for name in re.findall(r"'(\w+)'", "\n".join(lines)):
                if space is not None and callable(getattr(module, name, None)):
                    return _as_rate(getattr(module, name)(space))
        for _, f, x0, *_ in self.exam.module.smooth():
            if len(x0) == states:
                return _as_rate(f)
        raise UntraceableError(f"the grader names no problem of {states} states for a batch")


def _as_rate(f: Any) -> Rate:
    rate: Rate = f
    return rate


def smooth(exam: Loaded) -> tuple[bool, str]:
    """The reference mode at several tolerances."""
    candidate = Candidate(exam)
    report = exam.module.grade_adaptive(candidate.integrate)
    worst = [_share(case.get("errors"), case.get("limits")) for case in report["cases"]]
    return _figure(report, candidate, f"worst error {_most(worst)} of its limit")


def order(exam: Loaded) -> tuple[bool, str]:
    """RK4 on the batch engine, its step halved again and again."""
    candidate = Candidate(exam)
    report = exam.module.grade_order(candidate.fixed, RK4_ORDER)
    off = [abs(case.get("order", np.nan) - RK4_ORDER) for case in report["cases"]]
    return _figure(report, candidate, f"worst order {_most(off)} from {RK4_ORDER}")


def discontinuous(exam: Loaded) -> tuple[bool, str]:
    """RK4 on the batch engine across jumps, where any fixed step is of first order."""
    candidate = Candidate(exam)
    report = exam.module.grade_discontinuous(candidate.sim)
    worst = [
        max(_share([value], [case["bound"]]) for value in case["dev_over_h"])
        for case in report["cases"]
        if "bound" in case
    ]
    return _figure(report, candidate, f"worst deviation {_most(worst)} of its bound")


def batch(exam: Loaded) -> tuple[bool, str]:
    """The batch engine, permuted, cut, and beside runs that diverge."""
    report = exam.module.grade_batch(Candidate(exam).batch)
    differences = report.get("diffs", {})
    same = sum(value == 0 for value in differences.values())
    return bool(report["passed"]) and len(differences) > 0, f"{same} of {len(differences)} bit-identical"


def _share(values: Any, limits: Any) -> float:
    """The largest part of its limit that a value takes; limits beyond 1 say nothing, and do not count."""
    pairs = [(v, limit) for v, limit in zip(values or [], limits or [], strict=False) if limit <= 1 or len(limits) == 1]
    return max((v / limit for v, limit in pairs), default=np.nan)


def _most(values: list[float]) -> str:
    finite = [value for value in values if np.isfinite(value)]
    return f"{max(finite):.2g}" if finite else "unknown"


def _figure(report: dict[str, Any], candidate: Candidate, figure: str) -> tuple[bool, str]:
    cases = report["cases"]
    failed = [case["id"] for case in cases if case["outcome"] != "pass"]
    text = f"{len(cases) - len(failed)} of {len(cases)}, {figure}"
    if failed:
        text += f"; failed: {', '.join(failed)}"
        text += f" ({candidate.refusals[0]})" if candidate.refusals else ""
    return bool(report["passed"]) and len(cases) > 0, text  # nothing asked is nothing shown


PARTS: dict[str, tuple[str, Callable[[Loaded], tuple[bool, str]]]] = {
    "grade_adaptive": ("smooth", smooth),
    "grade_order": ("order", order),
    "grade_discontinuous": ("discontinuous", discontinuous),
    "grade_batch": ("batch", batch),
}

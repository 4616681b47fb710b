"""The exam of sensitivity: Sobol indices with their intervals, Morris's effects, and outputs that have neither."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.engine.distributions import AbstractDistribution, LogNormal, Normal, Triangular, Uniform
from workbench.study.uncertainty import AbstractDesign, MorrisDesign, SobolDesign, morris, sobol

from .graders import Loaded

Function = Callable[[Array], Array]

# An exam's distributions by their names there: of a triangle it gives the ends and then the mode.
SPREADS: dict[str, Callable[..., AbstractDistribution]] = {
    "unif": Uniform,
    "norm": Normal,
    "lognorm": lambda mu, sigma: LogNormal(float(np.exp(mu)), sigma),
    "triang": lambda low, high, mode: Triangular(low, mode, high),
}


def outputs(f: Function, dists: Any, design: AbstractDesign) -> Array:
    """The function at the points of a design."""
    spreads = [SPREADS[name](*numbers) for name, *numbers in dists]
    return f(np.stack([s.quantile(u) for s, u in zip(spreads, design.points().T, strict=True)], axis=1))


def run_sobol(f: Function, dists: Any, N: int, seed: int) -> dict[str, Any]:
    """The indices as the graders ask for them; other base sizes than powers of two are rounded up."""
    design = SobolDesign(len(dists), 1 << max(3, (N - 1).bit_length()), second_order=True, seed=seed)
    found = sobol(design, outputs(f, dists, design))["output 1"]
    assert found.S2 is not None
    return {
        "S1": found.S1.value.tolist(),
        "ST": found.ST.value.tolist(),
        "S1_conf": found.S1.half.tolist(),
        "ST_conf": found.ST.half.tolist(),
        "S2": {pair: float(value) for pair, value in zip(found.pairs, found.S2.value, strict=True)},
        "S2_conf": {pair: float(half) for pair, half in zip(found.pairs, found.S2.half, strict=True)},
        "warnings": list(found.remarks),
    }


def run_morris(f: Function, dists: Any, r: int, levels: int, seed: int) -> dict[str, Any]:
    """The effects as the graders ask for them."""
    design = MorrisDesign(len(dists), r, levels, seed)
    found = morris(design, outputs(f, dists, design))["output 1"]
    return {key: getattr(found, key).value.tolist() for key in ("mu", "mu_star", "sigma")}


def indices(exam: Loaded) -> tuple[bool, str]:
    """First-order and total indices against exact ones."""
    report = exam.module.grade_sobol(run_sobol)
    cases = report["cases"]
    worst = max((max(case["err_S1"], case["err_ST"]) / case["tol"] for case in cases), default=float("nan"))
    return _figure(report, cases, f"worst error {worst:.2g} of its limit")


def convergence(exam: Loaded) -> tuple[bool, str]:
    """The power of N with which errors fall."""
    report = exam.module.grade_convergence(run_sobol)
    return bool(report["passed"]), f"errors fall like N^{report['slope']:.2f}"


def coverage(exam: Loaded) -> tuple[bool, str]:
    """How many intervals hold the truth."""
    report = exam.module.grade_coverage(run_sobol)
    return bool(report["passed"]), f"{100 * report['coverage']:.1f} % of the intervals hold the truth"


def effects(exam: Loaded) -> tuple[bool, str]:
    """Morris's mu, mu* and sigma against those of all effects there are."""
    report = exam.module.grade_morris(run_morris)
    cases = report["cases"]
    worst = max((case["worst_in_limits"] for case in cases if "worst_in_limits" in case), default=float("nan"))
    return _figure(report, cases, f"worst deviation {worst:.2g} of its limit")


def edges(exam: Loaded) -> tuple[bool, str]:
    """Outputs that have no indices."""
    report = exam.module.grade_edges(run_sobol)
    return _figure(report, report["cases"], "refused or flagged", ("refused", "flagged"))


def _figure(report: Any, cases: Any, said: str, good: tuple[str, ...] = ("pass",)) -> tuple[bool, str]:
    kept = [case for case in cases if case["outcome"] in good]
    missed = [str(case["id"]) for case in cases if case["outcome"] not in good]
    failed = f"; failed: {', '.join(missed)}" if missed else ""
    return bool(report["passed"]) and len(cases) > 0, f"{len(kept)} of {len(cases)}, {said}{failed}"


# Each part by the grader's function, with the name under which it is told.
PARTS = {
    "grade_sobol": ("indices", indices),
    "grade_convergence": ("convergence", convergence),
    "grade_coverage": ("coverage", coverage),
    "grade_morris": ("effects", effects),
    "grade_edges": ("edges", edges),
}

"""The kind 'sampled' of the design exam: loops behind a hold, and several periods over their common one."""

from __future__ import annotations

from typing import Any

import control
import numpy as np

from workbench.core.validation.refusals import seconds
from workbench.design.frequency.hold_loop import hold_loop
from workbench.design.frequency.multirate import lift_rates

TRUSTED = 1e-9  # relative error of an answer that may be given


def solve(case: dict[str, Any]) -> dict[str, Any]:
    """The results of one case by their names; what the workbench refuses is raised."""
    return {"loop": _hold_loop, "multirate": _multirate}[case["what"]](case)


def _hold_loop(case: dict[str, Any]) -> dict[str, Any]:
    plant = _system(*(case[name] for name in "ABC"), None)
    law = _system(*(case[name] for name in ("Ak", "Bk", "Ck", "Dk")), case["period"])
    loop = hold_loop(plant, law, case["delay"])
    answers = loop.response(case["frequencies"])
    results = {"poles": _pairs(loop.poles.values)}
    for name in ("loop", "between"):
        values, error = getattr(answers, name)[:, 0, 0], getattr(answers, f"{name}_error")[:, 0, 0]
        size = np.maximum(np.abs(values), 1e-3 * np.abs(values).max())
        if (error > TRUSTED * size).any():
            raise ValueError(f"The '{name}' of this case is known to {(error / size).max():.1e} only.")
        results[name] = _pairs(values)
    return results


def _multirate(case: dict[str, Any]) -> dict[str, Any]:
    plant = _system(case["A"], np.hstack(case["B"]), np.vstack(case["C"]), None)
    laws = [_system(*(law[name] for name in "ABCD"), h) for law, h in zip(case["laws"], case["periods"], strict=True)]
    lifted = lift_rates(plant, laws)
    return {"poles": _pairs(lifted.poles.values), "period": lifted.period}


def _system(A: Any, B: Any, C: Any, D: Any, period: float | None = None) -> control.StateSpace:
    """A system of python-control, in continuous time without a period; one without states has only D."""
    period = 0 if period is None else seconds("period", period)
    if not np.size(A):
        return control.ss([], [], [], np.array(D, float), period)
    A, B, C = (np.array(matrix, float) for matrix in (A, B, C))
    return control.ss(A, B, C, np.zeros((len(C), B.shape[1])) if D is None else np.array(D, float), period)


def _pairs(values: Any) -> list[list[float]]:
    return [[float(value.real), float(value.imag)] for value in values]

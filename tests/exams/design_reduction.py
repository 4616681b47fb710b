"""The kind `reduction` of the design exam, as the workbench answers it."""

from __future__ import annotations

from typing import Any

import control
import numpy as np

from workbench.design.matrices import DesignError
from workbench.design.reduction import balanced_truncation, hankel_values


def solve(case: dict[str, Any]) -> dict[str, Any]:
    """Hankel values, error and bound of a balanced truncation; an order that cuts equal values has the values alone."""
    A, B, C, D = (np.array(case[name], dtype=float) for name in "ABCD")
    system = control.ss(A, B, C, D, case["dt"] or 0, remove_useless_states=False)
    hankel = hankel_values(system)
    results: dict[str, Any] = {"hankel": hankel.values}
    try:
        model = balanced_truncation(system, case["order"])
    except DesignError:
        return results
    return results | {"error": model.error.gain.value, "bound": model.bound}

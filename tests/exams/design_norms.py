"""The kinds `norms` and `zeros` of the design exam, as the workbench answers them."""

from __future__ import annotations

from typing import Any

import control
import numpy as np

from workbench.design.frequency import h2_norm, hinf_norm, pole_zero_structure


def solve(case: dict[str, Any]) -> dict[str, Any]:
    """The results that a case of these kinds wants."""
    system = _system(case)
    return _norms(case, system) if case["kind"] == "norms" else _zeros(system)


def _system(case: dict[str, Any]) -> control.StateSpace:
    """The `StateSpace` of a case; empty lists are matrices without rows or columns."""
    D = np.array(case["D"], dtype=float)
    (ny, nu), n = D.shape, len(case["A"])
    shapes = {"A": (n, n), "B": (n, nu), "C": (ny, n)}
    A, B, C = (np.array(case[name], dtype=float).reshape(shape) for name, shape in shapes.items())
    return control.ss(A, B, C, D, case["dt"] or 0, remove_useless_states=False)


def _norms(case: dict[str, Any], system: control.StateSpace) -> dict[str, Any]:
    if case["norm"] == "h2":
        return {"h2": h2_norm(system).gain.value}
    norm = hinf_norm(system)
    return {"hinf": norm.gain.value} | ({} if norm.reason else {"peak": norm.frequency})


def _zeros(system: control.StateSpace) -> dict[str, Any]:
    found = pole_zero_structure(system)
    results = {
        "poles": found.poles.values,
        "invariant_zeros": found.invariant_zeros.values,
        "transmission_zeros": found.transmission_zeros.values,
        "minimal_order": found.minimal_order,
        "normal_rank": found.normal_rank,
    }
    return results | ({} if found.relative_degree is None else {"relative_degree": found.relative_degree})

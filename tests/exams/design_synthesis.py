"""The kind `synthesis` of the design exam, as the workbench answers it."""

from __future__ import annotations

from typing import Any

import control
import numpy as np

from workbench.design.synthesis import (
    GeneralizedPlant,
    coprime_margin,
    hinf_controller,
    least_complementary_sensitivity,
    least_sensitivity,
)

MATRICES = ("A", "B1", "B2", "C1", "C2", "D11", "D12", "D21", "D22")


def solve(case: dict[str, Any]) -> dict[str, Any]:
    """The results that a case of this kind wants."""
    what = case["what"]
    if what == "bopt":
        A, B, C = (np.array(case[name], dtype=float) for name in ("A", "B", "C"))
        system = control.ss(A, B, C, np.zeros((len(C), B.shape[1])), remove_useless_states=False)
        return {"b_opt": coprime_margin(system).b_opt}
    if what == "hinf":
        found = hinf_controller(GeneralizedPlant(*(case[name] for name in MATRICES)), case.get("gamma"))
        K = found.controller
        return {
            "gamma": found.gamma.value,
            "low": found.gamma.low,
            "high": found.gamma.high,
            "K": (K.A, K.B, K.C, K.D),
        }
    least = least_sensitivity if what == "least_S" else least_complementary_sensitivity
    weight = case.get("weight")
    return {"gamma": least(case["num"], case["den"], weight and control.tf(weight["num"], weight["den"])).gamma}

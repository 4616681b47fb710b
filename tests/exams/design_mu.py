"""The kind `mu` of the design exam, as the workbench answers it."""

from __future__ import annotations

from typing import Any

import control
import numpy as np

from workbench.design.structured_uncertainty import (
    ComplexScalar,
    FullBlock,
    RealScalar,
    robustness_over_frequency,
    structured_singular_value,
)

BLOCKS = {"complex": FullBlock, "repeated": ComplexScalar, "real": RealScalar}


def solve(case: dict[str, Any]) -> dict[str, Any]:
    """Both bounds of a matrix, or of the supremum over frequency."""
    blocks = [BLOCKS[kind](size) for kind, size in case["blocks"]]
    if case["what"] == "peak":
        matrices = (np.array(case[name], dtype=float) for name in "ABCD")
        system = control.ss(*matrices, case.get("dt") or 0, remove_useless_states=False)
        peak = robustness_over_frequency(system, blocks)
        return {"lower": peak.lower, "upper": peak.upper}
    M = np.array(case["M_re"], dtype=float) + 1j * np.array(case["M_im"], dtype=float)
    bounds = structured_singular_value(M, blocks)
    return {"lower": bounds.lower, "upper": bounds.upper}

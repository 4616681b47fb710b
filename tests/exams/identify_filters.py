"""The kinds `filters` and `nees` of the identification exam, as the workbench answers them."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from workbench.core import layout
from workbench.identification.datasets import Dataset
from workbench.identification.filters import (
    DiscreteModel,
    FilterEstimate,
    StochasticModel,
    extended_kalman_filter,
    kalman_filter,
)


def solve(case: dict[str, Any]) -> dict[str, Any]:
    """States before and after the samples and by all of them, with their covariances and the log-likelihood."""
    estimate = _extended(case) if "f" in case else _linear(case)
    smooth = estimate.smooth()
    return {
        "x_pred": estimate.x_predicted,
        "P_pred": estimate.P_predicted,
        "x": estimate.x,
        "P": estimate.P,
        "log_likelihood": estimate.log_likelihood,
        "x_smooth": smooth.x,
        "P_smooth": smooth.P,
    }


def _linear(case: dict[str, Any]) -> FilterEstimate:
    B = np.array(case["B"], dtype=float)
    driven = {"B": B, "u": case["u"]} if B.size else {}
    matrices = (case[name] for name in "ACQR")
    return kalman_filter(case["y"], *matrices, x0=case["x0"], P0=case["P0"], **driven)


def _extended(case: dict[str, Any]) -> FilterEstimate:
    sizes = {"x": len(case["x0"]), "u": case["u"].shape[1], "y": case["y"].shape[1]}
    ports = [layout(**{name: ("?", np.zeros(size))}) for name, size in sizes.items()]
    model = DiscreteModel.of(*ports, lambda x, u: case["f"](x, u, ca), lambda x, u: case["h"](x, ca))
    log = Dataset.of(np.arange(len(case["y"]), dtype=float), {"y": case["y"], "u": case["u"]})
    return extended_kalman_filter(log, StochasticModel(model, *(case[name] for name in ("Q", "R", "x0", "P0"))))

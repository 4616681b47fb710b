"""The kind `loops` of the identification exam, and its replicates for coverage, as the workbench answers them."""

from __future__ import annotations

from typing import Any

import numpy as np

from workbench.identification.datasets import Dataset
from workbench.identification.linear_models import PolynomialStructure, polynomial_model


def solve(case: dict[str, Any]) -> dict[str, Any]:
    """Parameters and standard errors of a case, whose loop was at rest before the first sample."""
    orders = case["orders"]
    structure = PolynomialStructure(
        orders.get("a", 0), (orders["b"],), orders.get("c", 0), orders.get("d", 0), (orders.get("f", 0),), (1,)
    )
    log = Dataset.of(np.arange(len(case["y"]), dtype=float), {"u": case["u"], "y": case["y"]})
    model = polynomial_model(log, "u", "y", structure, offsets="none", initial="zero")
    return {"parameters": dict(model.parameters), "standard_errors": dict(model.standard_errors)}

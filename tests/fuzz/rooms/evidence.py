from __future__ import annotations

from functools import partial
from typing import Any

from workbench.study import evidence

from .study import sample


def calls() -> dict[str, Any]:
    return {
        "same_draws": partial(evidence.same_draws, {"a": sample(), "b": sample()}),
    }


def arguments() -> dict[str, Any]:
    return {"law": lambda thing: "a", "a": lambda thing: "a", "b": lambda thing: "b"}

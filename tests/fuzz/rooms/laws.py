from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from workbench.arms import laws as arm_laws

from ..parts import ARM, signals


def calls() -> dict[str, Any]:
    coefficients = np.ones((3, 2, 4))
    return {
        "ScheduledFeedback.of": partial(arm_laws.ScheduledFeedback.of, ARM, coefficients, 1.0, "chebyshev"),
        "StateFeedback.of": partial(arm_laws.ArmStateFeedback.of, ARM, np.ones((2, 4))),
    }


def arguments() -> dict[str, Any]:
    return {
        **signals(),
        "StateFeedback.of.model": lambda law: ARM,
        "StateFeedback.of.K": lambda law: np.ones((2, 4)),
        "ScheduledFeedback.of.model": lambda law: ARM,
        "coefficients": lambda law: np.ones((3, 2, 4)),
        "horizon": lambda law: 1.0,
    }

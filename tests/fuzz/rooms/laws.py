from __future__ import annotations

from functools import partial
from typing import Any

import control
import numpy as np

from workbench.arms import laws as arm_laws
from workbench.blocks import laws
from workbench.core import layout

from ..parts import ARM, signals

MODULES = ("workbench.arms.laws", "workbench.blocks.laws")
PORTS = (("q", "rad"), ("qd", "rad/s"), ("tau", "N m"))
PORT, LINEAR = layout(x="m"), control.ss([[-1.0]], [[1.0]], [[2.0]], 0, inputs="omega", outputs="v")


def calls() -> dict[str, Any]:
    eye, two = np.eye(2), [1.0, 1.0]
    coefficients = np.ones((3, 2, 4))
    flat = np.ones((3, 4))
    angle, rate, torque = (layout(**{name: (unit, [0, 0])}) for name, unit in PORTS)
    outer, inner = laws.PID2(angle, rate, two), laws.PID2(rate, torque, two, two)
    learns = arm_laws.Leakage(0.1, two)
    return {
        "AbstractSlidingMode": arm_laws.AbstractSlidingMode,
        "Cascade": partial(laws.Cascade, outer, inner, 3),
        "PID2": partial(
            laws.PID2, angle, torque, two, two, two, two, two, two, [-1.0, -1.0], two, "back-calculation", 0.1
        ),
        "PID": partial(arm_laws.PID, two, two, two, ARM),
        "AbstractAdaptation": arm_laws.Plain(),
        "AdaptiveSlidingMode": partial(arm_laws.AdaptiveSlidingMode, ARM, two, 0.1, 1.0, two, learns, "tanh"),
        "AosmcRgs": partial(arm_laws.AosmcRgs, ARM, two, 0.1, K=eye, P=eye, Q=eye, R=eye),
        "ComputedTorque": partial(arm_laws.ComputedTorque, ARM, two, two),
        "DeadZone": partial(arm_laws.DeadZone, 0.1),
        "Frozen": partial(arm_laws.Frozen),
        "FuzzyAsmc": partial(arm_laws.FuzzyAsmc, ARM, two, 0.1, 1.0, 0.1, two),
        "Leakage": partial(arm_laws.Leakage, 0.1, two),
        "NonsingularTerminalSlidingMode": partial(
            arm_laws.NonsingularTerminalSlidingMode, ARM, two, 1.5, two, two, 0.5, 0.1, "tanh"
        ),
        "Plain": partial(arm_laws.Plain),
        "RbfAsmc": partial(
            arm_laws.RbfAsmc, ARM, two, 0.1, 1.0, 1.0, 0.1, np.ones((3, 4)), np.ones(4), two, learns, "clip"
        ),
        "Rise": partial(arm_laws.Rise, two, two, two, two, 0.1, two, ARM, "clip"),
        "RuleBase": partial(arm_laws.RuleBase, [0.0, 1.0], 0.1, [0.0, 1.0], 0.1, eye),
        "ScheduledFeedback": partial(arm_laws.ScheduledFeedback, ARM, 1.0, flat, flat, "fourier"),
        "ScheduledFeedback.of": partial(arm_laws.ScheduledFeedback.of, ARM, coefficients, 1.0, "chebyshev"),
        "LinearLaw": partial(laws.LinearLaw, LINEAR, True, [1.0], [1.0]),
        "Regulator": partial(laws.Regulator, PORT, PORT, [[1.0]], [1.0], [1.0], ("x",)),
        "Sdre": partial(arm_laws.Sdre, ARM, eye, eye, eye),
        "SlidingMode": partial(arm_laws.SlidingMode, ARM, two, two, 0.1, "implicit"),
        "SlidingMode clip": partial(arm_laws.SlidingMode, ARM, two, two, 0.1),
        "StateFeedback": partial(arm_laws.StateFeedback, ARM, eye, eye),
        "StateFeedback.of": partial(arm_laws.StateFeedback.of, ARM, np.ones((2, 4))),
        "SuperTwisting": partial(arm_laws.SuperTwisting, ARM, two, two, two, 0.1, "sign"),
        "WithCompensation": partial(arm_laws.WithCompensation, arm_laws.SlidingMode(ARM, two, two, 0.1)),
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

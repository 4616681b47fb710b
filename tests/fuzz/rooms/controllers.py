from __future__ import annotations

from functools import partial
from typing import Any

import control
import numpy as np

from workbench.blocks import laws as controllers
from workbench.core import layout

from ..parts import ARM, signals

MODULES = ("workbench.blocks.laws",)
PORTS = (("q", "rad"), ("qd", "rad/s"), ("tau", "N m"))
PORT, LINEAR = layout(x="m"), control.ss([[-1.0]], [[1.0]], [[2.0]], 0, inputs="omega", outputs="v")


def calls() -> dict[str, Any]:
    eye, two = np.eye(2), [1.0, 1.0]
    coefficients = np.ones((3, 2, 4))
    flat = np.ones((3, 4))
    angle, rate, torque = (layout(**{name: (unit, [0, 0])}) for name, unit in PORTS)
    outer, inner = controllers.PID2(angle, rate, two), controllers.PID2(rate, torque, two, two)
    learns = controllers.Leakage(0.1, two)
    return {
        "Cascade": partial(controllers.Cascade, outer, inner, 3),
        "PID2": partial(
            controllers.PID2, angle, torque, two, two, two, two, two, two, [-1.0, -1.0], two, "back-calculation", 0.1
        ),
        "PID": partial(controllers.PID, two, two, two, ARM),
        "AbstractAdaptation": controllers.Plain(),
        "AdaptiveSlidingMode": partial(controllers.AdaptiveSlidingMode, ARM, two, 0.1, 1.0, two, learns, "tanh"),
        "AosmcRgs": partial(controllers.AosmcRgs, ARM, two, 0.1, K=eye, P=eye, Q=eye, R=eye),
        "ComputedTorque": partial(controllers.ComputedTorque, ARM, two, two),
        "DeadZone": partial(controllers.DeadZone, 0.1),
        "Frozen": partial(controllers.Frozen),
        "FuzzyAsmc": partial(controllers.FuzzyAsmc, ARM, two, 0.1, 1.0, 0.1, two),
        "Leakage": partial(controllers.Leakage, 0.1, two),
        "NonsingularTerminalSlidingMode": partial(
            controllers.NonsingularTerminalSlidingMode, ARM, two, 1.5, two, two, 0.5, 0.1, "tanh"
        ),
        "Plain": partial(controllers.Plain),
        "RbfAsmc": partial(
            controllers.RbfAsmc, ARM, two, 0.1, 1.0, 1.0, 0.1, np.ones((3, 4)), np.ones(4), two, learns, "clip"
        ),
        "Rise": partial(controllers.Rise, two, two, two, two, 0.1, two, ARM, "clip"),
        "RuleBase": partial(controllers.RuleBase, [0.0, 1.0], 0.1, [0.0, 1.0], 0.1, eye),
        "ScheduledFeedback": partial(controllers.ScheduledFeedback, ARM, 1.0, flat, flat, "fourier"),
        "ScheduledFeedback.of": partial(controllers.ScheduledFeedback.of, ARM, coefficients, 1.0, "chebyshev"),
        "LinearLaw": partial(controllers.LinearLaw, LINEAR, True, [1.0], [1.0]),
        "Regulator": partial(controllers.Regulator, PORT, PORT, [[1.0]], [1.0], [1.0], ("x",)),
        "Sdre": partial(controllers.Sdre, ARM, eye, eye, eye),
        "SlidingMode": partial(controllers.SlidingMode, ARM, two, two, 0.1, "implicit"),
        "SlidingMode clip": partial(controllers.SlidingMode, ARM, two, two, 0.1),
        "StateFeedback": partial(controllers.StateFeedback, ARM, eye, eye),
        "StateFeedback.of": partial(controllers.StateFeedback.of, ARM, np.ones((2, 4))),
        "SuperTwisting": partial(controllers.SuperTwisting, ARM, two, two, two, 0.1, "sign"),
        "WithCompensation": partial(controllers.WithCompensation, controllers.SlidingMode(ARM, two, two, 0.1)),
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

from __future__ import annotations

from functools import partial
from typing import Any

from workbench import signals as room

from ..parts import signals

MODULES = ("workbench.signals",)


def calls() -> dict[str, Any]:
    two = [1.0, 2.0]
    return {
        "Hold": partial(room.Hold, two),
        "SineTorque": partial(room.SineTorque, two, two, two),
        "Sines": partial(room.Sines, two, two, two),
        "SmoothSquareWave": partial(room.SmoothSquareWave, two, 1.0, 0.1),
        "SquareWave": partial(room.SquareWave, two, 1.0),
    }


def arguments() -> dict[str, Any]:
    return signals()

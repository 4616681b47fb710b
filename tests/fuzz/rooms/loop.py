from __future__ import annotations

from functools import partial
from typing import Any

from workbench.blocks import loop

from ..parts import PLANT, signals


def calls() -> dict[str, Any]:
    return {
        "Instruments": partial(
            loop.Instruments.of,
            PLANT,
            {"q": 0.1},
            {"q": 0.1},
            {"tau": (-1.0, 1.0)},
            {"q": (12, -4.0, 4.0, "down")},
            {"tau": (8, [-1.0, -2.0], 1.0)},
            (loop.RandomWalk("q", 0.1),),
        ),
    }


def arguments() -> dict[str, Any]:
    return signals()

from __future__ import annotations

import tempfile
from functools import partial
from pathlib import Path
from typing import Any

from workbench.blocks import signals as room

from ..parts import signals

MODULES = ("workbench.blocks.signals",)
FOLDER = tempfile.TemporaryDirectory()
FILE = Path(FOLDER.name) / "log.csv"
FILE.write_text("t [s],x [m]\n0,1\n1,2\n2,3\n")


def calls() -> dict[str, Any]:
    two, pair = [1.0, 2.0], ("x", "m, rad")
    return {
        "AbstractSignal": room.Step("x", "m", 1.0),
        "Chirp": partial(room.Chirp, *pair, two, 0.1, 2.0, 3.0, two, "logarithmic"),
        "Hold": partial(room.Hold, two, *pair),
        "PulseTrain": partial(room.PulseTrain, *pair, two, 1.0, 0.5, 0.1, two),
        "Ramp": partial(room.Ramp, *pair, two, two, two),
        "SineTorque": partial(room.SineTorque, two, two, two),
        "Sines": partial(room.Sines, two, two, two),
        "SquareWave": partial(room.SquareWave, two, 1.0),
        "Step": partial(room.Step, *pair, two, two, two),
        "Table": partial(room.Table, *pair, [0.0, 1.0, 2.0], [two, two, two], "cubic"),
        "Table.from_csv": partial(
            room.Table.from_csv, str(FILE), "x", "m", columns=("x",), time="t", begin=0.0, end=2.0, every=1
        ),
        "Together": partial(room.Together, (room.Step("x", "m", 1.0), room.Step("v", "V", 1.0))),
        "Trapezoid": partial(room.Trapezoid, *pair, two, two, two, 0.1, [0.0, 1.0]),
        "WayPoints": partial(room.WayPoints, *pair, [0.0, 1.0], [two, two]),
    }


def arguments() -> dict[str, Any]:
    return signals()

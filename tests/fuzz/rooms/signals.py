from __future__ import annotations

import tempfile
from functools import partial
from pathlib import Path
from typing import Any

from workbench.blocks import signals as room

from ..parts import signals

FOLDER = tempfile.TemporaryDirectory()
FILE = Path(FOLDER.name) / "log.csv"
FILE.write_text("t [s],x [m]\n0,1\n1,2\n2,3\n")


def calls() -> dict[str, Any]:
    return {
        "Table.from_csv": partial(
            room.Table.from_csv, str(FILE), "x", "m", columns=("x",), time="t", begin=0.0, end=2.0, every=1
        ),
    }


def arguments() -> dict[str, Any]:
    return signals()

"""control-workbench: equations in, verdicts, numbers and a running controller out.

`import workbench as wb` loads nothing by itself; each of the names of `wb` comes from its room when it is first asked
for. `dir(wb)` lists them, and `help(wb.X)` tells of one, with its shapes, units and an example.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

__version__ = "0.1.0"

_HOMES = {"plot": ("workbench.report.figures.runs", "plot_runs")}


def __getattr__(name: str) -> Any:
    """A name of the face, loaded from its file when it is first asked for."""
    if name not in _HOMES:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    file, held = _HOMES[name]
    return getattr(import_module(file), held)

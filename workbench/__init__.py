"""control-workbench: equations in, verdicts and numbers out.

A control engineer writes a robot, a law and a question; the workbench derives the model, checks the
claims, simulates the closed loops, compares the laws and writes a report that a reviewer can trust.
"""

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

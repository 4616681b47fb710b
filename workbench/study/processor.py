"""The machine of a measurement: the model of its processor and the versions of its packages."""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

PACKAGES = ("control-workbench", "casadi", "control", "jax", "llvmlite", "numba", "numpy", "scipy")


def cpu() -> str:
    """The model of the processor."""
    table = Path("/proc/cpuinfo")
    lines = table.read_text().splitlines() if table.exists() else []
    named = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(named, platform.processor() or platform.machine())


def machine() -> dict[str, str]:
    """Processor, Python, and the packages that are here, by version."""
    found = {"cpu": cpu(), "python": platform.python_version()}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            continue
    return found

"""Peer: another way to run W, and what runs it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version

from workbench.validation.refusals import Array

# Parameters (B, 40) of B runs to the RMSE (B, 2) of their joints at the horizon.
Runner = Callable[[Array], Array]

ABSENT = "not installed: pip install control-workbench[peers]"


@dataclass(frozen=True)
class Peer:
    """One way to run W that a user could pick instead.

    Attributes
    ----------
    package
        What must be installed for it.
    bar
        How many times as fast we must be.
    runs
        How many runs one measurement takes: as many as it needs for its full speed.
    runner
        From the horizon in s to what runs it, compiled. It imports what it needs.
    """

    name: str
    package: str
    bar: float
    runs: int
    runner: Callable[[float], Runner]

    @property
    def installed(self) -> bool:
        """Whether its package is here."""
        try:
            version(self.package)
        except PackageNotFoundError:
            return False
        return True

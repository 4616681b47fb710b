"""What a loop must say of itself to be run."""

from __future__ import annotations

from typing import Protocol

from workbench.core import Ode


class Loop(Protocol):
    """Anything that can say its equations."""

    def ode(self, name: str = ...) -> Ode:
        """The loop as x' = f(t, x, p)."""

"""A closed loop in a computer, as sweeps and searches run it."""

from __future__ import annotations

from dataclasses import dataclass, replace

from workbench.core import Sampled
from workbench.loop import ClosedLoop, Instruments


@dataclass(frozen=True)
class ComputedLoop:
    """A loop whose observer and law run once in `period` seconds; its equations are made where a run asks for them."""

    loop: ClosedLoop
    period: float
    instruments: Instruments | None = None
    delay: bool = False
    integrator: str = "declared"

    def ode(self, name: str = "loop") -> Sampled:
        how = {"delay": self.delay, "integrator": self.integrator, "name": name}
        return self.loop.digital(self.period, self.instruments, **how)

    def ablations(self) -> dict[str, ComputedLoop]:
        """The loop less each of its parts."""
        return {name: replace(self, loop=less) for name, less in self.loop.ablations().items()}

"""Run: a loop, what is measured of it, and at which step: a case names one, a sweep varies one, a tuning tries one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from workbench.core import Ode, Sampled
from workbench.metrics import AbstractMetric
from workbench.study.contract import Loop, check_loop
from workbench.validation.refusals import multiple, positive, seconds, seed
from workbench.validation.signatures import door

TOLERANCE = 1e-3


@dataclass(frozen=True, eq=False)
@door
class Run:
    """A loop from its initial state to a horizon, and the metrics that are taken of it.

    Attributes
    ----------
    loop
        Equations, an `Ode` or a `Sampled`, or what gives them by `ode(name)`, as a `ClosedLoop` does.
    until, every
        Horizon and distance of the kept times, in s, multiples of `h`. Without `every` a case keeps each step of its
        check, a sweep and a tuning the horizon alone.
    h
        The step in s at which values are taken, the same in a case, a sweep and the best of a tuning; of a sampled loop
        the substep. Without it, pilot runs choose steps that keep the tolerance.
    tolerance
        By how much a value may change, relative to itself, from twice the step to the step. A case with an `h` is held
        against it, None against none; without `h` it is 0.001 if not given.
    seed
        Of the noise.

    Examples
    --------
    >>> run = wb.Run(wb.open_loop(wb.DCMotor()), (wb.effort("omega"),), until=1.0)
    >>> run.steps
    'steps for a tolerance of 0.001'
    """

    WAYS: ClassVar = dict.fromkeys(("ClosedLoop", "Ode", "Sampled"), "write `Run(loop, metrics, until)`")

    loop: Loop | Ode | Sampled
    metrics: tuple[AbstractMetric, ...]
    until: float
    every: float | None = None
    h: float | None = None
    tolerance: float | None = None
    seed: int = 0

    def __post_init__(self) -> None:
        check_loop("Run(loop=...)", self.loop)
        for name in ("h", "until", "every"):
            if (span := getattr(self, name)) is not None:
                seconds(f"Run({name}=...)", span)
        if self.tolerance is not None:
            positive("Run(tolerance=...)", self.tolerance)
        elif self.h is None:
            object.__setattr__(self, "tolerance", TOLERANCE)
        seed("Run(seed=...)", self.seed)
        for name, part in (("every", "h"), ("until", "h"), ("until", "every")):
            if (span := getattr(self, name)) is not None and (unit := getattr(self, part)) is not None:
                multiple(f"Run({name}=...)", span, unit, f"`{part}`,")

    @property
    def kept(self) -> float:
        """The distance of the times at which a sweep takes its metrics, in s."""
        return self.until if self.every is None else self.every

    @property
    def steps(self) -> str:
        """The step in words."""
        return f"steps for a tolerance of {self.tolerance:g}" if self.h is None else f"h = {self.h:g} s"

    def doubled(self, equation: Ode | Sampled, call: str) -> float:
        """The step of the check, 2 h, in s.

        Raises
        ------
        ValueError
            If it does not divide the period of a sampled loop.
        """
        assert self.h is not None
        if isinstance(equation, Sampled) and equation.substeps(self.h) % 2:
            raise ValueError(
                f"`{call}` needs an `h` of which an even number makes the sampling period {equation.period:g} s, as "
                f"its values are held against those at 2 h; got {self.h:g} s: take {self.h / 2:g} s."
            )
        return 2 * self.h

"""Sweep: many runs of one loop over factors, cut into chunks that anyone can compute from their numbers alone."""

from __future__ import annotations

from dataclasses import dataclass

from workbench.core.layout import Array
from workbench.core.numbers import multiple, positive
from workbench.metrics import AbstractMetric
from workbench.study.cells import check_name, several
from workbench.study.contract import Design, Factor, Loop

HALVED = 16


@dataclass(frozen=True, eq=False)
class Sweep:
    """Runs of one loop, whose factors take the values that a design says.

    Attributes
    ----------
    name
        Lower-case letters, digits and underscores: it becomes the name of a file.
    design
        A point of the unit cube a run, one coordinate a factor.
    h, until, every
        Step, horizon and distance of the times at which metrics are taken, in s, each a multiple of the one before
        it; without `every` they are taken at the horizon alone. Values are those at the step h.
    seed
        Of the noise, which is each run's own.
    halved
        One run of so many is run again at h / 2, for the error of the step: those whose number it divides.
    runs_of_chunk
        How many runs are computed and kept together; without it about as many as take a second or two of one processor.
    """

    name: str
    loop: Loop
    metrics: tuple[AbstractMetric, ...]
    factors: tuple[Factor, ...]
    design: Design
    h: float
    until: float
    every: float | None = None
    seed: int = 0
    halved: int = HALVED
    runs_of_chunk: int | None = None

    def __post_init__(self) -> None:
        check_name("Sweep", self.name)
        object.__setattr__(self, "metrics", several("Sweep(metrics=...)", self.metrics, AbstractMetric, "metric"))
        object.__setattr__(self, "factors", several("Sweep(factors=...)", self.factors, object, "factor"))
        for name, given in (("metrics", self.metrics), ("factors", self.factors)):
            if not given:
                raise ValueError(f"`Sweep({name}=...)` of '{self.name}' needs at least one; got none.")
            names = [part.name for part in given]
            if twice := {one for one in names if names.count(one) > 1}:
                raise ValueError(f"`Sweep({name}=...)` needs distinct names; {sorted(twice)} came more than once.")
        for name in ("h", "until", *(() if self.every is None else ("every",))):
            positive(f"Sweep({name}=...)", getattr(self, name), " of seconds")
        every = self.until if self.every is None else self.every
        multiple("Sweep(every=...)", every, self.h, f"`h` of '{self.name}',")
        multiple("Sweep(until=...)", self.until, every, f"`every` of '{self.name}',")
        for name in ("halved", "runs_of_chunk"):
            whole(f"Sweep({name}=...)", getattr(self, name), optional=name == "runs_of_chunk")
        whole("Sweep(design=...).size", self.design.size)

    def points(self, first: int, last: int) -> Array:
        """The design's points first to last - 1, (last - first, d).

        Raises
        ------
        ValueError
            If the design does not give one point a run, in the unit cube, with one coordinate a factor.
        """
        points = self.design.points(first, last)
        shape = (last - first, len(self.factors))
        if points.shape != shape or not ((points >= 0) & (points <= 1)).all():
            raise ValueError(
                f"`Sweep(design=...)` of '{self.name}' must give points of the unit cube, {shape} for {shape[0]} runs "
                f"of {shape[1]} factors; got {points.shape} within [{points.min():g}, {points.max():g}]."
            )
        return points


def whole(call: str, value: object, optional: bool = False) -> None:
    """Refuse what is no positive whole number."""
    if optional and value is None:
        return
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        raise ValueError(f"`{call}` must be a positive whole number; got {value!r}.")

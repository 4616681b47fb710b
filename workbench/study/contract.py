"""The contract of a study: a loop, which gives its equations, and the Run with its horizon and metrics."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

from workbench.core import Ode, Sampled
from workbench.metrics import AbstractMetric
from workbench.validation.refusals import described, multiple, positive, refusal, seconds, seed
from workbench.validation.signatures import door

TOLERANCE = 1e-3
LONGEST = 300  # letters of an author's error
LOOP = "an `Ode`, a `Sampled`, or a loop, whose `ode(name)` gives its equations, as a `ClosedLoop` does"


class Loop(Protocol):
    """Anything that gives its equations under a name."""

    def ode(self, name: str = ...) -> Ode | Sampled:
        """The loop in continuous time, or closed by a computer."""


def equations_of(loop: Loop | Ode | Sampled, name: str) -> Any:
    """The equations of a loop under a name; an `Ode` or a `Sampled` is returned as it is."""
    if isinstance(loop, Ode | Sampled):
        return loop
    call = f"{type(loop).__name__}.ode({name!r})"
    if not _is_loop(loop):
        raise refusal("loop", LOOP, loop)
    equations = answer(call, loop.ode, name)
    if not isinstance(equations, Ode | Sampled):
        must = "the equations of a loop, an `Ode` or a `Sampled`, as those of a `ClosedLoop` are"
        raise refusal(call, must, equations)
    return equations


def _is_loop(given: object) -> bool:
    one = not isinstance(given, type)
    return isinstance(given, Ode | Sampled) or (one and callable(getattr(given, "ode", None)))


def answer(call: str, function: Callable[..., Any], *arguments: object) -> Any:
    """The result of a function that the study's author wrote.

    Raises
    ------
    ValueError
        If it ends the process, or ends with an error of another kind than those that say what is wrong.
    """
    try:
        return function(*arguments)
    except (ValueError, LookupError, OSError, MemoryError):
        raise
    except SystemExit as error:
        raise ValueError(f"`{call}` ended the study by itself, with status {described(error.code)}.") from error
    except Exception as error:
        message = described(str(error), LONGEST)
        raise ValueError(f"`{call}` ended with {type(error).__name__}: {message}.") from error


@dataclass(frozen=True, eq=False)
@door
class Run:
    """A loop from its initial state to a horizon, and the metrics that are taken of it.

    A case names one run, a sweep varies its numbers, and a tuning searches for them.

    Attributes
    ----------
    loop
        Equations, an `Ode` or a `Sampled`, or what gives them by `ode(name)`, as a `ClosedLoop` does.
    until, every
        Horizon and distance of the kept times, in s, multiples of `h`. Without `every` a case keeps each step of its
        check, a sweep and a tuning the horizon alone.
    h
        The step in s at which values are taken; of a sampled loop the substep. Without it, pilot runs choose one.
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
        if not _is_loop(self.loop):
            raise refusal("Run(loop=...)", LOOP, self.loop)
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
        """The step of the check, 2 h, in s, which must divide the period of a sampled loop."""
        assert self.h is not None
        if isinstance(equation, Sampled) and equation.substeps(self.h) % 2:
            raise ValueError(
                f"`{call}` needs an `h` of which an even number makes the sampling period {equation.period:g} s, as "
                f"its values are held against those at 2 h; got {self.h:g} s: take {self.h / 2:g} s."
            )
        return 2 * self.h

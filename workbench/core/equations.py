"""Loops and their equations: what the users of equations take from anything that can give them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, TypeVar

from workbench.core.ode import Ode
from workbench.core.sampled_system import SampledSystem
from workbench.core.validation.refusals import describe, refusal

T = TypeVar("T")
LONGEST = 300  # letters of an author's error
LOOP = "an `Ode`, a `SampledSystem`, or a loop, whose `ode(name)` gives its equations, as a `ClosedLoop` does"


class Loop(Protocol):
    """Anything that gives its equations under a name."""

    def ode(self, name: str = ...) -> Ode | SampledSystem:
        """The loop in continuous time, or closed by a computer."""


def equations_of(loop: Loop | Ode | SampledSystem, name: str) -> Ode | SampledSystem:
    """The equations of a loop under a name; an `Ode` or a `SampledSystem` is returned as it is."""
    if isinstance(loop, Ode | SampledSystem):
        return loop
    call = f"{type(loop).__name__}.ode({name!r})"
    if not is_loop(loop):
        raise refusal("loop", LOOP, loop)
    equations: object = answer(call, loop.ode, name)
    if not isinstance(equations, Ode | SampledSystem):
        must = "the equations of a loop, an `Ode` or a `SampledSystem`, as those of a `ClosedLoop` are"
        raise refusal(call, must, equations)
    return equations


def is_loop(value: object) -> bool:
    """True for an `Ode`, a `SampledSystem`, and an object with a method `ode`."""
    one = not isinstance(value, type)
    return isinstance(value, Ode | SampledSystem) or (one and callable(getattr(value, "ode", None)))


def answer(call: str, function: Callable[..., T], *arguments: object) -> T:
    """The result of a function that the study's author wrote; any error but those that say what is wrong is named."""
    try:
        return function(*arguments)
    except (ValueError, LookupError, OSError, MemoryError):
        raise
    except SystemExit as error:
        raise ValueError(f"`{call}` ended the study by itself, with status {describe(error.code)}.") from error
    except Exception as error:
        message = describe(str(error), LONGEST)
        raise ValueError(f"`{call}` ended with {type(error).__name__}: {message}.") from error

"""What a study is given to call: loops, which say their equations, and functions of its author."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from workbench.core import Ode, Sampled
from workbench.validation.refusals import described, refusal

LONGEST = 300  # letters of what an author's error says


class Loop(Protocol):
    """What gives its equations under a name."""

    def ode(self, name: str = ...) -> Ode | Sampled:
        """The loop in continuous time, or closed by a computer."""


def check_loop(call: str, given: object) -> None:
    """Refuse what is no loop."""
    if isinstance(given, type) or not (isinstance(given, Ode | Sampled) or callable(getattr(given, "ode", None))):
        must = "an `Ode`, a `Sampled`, or a loop, whose `ode(name)` gives its equations, as a `ClosedLoop` does"
        raise refusal(call, must, given)


def equations_of(loop: Loop | Ode | Sampled, name: str) -> Any:
    """The equations of a loop under a name; equations are their own.

    Raises
    ------
    ValueError
        If what the loop gives is neither an `Ode` nor a `Sampled`.
    """
    if isinstance(loop, Ode | Sampled):
        return loop
    call = f"{type(loop).__name__}.ode({name!r})"
    given = answer(call, loop.ode, name)
    if not isinstance(given, Ode | Sampled):
        raise refusal(call, "the equations of a loop, an `Ode` or a `Sampled`, as those of a `ClosedLoop` are", given)
    return given


def answer(call: str, function: Callable[..., Any], *given: object) -> Any:
    """What a function of the study's author gives.

    Raises
    ------
    ValueError
        If it ends the process, or ends with an error of another kind than those that say what is wrong.
    """
    try:
        return function(*given)
    except (ValueError, LookupError, OSError, MemoryError):
        raise
    except SystemExit as error:
        raise ValueError(f"`{call}` ended the study by itself, with status {described(error.code)}.") from error
    except Exception as error:
        said = described(str(error), LONGEST)
        raise ValueError(f"`{call}` ended with {type(error).__name__}: {said}.") from error

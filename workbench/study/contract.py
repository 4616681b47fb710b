"""What a study is given to call: loops, which say their equations, and functions of its author."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from workbench.core import Ode, Sampled
from workbench.validation.words import described, refusal

LONGEST = 300  # letters of what an author's error says


class Loop(Protocol):
    """Anything that can say its equations."""

    def ode(self, name: str = ...) -> Ode:
        """The loop as x' = f(t, x, p)."""


def check_loop(call: str, given: object) -> None:
    """Refuse what is no loop."""
    if isinstance(given, type) or not callable(getattr(given, "ode", None)):
        raise refusal(call, "a loop, whose `ode(name)` gives its equations, as a `ClosedLoop` does", given)


def equations_of(loop: Loop, name: str) -> Any:
    """The equations of a loop under a name.

    Raises
    ------
    ValueError
        If what the loop gives is neither an `Ode` nor a `Sampled`.
    """
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

"""Sockets: what kind of thing a field of a block, or an argument, takes."""

from __future__ import annotations

import inspect
import types
from dataclasses import Field
from functools import cache
from typing import Any, Union, get_args, get_origin, get_type_hints

import numpy as np

LONGEST = 60  # how much of a value a message shows
WORDS = {int: "a whole number", float: "a number", bool: "True or False", str: "text", type(None): "None"}


def require(call: str, value: object, kind: type, advice: str = "") -> None:
    """Refuse, with a `ValueError`, a `value` that is no instance of `kind`."""
    if not isinstance(value, kind):
        raise ValueError(f"`{call}` must be {_words(kind)}; got {described(value)}{advice}.")


def fitted(owner: Any, field: Field[Any]) -> Any:
    """The value of a field, where it is of the kind that the field's type names; lists become tuples."""
    cls: Any = type(owner)
    hint = _hints(cls).get(field.name, Any)
    value = _converted(getattr(owner, field.name), hint)
    if _fits(value, hint):
        return value
    got = described(value)
    tuples = [kind for kind in _options(hint) if get_origin(kind) is tuple]
    if tuples and isinstance(value, tuple):
        bad = [f"{described(v)} at [{i}]" for i, v in enumerate(value) if not _fits(v, _item(tuples[0], i))]
        got = bad[0] if bad else f"{len(value)} of them"
    raise ValueError(f"`{type(owner).__name__}({field.name}=...)` must be {_words(hint)}; got {got}.")


def described(value: object) -> str:
    """What a value is, for a message: `a PID, which is an AbstractController`."""
    if isinstance(value, type):
        return f"the class `{value.__name__}` itself: make one with `{value.__name__}(...)`"
    if callable(value) and hasattr(value, "__name__"):
        return f"the function `{value.__name__}` itself: call it"
    if value is None or isinstance(value, bool | int | float | str | np.generic):
        text = repr(value.item() if isinstance(value, np.generic) else value)
        return text if len(text) <= LONGEST else f"{text[:LONGEST]}..."
    bases = [base for base in type(value).__mro__[1:] if inspect.isabstract(base)]
    family = f", which is {_a(bases[0])}" if bases else ""
    return f"{_a(type(value))}{family}"


@cache
def _hints(cls: Any) -> dict[str, Any]:
    """The types of a class's fields; none where one of them is named within a function, out of sight."""
    try:
        return get_type_hints(cls)
    except NameError:
        return {}


def _options(hint: Any) -> tuple[Any, ...]:
    return get_args(hint) if get_origin(hint) in (Union, types.UnionType) else (hint,)


def _item(hint: Any, place: int) -> Any:
    """The type of one item of a tuple; nothing fits beyond its end."""
    items = get_args(hint)
    if len(items) == 2 and items[1] is Ellipsis:
        return items[0]
    return items[place] if place < len(items) else None


def _converted(value: Any, hint: Any) -> Any:
    """NumPy's whole numbers and truths as Python's, a list for a tuple as a tuple."""
    kinds = _options(hint)
    if (isinstance(value, np.integer) and int in kinds) or (isinstance(value, np.bool_) and bool in kinds):
        return value.item()
    if isinstance(value, list) and any(kind is tuple or get_origin(kind) is tuple for kind in kinds):
        return tuple(value)
    return value


def _fits(value: Any, hint: Any) -> bool:
    """Whether a value is of a type; a type that cannot be asked refuses nothing."""
    if len(kinds := _options(hint)) > 1:
        return any(_fits(value, kind) for kind in kinds)
    if hint is Any:
        return True
    if hint is None:
        return value is None
    if get_origin(hint) is tuple:
        several = get_args(hint)[-1:] == (Ellipsis,)
        return (
            isinstance(value, tuple)
            and (several or len(value) == len(get_args(hint)))
            and all(_fits(v, _item(hint, i)) for i, v in enumerate(value))
        )
    kind = get_origin(hint) or hint
    if kind in (int, float) and isinstance(value, bool | np.bool_):
        return False
    try:
        return isinstance(value, (int, float) if kind is float else kind)
    except TypeError:
        return True


def _words(hint: Any) -> str:
    """A type as one says it: `an AbstractArm or None`."""
    if get_origin(hint) is tuple:
        kinds = [kind for kind in get_args(hint) if kind is not Ellipsis]
        return "a tuple of " + " or ".join(dict.fromkeys(_name(k) for kind in kinds for k in _options(kind)))
    if len(options := _options(hint)) > 1:
        return " or ".join(map(_words, options))
    return WORDS.get(hint) or _a(hint)


def _a(kind: Any) -> str:
    name = _name(kind)
    return f"{'an' if name[1] in 'AEIOaeio' else 'a'} {name}"


def _name(kind: Any) -> str:
    return f"`{getattr(kind, '__name__', kind)}`"

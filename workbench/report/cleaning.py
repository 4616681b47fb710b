"""Text that every reader of a report can read: no control characters, no broken pairs, no line breaks."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any, TypeVar, cast

T = TypeVar("T")

_BREAKS = re.compile(r"\r\n|[\n\r\t]")
# control characters, halves of surrogate pairs, and the two that are no characters in any file of text
_UNREADABLE = re.compile("[\x00-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff]")


def cleaned(held: T) -> T:
    """A document, or any part of it, whose texts are clean; the very same object where all were.

    A line break or tab becomes a space, and what no file may hold becomes U+FFFD, the sign for a
    character that cannot be shown.
    """
    return cast(T, _cleaned(held))


def _cleaned(held: Any) -> Any:
    if isinstance(held, str):
        return _UNREADABLE.sub("\ufffd", _BREAKS.sub(" ", held))
    if isinstance(held, tuple):
        items = tuple(map(_cleaned, held))
        return held if all(a is b for a, b in zip(items, held, strict=True)) else items
    if isinstance(held, Mapping):
        return {_cleaned(key): _cleaned(value) for key, value in held.items()}
    if is_dataclass(held) and not isinstance(held, type):
        values = {field.name: getattr(held, field.name) for field in fields(held)}
        changed = {name: new for name, old in values.items() if (new := _cleaned(old)) is not old}
        return replace(held, **changed) if changed else held
    return held

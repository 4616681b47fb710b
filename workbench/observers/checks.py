"""What the observers ask of the numbers they are given, beyond bounds and shapes."""

from __future__ import annotations

from typing import Any


def positive_count(call: str, value: Any) -> None:
    """Refuse what is not a positive whole number of joints."""
    if not isinstance(value, int) or isinstance(value, bool) or value < 1:
        raise ValueError(f"`{call}` is the number of joints, a positive whole number; got {value!r}.")

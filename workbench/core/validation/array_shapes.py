"""Shapes of the arrays of a dataclass that belong together."""

from __future__ import annotations

from collections.abc import Mapping


def require_shapes(owner: object, shapes: Mapping[str, tuple[int, ...]], of: str) -> None:
    """Refuse an object with an array of another shape than its field's; `of` says what the axes count.

    A field that holds None is left out.
    """
    for name, shape in shapes.items():
        given = getattr(owner, name)
        if given is not None and given.shape != shape:
            call = f"{type(owner).__name__}({name}=...)"
            raise ValueError(f"`{call}` must have shape {shape}, {of}; got {given.shape}.")

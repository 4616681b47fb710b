"""The declarations of a block that its tests hold it to: that it can be exported, and whether its units are mixed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, is_dataclass


class AbstractBlock:
    """A block that declares what it can do; what it does not say itself follows from the blocks that it holds."""

    def __init__(self, *_: object, **numbers: object) -> None:
        name = type(self).__name__
        raise TypeError(f"`{name}(...)` needs the decorator of a block: write `@wb.block` above `class {name}`.")

    @property
    def exportable(self) -> bool:
        """False if it calls a function that other machines lack, as a root finder: each export then refuses it."""
        return all(part.exportable for part in _parts(self))

    @property
    def mixed_units(self) -> str:
        """The reason, as a clause, why an equation mixes units, as a printed one may; empty if none does."""
        return next((part.mixed_units for part in _parts(self) if part.mixed_units), "")


def _parts(block: object) -> Iterator[AbstractBlock]:
    """The blocks among the fields of a block."""
    held = [getattr(block, f.name) for f in fields(block)] if is_dataclass(block) else []
    parts = (part for value in held for part in (value if isinstance(value, tuple) else (value,)))
    yield from (part for part in parts if isinstance(part, AbstractBlock))

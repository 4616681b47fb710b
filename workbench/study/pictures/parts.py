"""What all pictures share: captions that end with their note, names as they are written, and numbers for a file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, TypeAlias

import numpy as np

from workbench.core.layout import nearest
from workbench.core.numbers import Integers
from workbench.core.sockets import described
from workbench.study.cells import Cell, Part, Phrase, check_phrase, parts, raised
from workbench.study.curves import Array, Label

Labels: TypeAlias = Mapping[str, Label] | None


def captioned(call: str, caption: Phrase, note: Phrase, *remarks: Phrase) -> Phrase:
    """A caption with what must be said of the picture and, last, its note: runs, failed runs, seed, step error."""
    check_phrase(f"{call}(caption)", caption)
    check_phrase(f"{call}(note=...)", note)
    if not any(part.strip() if isinstance(part, str) else True for part in parts(note)):
        raise ValueError(
            f"`{call}(note=...)` must say how many runs a figure shows, how many of them failed, their seed and their "
            "step error, as `sample.note_of(metric, joint)` does; got an empty one."
        )
    said = [phrase for phrase in (caption, *remarks, note) if phrase]
    return tuple(part for i, phrase in enumerate(said) for part in (*([" "] if i else []), *_sentence(phrase)))


def _sentence(phrase: Phrase) -> tuple[Part, ...]:
    """A phrase that ends with a full stop."""
    last = parts(phrase)[-1]
    ended = isinstance(last, str) and last.rstrip().endswith((".", "!", "?"))
    return parts(phrase) if ended else (*parts(phrase), ".")


def named(call: str, names: tuple[str, ...], labels: Labels) -> tuple[Label, ...]:
    """How each name is written: as `labels` has it, or else as it stands; a label for no name is refused."""
    labels = labels or {}
    for name in labels:
        if name not in names:
            raise LookupError(f"`{call}(labels=...)` names '{name}', which is not drawn.{nearest(name, names)}")
    return tuple(labels.get(name, name) for name in names)


def with_unit(name: Label, unit: str) -> Label:
    """What an axis shows, with its unit in brackets."""
    own = name if isinstance(name, tuple) else (name,)
    return (*own, f" [{raised(unit)}]") if unit not in ("", "1") else own


def each(found: Any) -> Iterator[Any]:
    """The results for each output that was not refused, one by one; those of a single output are themselves."""
    if len(found.names) == 1 and not found.refused and np.ndim(_some(found)) == 1:
        yield found
        return
    for name in found.names:
        if name not in found.refused:
            yield found[name]


def _some(found: Any) -> Any:
    """An array whose last axis is that of the factors."""
    estimate = getattr(found, "S1", None) or getattr(found, "mu_star", None)
    return found.swing if estimate is None else estimate.value


def refusals(found: Any) -> tuple[str, ...]:
    """A sentence for each output that is not drawn, with the reason."""
    return tuple(f"Not drawn is '{name}': {why}." for name, why in found.refused.items())


def stretches(curve: Array) -> list[Integers]:
    """The places of each stretch of a curve (N,) without a NaN."""
    known = np.flatnonzero(~np.isnan(curve))
    return [part for part in np.split(known, np.flatnonzero(np.diff(known) > 1) + 1) if part.size]


def number(value: float) -> Cell:
    """A number for a file; a dash for what is not known."""
    return None if np.isnan(value) else float(value)


def require_array(call: str, given: Any, *, columns: int | None = None) -> Array:
    """A float array of its own; with so many columns, if they are counted."""
    try:
        array = np.array(given, dtype=float)
    except (TypeError, ValueError):
        raise ValueError(f"`{call}` must be numbers; got {described(given)}.") from None
    if not array.size or (columns is not None and (array.ndim != 2 or array.shape[1] != columns)):
        shape = "at least one number" if columns is None else f"an array (B, {columns}) of numbers, B >= 1"
        raise ValueError(f"`{call}` must be {shape}; got the shape {array.shape}.")
    return array

"""What all pictures share: captions that end with their note, names as they are written, and numbers for a file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal, TypeAlias, TypeVar

import numpy as np

from workbench.study.document.cells import Cell, Part, Phrase, check_phrase, parts, raised
from workbench.study.document.curves import Array, Label
from workbench.study.uncertainty.effects import MorrisEffects
from workbench.study.uncertainty.indices import SobolIndices
from workbench.study.uncertainty.outputs import Estimate, check_size
from workbench.study.uncertainty.tornado import Tornado
from workbench.validation.refusals import Integers

Labels: TypeAlias = Mapping[str, Label] | None
DECADE = 10.0  # the ratio of the largest number to the least from which on an axis is logarithmic
BEYOND = "An interval with an arrow goes on beyond the axes."
Given = TypeVar("Given")
Found = TypeVar("Found", SobolIndices, MorrisEffects, Tornado)


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


def written(name: str, labels: Labels) -> Label:
    """How a factor or an output is written: as `labels` has it, or else as it stands."""
    return (labels or {}).get(name, name)


def with_unit(name: Label, unit: str) -> Label:
    """What an axis shows, with its unit in brackets."""
    own = name if isinstance(name, tuple) else (name,)
    return (*own, f" [{raised(unit)}]") if unit not in ("", "1") else own


def each(found: Found) -> list[Found]:
    """The results of each output that was not refused; those of a single output are themselves."""
    match found:
        case SobolIndices():
            numbers = found.S1.value
        case MorrisEffects():
            numbers = found.mu_star.value
        case Tornado():
            numbers = found.swing
    return [found] if numbers.ndim == 1 else [found[name] for name in found.names if name not in found.refused]


def refusals(found: SobolIndices | MorrisEffects | Tornado) -> tuple[str, ...]:
    """A sentence for each output that is not drawn, with the reason."""
    return tuple(f"Not drawn is '{name}': {why}." for name, why in found.refused.items())


def stretches(curve: Array) -> list[Integers]:
    """The places of each stretch of a curve (N,) without a NaN."""
    known = np.flatnonzero(~np.isnan(curve))
    return [part for part in np.split(known, np.flatnonzero(np.diff(known) > 1) + 1) if part.size]


def number(value: float) -> Cell:
    """A number for a file; a dash for what is not known."""
    return None if np.isnan(value) else float(value)


def require_array(call: str, array: Array, *, columns: int | None = None) -> Array:
    """An array that is not empty; with so many columns, if they are counted."""
    check_size(call, array, infinite=True)
    if not array.size or (columns is not None and (array.ndim != 2 or array.shape[1] != columns)):
        shape = "at least one number" if columns is None else f"an array (B, {columns}) of numbers, B >= 1"
        raise ValueError(f"`{call}` must be {shape}; got the shape {array.shape}.")
    return array


def times_of(call: str, t: Array, outputs: int) -> Array:
    """The times of outputs, one each."""
    if t.shape != (outputs,) or not np.isfinite(t).all():
        beyond = ", not all finite" if t.shape == (outputs,) else ""
        raise ValueError(
            f"`{call}(t)` must be the time of each of the {outputs} outputs; got the shape {t.shape}{beyond}."
        )
    return t


def by_law(call: str, argument: str, given: Mapping[str, Given]) -> dict[str, Given]:
    """What is given for each law, one at least."""
    if not given:
        raise ValueError(f"`{call}({argument}=...)` must map each law to its numbers; got none.")
    return dict(given)


def scale_of(values: Array) -> Literal["linear", "log"]:
    """The scale of an axis: logarithmic if its numbers are positive and far apart."""
    return "log" if values.min() > 0 and values.max() > DECADE * values.min() else "linear"


def scale_of_shares(estimates: Sequence[Estimate]) -> tuple[float, float]:
    """From 0 as far as parts of a variance reach, and their intervals if they are not much wider than what can be."""
    values = np.concatenate([np.ravel(part.value) for part in estimates])
    ends = np.concatenate([np.ravel(end) for part in estimates for end in (part.low, part.high)])
    ends = np.clip(ends[np.isfinite(ends)], -0.25, 1.25)
    values = values[~np.isnan(values)]
    low = min(0.0, ends.min(initial=0.0), float(values.min(initial=0.0)))
    high = max(0.1, ends.max(initial=0.1), float(values.max(initial=0.1)))
    return float(low - 0.02 * (high - low) * (low < 0)), float(high + 0.02 * (high - low))

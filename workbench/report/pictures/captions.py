"""The common parts of pictures: captions that end with their note, labels, scales, and numbers for a file.

Of every picture the `note` says runs, failed runs, seed and step error. It is read from the source of what is shown,
as `sample.source(metric)` gives it, one for each output or law; or it is words, as `sample.note_of(metric)`.
`unit` is that of the output, and `labels` of factors and outputs, by their names, stand in place of those.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Literal, TypeAlias, TypeVar, cast

import numpy as np

from workbench.core.validation.refusals import Array, Integers, describe, refusal
from workbench.study.document.figure import Figure, Label, Panel
from workbench.study.document.phrases_and_tables import (
    Cell,
    Part,
    Phrase,
    ReportTable,
    TableColumn,
    head_of,
    parts,
    superscript_powers,
)
from workbench.study.document.source import Source
from workbench.study.uncertainty.effects import MorrisEffects, Tornado
from workbench.study.uncertainty.outputs import Estimate
from workbench.study.uncertainty.sobol_indices import SobolIndices

Labels: TypeAlias = Mapping[str, Label] | None
Note: TypeAlias = Phrase | Source | tuple[Source, ...]  # words, or a source for each output or law
DECADE = 10.0  # the ratio of the largest number to the least from which on an axis is logarithmic
BEYOND = "An interval with an arrow goes on beyond the axes."
Result = TypeVar("Result", SobolIndices, MorrisEffects, Tornado)


def picture(
    call: str,
    name: str,
    caption: Phrase,
    note: Note,
    panels: Iterable[Panel],
    headers: Iterable[str | TableColumn],
    rows: Iterable[tuple[Cell, ...]],
    remarks: Iterable[Phrase] = (),
    columns: int = 1,
    lead: bool = False,
    names: Sequence[str] = ("",),
) -> Figure:
    """The figure with its numbers, its caption followed by the remarks and, last, its note.

    With sources each row of numbers, which begins with one of the names, ends with that of the name, or the only one.
    """
    sources = sources_of(call, names, note)
    words = _words_of(sources) if sources else cast(Phrase, note)
    if sources:
        rows = [(*row, head_of(sources[str(row[0]) if len(sources) > 1 else names[0]])) for row in rows]
        headers = (*headers, "of")
    if not any(part.strip() if isinstance(part, str) else True for part in parts(words)):
        raise ValueError(
            f"`{call}(note=...)` must say how many runs a figure shows, how many of them failed, their seed and their "
            "step error, as `sample.source(metric)` does; got an empty one."
        )
    said = [phrase for phrase in (caption, *remarks, words) if phrase]
    text = tuple(part for i, phrase in enumerate(said) for part in (*([" "] if i else []), *_sentence(phrase)))
    named = tuple(TableColumn(head) if isinstance(head, str) else head for head in headers)
    return Figure(name, text, tuple(panels), columns, ReportTable(name, caption, named, tuple(rows)), lead)


def sources_of(call: str, names: Sequence[str], note: Note) -> dict[str, Source]:
    """The sources of a picture by its outputs or laws; none if its note is in words."""
    several = note if isinstance(note, tuple) else (note,)
    found = [source for source in several if isinstance(source, Source)]
    if found and len(found) != len(names):
        raise ValueError(
            f"`{call}(note=...)` must have a source for each of {describe(list(names))}, in their order; got "
            f"{len(found)}."
        )
    return dict(zip(names, found, strict=True)) if found else {}


def _words_of(sources: Mapping[str, Source]) -> str:
    """The notes of sources, each once, with their law where there are several."""
    notes: dict[str, dict[str, None]] = {}
    for source in sources.values():
        notes.setdefault(source.law, {}).update(dict.fromkeys(source.notes))
    several = len(notes) > 1
    return "; ".join(
        "; ".join([f"{law}: {said[0]}" if several else said[0], *said[1:]]) for law, (*said,) in notes.items()
    )


def _sentence(phrase: Phrase) -> tuple[Part, ...]:
    """A phrase that ends with a full stop."""
    last = parts(phrase)[-1]
    ended = isinstance(last, str) and last.rstrip().endswith((".", "!", "?"))
    return parts(phrase) if ended else (*parts(phrase), ".")


def label_of(name: str, labels: Labels) -> Label:
    """The label of a factor or an output: that of `labels`, or else its name."""
    return (labels or {}).get(name, name)


def with_unit(name: Label, unit: str) -> Label:
    """The label of an axis, with its unit in brackets."""
    own = name if isinstance(name, tuple) else (name,)
    return (*own, f" [{superscript_powers(unit)}]") if unit not in ("", "1") else own


def each(result: Result) -> list[Result]:
    """The results of each output that was not refused; those of a single output are themselves."""
    if isinstance(result, Tornado):
        numbers = result.swing
    else:
        numbers = (result.S1 if isinstance(result, SobolIndices) else result.mu_star).value
    return [result] if numbers.ndim == 1 else [result[name] for name in result.names if name not in result.refusals]


def refusals(result: SobolIndices | MorrisEffects | Tornado) -> tuple[str, ...]:
    """A sentence for each output that is not drawn, with the reason."""
    return tuple(f"'{name}' is not drawn: {why}." for name, why in result.refusals.items())


def stretches(curve: Array) -> list[Integers]:
    """The places of each stretch of a curve (N,) without a NaN."""
    known = np.flatnonzero(~np.isnan(curve))
    return [part for part in np.split(known, np.flatnonzero(np.diff(known) > 1) + 1) if part.size]


def number(value: float) -> float | None:
    """A number for a file; a dash if it is unknown."""
    return None if math.isnan(value) else float(value)


def times_of(call: str, t: Array, outputs: int) -> Array:
    """The times of outputs, one each."""
    if t.shape != (outputs,) or not np.isfinite(t).all():
        raise refusal(f"{call}(t)", f"the finite time of each of the {outputs} outputs", t)
    return t


def scale_of(values: Array) -> Literal["linear", "log"]:
    """The scale of an axis: logarithmic if its numbers are positive and far apart."""
    return "log" if values.min() > 0 and values.max() > DECADE * values.min() else "linear"


def scale_of_shares(estimates: Sequence[Estimate]) -> tuple[float, float]:
    """The limits of an axis for parts of a variance: around 0, all values, and intervals within -0.25 and 1.25."""
    values = np.concatenate([np.ravel(part.value) for part in estimates])
    ends = np.concatenate([np.ravel(end) for part in estimates for end in (part.low, part.high)])
    ends = np.clip(ends[np.isfinite(ends)], -0.25, 1.25)
    values = values[~np.isnan(values)]
    low = min(0.0, ends.min(initial=0.0), float(values.min(initial=0.0)))
    high = max(0.1, ends.max(initial=0.1), float(values.max(initial=0.1)))
    return float(low - 0.02 * (high - low) * (low < 0)), float(high + 0.02 * (high - low))

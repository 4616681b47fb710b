"""The origin of each number: stated by a paper, derived from it, or assumed by us.

Examples
--------
>>> wb.provenance.stated_entry("mass", 1.0, "kg", "section 5").mark
'stated'
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.core.validation.refusals import Array, as_array, describe, finite, known_name
from workbench.core.validation.signatures import check_arguments
from workbench.engine.distributions import LogUniform, Uniform
from workbench.engine.factors import Factor, Mark
from workbench.study.document.document import Phrase, ReportTable, TableColumn
from workbench.study.document.phrases_and_tables import superscript_powers
from workbench.study.user_values import UserValue

__all__ = ["Card", "CardEntry", "assumed_entry", "derived_entry", "stated_entry", "value_text"]


@dataclass(frozen=True, eq=False)
@check_arguments
class CardEntry:
    """A number or a named choice with its origin; an assumed number could lie anywhere from `low` to `high`."""

    name: str
    value: UserValue
    unit: str
    mark: Mark
    source: str  # where it stands, what it follows from, or why it is assumed
    low: float | None = None
    high: float | None = None
    label: Phrase = ""  # the name as a report prints it, where that is another one

    def __post_init__(self) -> None:
        array = as_array(self.value)
        if not isinstance(self.value, str) and (array is None or not np.isfinite(array).all()):
            raise ValueError(
                f"`CardEntry({self.name!r}, value=...)` must be a finite number, an array of such, or a named choice "
                f"as text; got {describe(self.value)}."
            )
        ends = [
            finite(f"CardEntry({self.name!r}, low=..., high=...)", e) for e in (self.low, self.high) if e is not None
        ]
        if len(ends) == 2 and ends[0] > ends[1]:
            raise ValueError(
                f"`CardEntry({self.name!r}, low=..., high=...)` must be a range, low <= high; got {ends[0]} and "
                f"{ends[1]}."
            )
        if not self.source:
            raise ValueError(f"`CardEntry({self.name!r}, source=...)` must say where the number comes from.")
        ranged = self.low is not None and self.high is not None
        if self.mark == "assumed" and not isinstance(self.value, str) and not ranged:
            raise ValueError(
                f"`CardEntry({self.name!r})` is assumed, so it needs the range `low` to `high` it could lie in."
            )

    @check_arguments
    def factor(self, paths: Sequence[str], log_scale: bool = False) -> Factor:
        """The number as a factor over the range in which it could lie, with its mark.

        Raises
        ------
        ValueError
            If the number has no range, or a range that no distribution can have.
        """
        if self.low is None or self.high is None:
            raise ValueError(
                f"`CardEntry.factor(paths)` needs a range to vary '{self.name}', which is {self.mark}, in; it has "
                "none: write `Factor(...)` with a distribution of your own."
            )
        spread = LogUniform(self.low, self.high) if log_scale else Uniform(self.low, self.high)
        return Factor(self.name, tuple(paths), spread, self.mark)


def stated_entry(name: str, value: UserValue, unit: str, where: str, label: Phrase = "") -> CardEntry:
    """A number that the paper prints, with section or equation."""
    return CardEntry(name, value, unit, "stated", where, label=label)


def derived_entry(name: str, value: UserValue, unit: str, how: str, label: Phrase = "") -> CardEntry:
    """A number that follows from other ones."""
    return CardEntry(name, value, unit, "derived", how, label=label)


def assumed_entry(
    name: str,
    value: UserValue,
    unit: str,
    why: str,
    low: float | None = None,
    high: float | None = None,
    label: Phrase = "",
) -> CardEntry:
    """A number or choice that the paper does not state, with the reason and the range it could lie in."""
    return CardEntry(name, value, unit, "assumed", why, low, high, label)


@dataclass(frozen=True, eq=False)
@check_arguments
class Card:
    """All numbers of a paper, each once: `card["phi"]` is the value.

    Examples
    --------
    >>> card = wb.provenance.Card((wb.provenance.stated_entry("mass", 1.0, "kg", "section 5"),))
    >>> card["mass"]
    1.0
    """

    entries: tuple[CardEntry, ...]

    def __post_init__(self) -> None:
        names = [given.name for given in self.entries]
        if twice := {name for name in names if names.count(name) > 1}:
            raise ValueError(f"`Card(...)` holds each number once; {sorted(twice)} came more than once.")

    def __iter__(self) -> Iterator[CardEntry]:
        return iter(self.entries)

    def __getitem__(self, name: str) -> UserValue:
        values = {given.name: given.value for given in self.entries}
        return values[known_name(name, values, "numbers on this card")]

    @check_arguments
    def table(self, mark: Mark, name: str, caption: str) -> ReportTable:
        """The numbers of one origin, as a report prints them; assumed ones with their range."""
        ranged = mark == "assumed"
        columns = (
            TableColumn("quantity"),
            TableColumn("value", align="right"),
            TableColumn("unit"),
            *((TableColumn("possible range"),) if ranged else ()),
            TableColumn({"stated": "where", "derived": "how", "assumed": "why"}[mark]),
        )
        rows = tuple(
            (
                g.label or g.name,
                value_text(g.value),
                superscript_powers(g.unit) or None,
                *((_range(g),) if ranged else ()),
                g.source,
            )
            for g in self
            if g.mark == mark
        )
        return ReportTable(name, caption, columns, rows)


def value_text(value: UserValue) -> str:
    """A value as a person writes it down: diag(6, 6), (0.5, 0.4), 0.01."""
    if isinstance(value, str):
        return value
    array = np.asarray(value, dtype=float)
    if array.ndim == 2 and np.array_equal(array, np.diag(np.diag(array))):
        return f"diag({_listed(np.diag(array))})"
    if array.ndim == 2:
        return f"({'; '.join(map(_listed, array))})"
    return f"({_listed(array)})" if array.ndim == 1 else f"{float(array):.6g}"


def _listed(numbers: Array) -> str:
    return ", ".join(f"{number:.6g}" for number in numbers)


def _range(given: CardEntry) -> str | None:
    return None if given.low is None or given.high is None else f"{given.low:g} to {given.high:g}"

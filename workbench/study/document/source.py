"""The source of a mark: the result that a curve, a bar, a point or a cell shows."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import Literal

from workbench.validation.refusals import finite
from workbench.validation.signatures import door


@dataclass(frozen=True)
@door
class Source:
    """One number of a signal over time, or of a metric, of a law in a scenario or a sweep.

    A mark shows `scale` times that number; `unit` is that of what it shows.

    Attributes
    ----------
    kind, name
        A signal or a metric, and its name; of an axis of time "time".
    place, label
        Which of its numbers: counted from 0, a matrix row by row, and by its name.
    run
        The digest of equations, parameters, steps and noise.
    rows
        Of the kept times the first one that is shown and the one behind the last; of a metric nothing.
    title, notes
        The law as tables name it, with its remark, and what they say of it below.
    """

    law: str
    scenario: str
    kind: Literal["time", "signal", "metric"]
    name: str
    place: int
    label: str
    unit: str
    run: str
    rows: tuple[int, int] | None = None
    scale: float = 1.0
    title: str = ""
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        finite("Source(scale=...)", self.scale)

    @property
    def words(self) -> str:
        """The signal or metric in words, with its number: 'e of joint 1'."""
        if self.label.startswith(f"{self.name}["):
            return self.label
        named = not self.label or self.label == self.name or self.name.endswith(f" of {self.label}")
        return self.name if named else f"{self.name} of {self.label}"

    @door
    def times(self, scale: float, unit: str = "") -> Source:
        """The source of so many times the numbers, in a unit of their own if it is given."""
        return replace(self, scale=scale * self.scale, unit=unit or self.unit)


_BREAKS = re.compile(r"\r\n|[\n\r\t]")
# control characters, halves of surrogate pairs, and the two that are no characters in any file of text
_UNREADABLE = re.compile("[\x00-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff]")


def clean_text(text: str) -> str:
    """A text without line breaks and tabs, and with U+FFFD for what no file may hold."""
    return _UNREADABLE.sub("\ufffd", _BREAKS.sub(" ", text))

"""The source of a mark: the result that a curve, a bar, a point or a cell shows."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import Literal

from workbench.core.validation.refusals import finite
from workbench.core.validation.signatures import check_arguments


@dataclass(frozen=True)
@check_arguments
class Source:
    """One number of a signal over time, of a metric, or of a linear answer, of a law in a scenario or a sweep.

    A mark shows `scale` times this number, in the unit `unit`.

    Attributes
    ----------
    kind, name
        "signal", "metric" or "linear", and its name; both are "time" for an axis of time. A linear answer of a loop is
        named as its picture or its table does: "magnitude", "phase margin".
    place, label
        The place of the number in the signal or metric, from 0 and row by row in a matrix, or of the channel at which a
        loop is cut; and its label.
    run
        The digest of equations, parameters, steps and noise.
    rows
        The first kept time that is shown and the one after the last; None for a metric.
    stages, spacing
        For a curve of a plan: how many numbers of the first kept time of `rows` are shown, from `place` on, and the
        time between them in s. 0 for a curve over the kept times.
    title, notes
        The name of the law in tables, with its remark, and the notes on it below a table.
    """

    law: str
    scenario: str
    kind: Literal["time", "signal", "metric", "linear"]
    name: str
    place: int
    label: str
    unit: str
    run: str
    rows: tuple[int, int] | None = None
    scale: float = 1.0
    title: str = ""
    notes: tuple[str, ...] = ()
    stages: int = 0
    spacing: float = 0.0

    def __post_init__(self) -> None:
        finite("Source(scale=...)", self.scale)

    @property
    def words(self) -> str:
        """The signal or metric in words, with its number."""
        if self.label.startswith(f"{self.name}["):
            return self.label
        named = not self.label or self.label == self.name or self.name.endswith(f" of {self.label}")
        return self.name if named else f"{self.name} of {self.label}"

    @check_arguments
    def times(self, scale: float, unit: str = "") -> Source:
        """The source of the number times `scale`, in another unit if it is given."""
        return replace(self, scale=scale * self.scale, unit=unit or self.unit)

    @check_arguments
    def with_name(self, name: str, unit: str = "") -> Source:
        """The source of another linear answer of the same loop at the same channel."""
        return replace(self, name=name, unit=unit)


_BREAKS = re.compile(r"\r\n|[\n\r\t]")
# control characters, halves of surrogate pairs, and the two that are no characters in any file of text
_UNREADABLE = re.compile("[\x00-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff]")


def clean_text(text: str) -> str:
    """A text without line breaks and tabs, and with U+FFFD for what no file may hold."""
    return _UNREADABLE.sub("\ufffd", _BREAKS.sub(" ", text))

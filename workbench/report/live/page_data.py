"""The data of a live page, as its scripts read them: plain values that JSON can hold."""

from __future__ import annotations

from typing import TypeAlias, TypedDict

Plain: TypeAlias = dict[str, object]


class LiveData(TypedDict):
    """The study and its lines in Python, knobs, loops with their modules, and the marks and cells that are theirs.

    `scenario` is the one that is shown first, '' for that of the first loop. `records` are the recorded numbers of
    steps, packed as the modules are, for loops that a log drives. `refused` says, by the name of a case, why no browser
    can run its loop.
    """

    format: int
    study: str
    version: str
    fingerprint: str
    python: str
    python_linear: str
    scenario: str
    knobs: list[Plain]
    specifications: list[Plain]
    loops: list[Plain]
    modules: list[str]
    records: list[str]
    curves: list[Plain]
    cells: list[Plain]
    marks: list[Plain]
    linear_marks: list[Plain]
    refused: dict[str, str]

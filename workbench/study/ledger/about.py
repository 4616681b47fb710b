"""About: how far a study is, in a record that is read without the study and believed in nothing but its words."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from workbench.study.ledger.chunk import Chunk, plain

NAME = "about"


@dataclass(frozen=True)
class SweepAbout:
    """The runs and the chunks of one sweep, as many as are known, and the arithmetic that they are computed in.

    Attributes
    ----------
    at_most
        Whether a search may end before it has asked for all these runs.
    """

    name: str
    runs: int
    arithmetic: str
    chunks: tuple[str, ...]
    at_most: bool = False


@dataclass(frozen=True)
class About:
    """The name and script of a study, the number of samples that was asked for, and its sweeps."""

    study: str
    script: str
    samples: int | None = None
    sweeps: tuple[SweepAbout, ...] = ()

    @property
    def chunk(self) -> Chunk:
        """The record."""
        return Chunk(NAME, plain(asdict(self)))


def about_of(chunk: Chunk) -> About | None:
    """The same read again; None if the record says something else."""
    try:
        said = chunk.said
        sweeps = tuple(map(_sweep, said["sweeps"]))
        samples = None if said["samples"] is None else _count(said["samples"])
        return About(_text(said["study"]), _text(said["script"]), samples, sweeps)
    except (LookupError, TypeError, ValueError):
        return None


def _sweep(said: Any) -> SweepAbout:
    name, arithmetic = _text(said["name"]), _text(said["arithmetic"])
    at_most = said.get("at_most", False) is True  # which an earlier version did not say
    return SweepAbout(name, _count(said["runs"]), arithmetic, tuple(map(_text, said["chunks"])), at_most)


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError(value)
    return value


def _count(value: Any) -> int:
    if type(value) is not int or value < 0:
        raise TypeError(value)
    return value

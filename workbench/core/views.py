"""What the rooms above make of an object that is asked for it: a picture, or a page whose numbers can be turned."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol


class Picture(Protocol):
    """A picture, which a notebook shows."""

    @property
    def svg(self) -> str:
        """The picture as SVG."""

    @property
    def caption(self) -> str:
        """What it says, in words."""

    def savefig(self, path: str | Path) -> Path:
        """Write it to a file; its path."""

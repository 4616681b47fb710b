"""Views of an object, which the rooms above make when it is asked for one: a picture, or a page to turn numbers on."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol, cast

from workbench.core.plot_registry import draw


class NotebookPicture(Protocol):
    """A picture, which a notebook shows."""

    @property
    def svg(self) -> str:
        """The picture as SVG."""

    @property
    def caption(self) -> str:
        """The text below it, which says what is seen."""

    def savefig(self, path: str | Path) -> Path:
        """Write it to a file; its path."""


def picture_of(subject: object, *args: object, **options: object) -> NotebookPicture:
    """The picture of an object of a class whose drawer, which `report` has entered, gives one."""
    return cast(NotebookPicture, draw(subject, *args, **options))


class NotebookPage(Protocol):
    """A page, which a notebook shows."""

    @property
    def text(self) -> str:
        """The page as HTML."""

    @property
    def no_live_reason(self) -> str:
        """Why nothing is turned there; empty where numbers can be."""

    def write(self, path: str | Path) -> Path:
        """Write it to a file; its path."""

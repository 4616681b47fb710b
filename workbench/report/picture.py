"""A figure of a report by itself: for a notebook, and as a file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from inspect import signature
from pathlib import Path

from markupsafe import Markup, escape

from workbench.core.validation.places import other_kind
from workbench.core.validation.refusals import known_name, one_of
from workbench.core.validation.signatures import check_arguments
from workbench.report.pdf import drawing_file
from workbench.report.table_text import plain
from workbench.study.document.figure import Figure
from workbench.study.ledger.durability import write_durably

KINDS = (".svg", ".pdf", ".png")
MOST_LETTERS = 80  # of a caption in the line that stands for a picture


@dataclass(frozen=True)
@check_arguments
class Picture:
    """A drawn figure with its caption, which a notebook shows; `figure` is a block for a section of a report."""

    figure: Figure

    @property
    def svg(self) -> str:
        """The text of the drawing."""
        from workbench.report.figures.figure_sheet import draw  # with matplotlib, which takes longer than all else

        return draw(self.figure)

    @property
    def caption(self) -> str:
        """The caption in plain text: what was found, as margins and turns."""
        return plain(self.figure.caption)

    def __repr__(self) -> str:
        caption = self.caption if len(self.caption) <= MOST_LETTERS else f"{self.caption[:MOST_LETTERS].rstrip()} ..."
        return f"<picture '{self.figure.name}': {caption} `savefig(path)` puts it into a file>"

    def _repr_html_(self) -> str:
        return Markup("<figure>{}<figcaption>{}</figcaption></figure>").format(Markup(self.svg), escape(self.caption))

    @check_arguments
    def savefig(self, path: str | Path) -> Path:
        """Write the drawing to a file, an SVG, a PDF or a PNG by its ending, and give its path.

        Raises
        ------
        ValueError
            If the ending is another.
        LookupError
            If there is no folder for it.
        """
        place = Path(path)
        one_of("savefig(path)'s ending", place.suffix, KINDS)
        if not place.parent.is_dir():
            raise LookupError(f"`savefig({str(place)!r})` must be in a folder that is there; '{place.parent}' is none.")
        if kind := other_kind(place):
            raise LookupError(f"`savefig({str(place)!r})` must be the path of a file; {kind} has this name.")
        drawn = self.svg
        if place.suffix == ".svg":
            write_durably(place, drawn.encode())
        else:
            write_durably(place, drawing_file(drawn, "pdf" if place.suffix == ".pdf" else "png"))
        return place


def known_options(call: str, draw: Callable[..., Picture], options: Mapping[str, object]) -> Mapping[str, object]:
    """The options of a picture; one that it does not have is refused by its name."""
    _, *allowed = signature(draw).parameters
    for name in options:
        known_name(name, allowed, f"options of `{call}`")
    return options

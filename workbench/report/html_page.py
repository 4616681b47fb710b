"""One self-contained HTML page: no network, its maths font inside, and no script unless it is live."""

from __future__ import annotations

import re
from base64 import b64encode
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

from markupsafe import Markup, escape

from workbench.core.notation import mathml
from workbench.core.notation.formula import Formula
from workbench.core.templates import fill, template_bytes, template_text
from workbench.report.figures import sheets as sheets_of
from workbench.report.figures.dark_colors import colors_of, dark_scheme, with_variables
from workbench.report.live.page_data import LiveData
from workbench.report.live_page import PRINT_POLICY, live_page
from workbench.report.number_text import NumberText, join_units
from workbench.report.outline import (
    PlacedBlock,
    chapters,
    findings,
    labels,
    legend,
    notes,
    provenance,
    resolve_references,
)
from workbench.report.table_text import CellText, alignments, grid, plain, short_columns, unit_of_column
from workbench.study.document.document import Code, CrossReference, Document, Part, Phrase, ReportTable, Strong, parts

if TYPE_CHECKING:
    from workbench.report.figures.plates import FigureSheet

GENERATOR = "control-workbench"
ROOM = 72  # widths of a digit between the margins of an equation; the font of the page runs wider than typst's


def html(
    document: Document,
    sheets: dict[str, FigureSheet] | None = None,
    live: LiveData | None = None,
    bench: bool = False,
) -> str:
    """The document as one HTML page, every text escaped: the same document, the same bytes.

    `sheets` are the drawn figures by name, if they have been drawn already; with `live`, the data of `live_data`, a
    reader of the page can turn its knobs. On a `bench` all figures stand above all words, and the knobs are open.
    """
    writer = _Writer(labels(document))
    figures = sheets or sheets_of(document)
    drawings = {name: with_variables(sheet.svg) for name, sheet in figures.items()}
    cells = {} if live is None else {(c["table"], c["row"], c["column"]): i for i, c in enumerate(live["cells"])}
    page = fill(
        "workbench.report",
        "page.html.j2",
        document=document,
        chapters=chapters(document),
        findings=findings(document),
        legend=legend(document),
        provenance=provenance(document),
        generator=GENERATOR,
        style=Markup(_style(bench)) + _dark_style(sheet.svg for sheet in figures.values()),
        bench=bench,
        phrase=writer.phrase,
        formula=writer.formula,
        unlinked=writer.without_links,
        plain=writer.plain,
        rows=writer.rows,
        alignments=alignments,
        short_columns=short_columns,
        notes=notes(document),
        unit_of=unit_of_column,
        drawing=lambda name: Markup(drawings[name]),
        live=None if live is None else live_page(live, {name: sheet.plate for name, sheet in figures.items()}),
        live_cell=lambda *place: cells.get(place),
        printed=PRINT_POLICY,
    )
    return page.removesuffix("\n")


@dataclass(frozen=True)
class _Writer:
    """The writer of the parts of a document as markup, with the numbers of its blocks."""

    known: Mapping[str, PlacedBlock]

    def phrase(self, phrase: Phrase) -> Markup:
        """The parts in a line."""
        return Markup("").join(self._part(part) for part in parts(phrase))

    def without_links(self, phrase: Phrase) -> Markup:
        """A phrase without links, for a text that is a link itself."""
        return self.phrase(resolve_references(phrase, self.known))

    def plain(self, phrase: Phrase) -> str:
        """A phrase without markup, for attributes."""
        return plain(resolve_references(phrase, self.known))

    def _part(self, part: Part) -> Markup:
        match part:
            case str():
                return escape(join_units(part))
            case Code():
                return Markup("<code>{}</code>").format(_with_breaks(part.text))
            case Strong():
                return Markup("<strong>{}</strong>").format(join_units(part.text))
            case CrossReference():
                placed = self.known[part.name]
                return Markup('<a href="#{}">{}</a>').format(placed.anchor, placed.label)
        return self.formula(part, display=False)

    @staticmethod
    def formula(formula: Formula, display: bool = True) -> Markup:
        """A formula in MathML."""
        return Markup(mathml.emit(formula, width=ROOM, display=display))

    def rows(self, table: ReportTable) -> list[list[Markup]]:
        """The cells of a table."""
        return [[self._cell(shown) for shown in row] for row in grid(table)]

    def _cell(self, shown: CellText) -> Markup:
        body = _number(shown) if isinstance(shown.content, NumberText) else self.phrase(shown.content)
        return Markup("<strong>{}</strong>").format(body) if shown.bold else body


def _with_breaks(code: str) -> Markup:
    """A name or a path with places to break its line, which leave no trace in copied text."""
    return Markup("<wbr>").join(re.split(r"(?<=[./_,=])(?=\w)", code))


def _number(shown: CellText) -> Markup:
    """A number between invisible digits that align its decimal point with those of its column."""
    number, frame = shown.content, shown.padding
    assert isinstance(number, NumberText)
    power = Markup("{}<sup>{}</sup>").format(TIMES_TEN, number.power) if number.power else Markup("")
    missing = Markup("")
    if frame.power:
        missing = (Markup("") if number.power else _pad(TIMES_TEN)) + Markup("<sup>{}</sup>").format(_pad(frame.power))
    body = f"{number.sign}{number.whole}{number.tail}"
    return Markup('<span class="number">{}{}{}{}{}</span>').format(
        _pad(frame.before), body, power, _pad(frame.behind), missing
    )


TIMES_TEN = "\u2009×\u200910"


def _pad(body: str) -> Markup:
    """Space of the width of some digits, which is no text for copying or reading aloud."""
    return Markup('<span class="pad" data-pad="{}"></span>').format(body) if body else Markup("")


@cache
def _style(bench: bool) -> str:
    """The style sheet with the maths font inside it, and that of a bench behind it."""
    font = b64encode(template_bytes("workbench.report", "math.woff2")).decode("ascii")
    style = template_text("workbench.report", "style.css").replace("MATHS_FONT", f"data:font/woff2;base64,{font}")
    return style + template_text("workbench.report", "bench.css") if bench else style


def _dark_style(drawings: Iterable[str]) -> Markup:
    """The style sheet of the page in the dark, with the colours of its drawings."""
    colors = {"#000000", "#ffffff", "#dddddd"}.union(*map(colors_of, drawings))  # and those of live rulers
    return Markup(template_text("workbench.report", "dark.css").replace("FIGURE_COLORS", dark_scheme(colors)))

"""The same document as a PDF: the only door to typst."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import typst

from workbench.core.notation import typst_math
from workbench.core.templates import template_bytes
from workbench.report.figures import drawings as drawings_of
from workbench.report.number_text import NumberText, join_units
from workbench.report.outline import (
    Chapter,
    PlacedBlock,
    chapters,
    findings,
    labels,
    legend,
    notes,
    provenance,
    resolve_references,
)
from workbench.report.table_text import CellText, alignments, grid, length, plain, unit_of_column
from workbench.study.document.document import (
    Code,
    CrossReference,
    Document,
    Equation,
    Figure,
    Finding,
    Itemize,
    Paragraph,
    Part,
    Phrase,
    ReportTable,
    Strong,
    Verdict,
    parts,
)

MAX_HEADER_LETTERS = 85  # letters of the title that fit in the header of a page
LONGEST = 20_000  # letters of a phrase that are printed, some seven pages: typst takes minutes for a million
REST = "… The rest is on the page."
ROOM = 80  # widths of a digit between an equation's margins
TALL = 240.0  # points: with its caption and a heading it takes half of a page
SUSPECTS = b"/Suspects false"
ALONE = b"""#set page(width: auto, height: auto, margin: 0pt)
#image(bytes(sys.inputs.svg), format: "svg")"""
OTHER_SCRIPTS = "\u2e80"  # from here on the fonts of typst have no letters

Tree = dict[str, object]


def pdf(document: Document, drawings: dict[str, str] | None = None) -> bytes:
    """The document as a PDF of A4 pages: the same document, the same bytes.

    Its fonts are those of typst; only for scripts that they lack, as Chinese, the machine's own. No text of the
    document is read as typst: it all goes in as data. Of a phrase with more than 20 000 letters the PDF has the first
    ones, and says that the page has them all. `drawings` are as in `html`.

    Raises
    ------
    ValueError
        If typst cannot set the document, as when a formula's notation is wrong; with what it said.
    """
    return compile_pdf(data(document, drawings))


def data(document: Document, drawings: dict[str, str] | None = None) -> str:
    """The document as the JSON text that `report.typ` reads."""
    figures = drawings or drawings_of(document)
    tree = _Writer(labels(document), figures, notes(document)).document(document)
    return json.dumps(tree, ensure_ascii=False)


def compile_pdf(data: str) -> bytes:
    """The PDF of the text that `data` gives, refused as by `pdf`; typst releases the interpreter's lock."""
    source = template_bytes("workbench.report", "report.typ")
    covered = max(data) < OTHER_SCRIPTS
    try:
        return _without_suspects(typst.compile(source, sys_inputs={"document": data}, ignore_system_fonts=covered))
    except typst.TypstError as error:
        title = json.loads(data)["title"]
        raise ValueError(
            f"`pdf(document)` could not set '{title}': typst says: {error.message}. "
            "Look at the formulas of the document first: all else goes in as plain text."
        ) from error


def drawing_file(svg: str, kind: Literal["pdf", "png"]) -> bytes:
    """A drawing by itself as a file: "pdf", or "png" with 200 pixels an inch."""
    return typst.compile(ALONE, format=kind, ppi=200.0, sys_inputs={"svg": svg}, ignore_system_fonts=True)


def _without_suspects(content: bytes) -> bytes:
    """A tagged PDF without the entry `/Suspects false`, the default, of its catalogue, which stands behind all else.

    Poppler up to 25.11 calls this boolean "wrong type" on every opening. Blanks take the place of the entry, so that
    the table of offsets still holds.
    """
    before, entry, after = content.rpartition(SUSPECTS)
    return before + b" " * len(entry) + after


@dataclass(frozen=True)
class _Writer:
    """A document as the tree of plain data that `report.typ` reads."""

    known: Mapping[str, PlacedBlock]
    drawings: Mapping[str, str]
    notes: Mapping[str, tuple[Phrase, ...]]

    def document(self, document: Document) -> Tree:
        colophon, title = document.colophon, document.title
        return {
            "title": join_units(self.short(title)),
            "running": title if len(title) <= MAX_HEADER_LETTERS else f"{title[: MAX_HEADER_LETTERS - 1].rstrip()}…",
            "imprint": f"control-workbench {colophon.version}",
            "answer": self.phrase(document.answer),
            "findings": [self.finding(placed) for placed in findings(document)],
            "legend": [{"word": kind, "meaning": words} for kind, words in legend(document)],
            "question": self.phrase(document.question),
            "method": self.phrase(document.method),
            "command": self.short(colophon.command),
            "chapters": [
                {
                    "number": chapter.number,
                    "heading": self.phrase(chapter.heading),
                    "blocks": [self.block(placed, floats=placed in moving) for placed in chapter.blocks],
                }
                for chapter in chapters(document)
                for moving in [_floating(chapter, self.drawings)]
            ],
            "provenance": [list(map(self.short, row)) for row in provenance(document)],
            "again": document.colophon.again,
        }

    def block(self, placed_block: PlacedBlock, *, floats: bool = False) -> Tree:
        tree: Tree = {"floats": floats, "kind": placed_block.kind, "number": placed_block.number}
        tree |= {"label": placed_block.label, "anchor": placed_block.anchor}
        match placed_block.block:
            case Paragraph(text):
                tree["text"] = self.phrase(text)
            case Itemize(items):
                tree["items"] = [self.phrase(item) for item in items]
            case Equation() as equation:
                tree["lines"] = [typst_math.emit(line, width=ROOM) for line in equation.lines]
                tree["note"] = self.phrase(equation.note)
            case Verdict(kind, statement, evidence):
                tree |= {"word": kind, "statement": self.phrase(statement), "evidence": self.phrase(evidence)}
            case Figure(name, caption) as figure:
                alt = plain(resolve_references(caption, self.known))
                drawn = {"svg": self.drawings[name], "share": figure.width}
                tree |= {"caption": self.phrase(caption), "alt": alt, **drawn}
            case ReportTable() as table:
                tree |= self.table(table)
        return tree

    def finding(self, placed_block: PlacedBlock) -> Tree:
        one = placed_block.block
        assert isinstance(one, Finding)
        others = "; ".join("report {}, finding {}".format(*cited.split("/")) for cited in one.cites)
        cites = (("See also", others),) if one.cites else ()
        return {
            "anchor": placed_block.anchor,
            "word": one.kind,
            "statement": self.phrase(one.statement),
            "evidence": self.phrase(one.evidence),
            "change": self.phrase(one.change),
            "scope": [{"label": label, "phrase": self.phrase(text)} for label, text in (*one.scope, *cites)],
            "variations": [
                {
                    "question": question,
                    "rows": [
                        {
                            "words": self.short(each.words),
                            "answer": self.short(each.answer),
                            "detail": self.short(each.detail),
                            "bold": each.answer != one.answer,
                        }
                        for each in variations
                    ],
                }
                for question, variations in one.by_question
            ],
        }

    def table(self, table: ReportTable) -> Tree:
        cells = grid(table)
        columns = [
            {
                "header": self.phrase(column.header),
                "unit": unit_of_column(column),
                "align": align,
                "width": column.width or 0,
                "length": max([length(row[i]) for row in cells], default=0),
                "numbers": align != "left" and any(isinstance(row[i].content, NumberText) for row in cells),
            }
            for i, (column, align) in enumerate(zip(table.columns, alignments(table), strict=True))
        ]
        return {
            "caption": self.phrase(table.caption),
            "columns": columns,
            "key": _key(table),  # each part of a wide table repeats these columns
            "rows": [[self.cell(shown) for shown in row] for row in cells],
            "notes": [self.phrase(note) for note in self.notes[table.name]],
        }

    def cell(self, cell_text: CellText) -> Tree:
        if not isinstance(cell_text.content, NumberText):
            return {"kind": "phrase", "phrase": self.phrase(cell_text.content), "bold": cell_text.bold}
        number, frame = cell_text.content, cell_text.padding
        text = f"{number.sign}{number.whole}{number.tail}"
        tree: Tree = {"kind": "number", "before": frame.before, "text": text, "behind": frame.behind}
        return tree | {"power": number.power, "missing": frame.power, "bold": cell_text.bold}

    def phrase(self, phrase: Phrase) -> list[Tree]:
        pieces: list[Tree] = []
        room = LONGEST
        for part in parts(phrase):
            if part == "":
                continue
            piece = self._part(part)
            pieces.append(piece)
            room -= len(str(piece["text"]))
            if room < 0:
                if piece["kind"] != "math":
                    piece["text"] = str(piece["text"])[:room]
                return [*pieces, {"kind": "text", "text": REST}]
        return pieces

    @staticmethod
    def short(text: str) -> str:
        """A text cut to the number of letters that are printed."""
        return text if len(text) <= LONGEST else text[:LONGEST] + REST

    def _part(self, part: Part) -> Tree:
        match part:
            case str():
                return {"kind": "text", "text": join_units(part)}
            case Code():
                return {"kind": "code", "text": part.text}
            case Strong():
                return {"kind": "strong", "text": join_units(part.text)}
            case CrossReference():
                placed = self.known[part.name]
                return {"kind": "link", "to": placed.anchor, "text": placed.label}
        return {"kind": "math", "text": typst_math.emit(part, width=math.inf)}


def _key(table: ReportTable) -> list[int]:
    """The first columns that tell the rows of a table apart, without those that are not needed for it.

    It is the first column alone if the rows do not differ before the last column.
    """

    def distinct(columns: Sequence[int]) -> bool:
        return len({str([row[i] for i in columns]) for row in table.rows}) == len(table.rows)

    starts = (list(range(k)) for k in range(1, len(table.columns)))
    key = next((start for start in starts if distinct(start)), [0])
    for column in key[:0:-1]:
        fewer = [other for other in key if other != column]
        key = fewer if distinct(fewer) else key
    return key


def _floating(chapter: Chapter, drawings: Mapping[str, str]) -> set[PlacedBlock]:
    """The figures that move to the next edge of a page, so that the text after them fills the page.

    They are tall, or stand alone between other blocks; a figure behind one that moves, too, keeps their order. Nothing
    moves that only figures follow.
    """
    last = max((k for k, placed in enumerate(chapter.blocks) if placed.kind != "figure"), default=0)
    found: set[PlacedBlock] = set()
    moves = False
    kinds = ["", *(placed.kind for placed in chapter.blocks[:last]), ""]
    for before, placed, after in zip(kinds, chapter.blocks[:last], kinds[2:], strict=False):
        if not isinstance(placed.block, Figure):
            moves = False
            continue
        alone = before not in ("", "figure") and after != "figure"
        moves = moves or alone or _height(drawings[placed.block.name]) > TALL
        if moves:
            found.add(placed)
    return found


def _height(drawing: str) -> float:
    """The height of a drawing in points; 0 if its SVG does not say so."""
    found = re.search(r'<svg[^>]* height="([0-9.]+)pt"', drawing)
    return float(found[1]) if found else 0.0

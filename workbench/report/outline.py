"""The numbers and anchors of a document's blocks, the same on the page and in the PDF."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

from workbench.report.table_text import BRACKETS, measures
from workbench.study.document.document import (
    Block,
    CrossReference,
    Document,
    Equation,
    Figure,
    Finding,
    Phrase,
    ReportTable,
    Verdict,
    parts,
)

ROWS = 40  # of digests, one below the other
MEANINGS = {
    "holds": "proved, or confirmed by an exact computation",
    "fails": "refuted by a witness or a proof",
    "found": "measured; every variation in this study gives the same answer",
    "depends": "measured; a variation in this study gives another answer",
    "open": "not settled by this study",
}
OF_A_RUN = "the first digits of the SHA-256 of equations, parameters, initial state, steps and horizon"


@dataclass(frozen=True, eq=False)
class PlacedBlock:
    """A block with its kind ('table'), its number among its kind, and its anchor ('table-2')."""

    block: Block | Finding
    kind: str
    number: int

    @property
    def anchor(self) -> str:
        """The target of links to the block: 'table-2'; of a finding, which other reports cite, by its name."""
        return f"{self.kind}-{self.block.name if isinstance(self.block, Finding) else self.number}"

    @property
    def label(self) -> str:
        """The name of the block in a sentence: 'Table 2', 'Equation (3)'."""
        number = f"({self.number})" if self.kind == "equation" else str(self.number)
        return f"{self.kind.capitalize()}\u00a0{number}"


@dataclass(frozen=True, eq=False)
class Chapter:
    """A section with its number and its placed blocks."""

    number: int
    heading: Phrase
    blocks: tuple[PlacedBlock, ...]


def chapters(document: Document) -> tuple[Chapter, ...]:
    """The sections in order; each kind of block is counted through the whole document."""
    count: Counter[str] = Counter()
    found = []
    for number, section in enumerate(document.sections, start=1):
        placed = []
        for block in section.blocks:
            kind = type(block).__name__.removeprefix("Report").lower()
            count[kind] += 1
            placed.append(PlacedBlock(block, kind, count[kind]))
        found.append(Chapter(number, section.heading, tuple(placed)))
    return tuple(found)


def labels(document: Document) -> dict[str, PlacedBlock]:
    """The placed block behind each name that a `CrossReference` may use."""
    blocks = (placed for chapter in chapters(document) for placed in chapter.blocks)
    return {
        placed.block.name: placed
        for placed in (*findings(document), *blocks)
        if isinstance(placed.block, (Finding, ReportTable, Figure, Equation)) and placed.block.name
    }


def findings(document: Document) -> tuple[PlacedBlock, ...]:
    """The findings with their numbers."""
    return tuple(PlacedBlock(one, "finding", number) for number, one in enumerate(document.findings, start=1))


def legend(document: Document) -> tuple[tuple[str, str], ...]:
    """The words beside the boxes of a document, each with its meaning, in the order of `MEANINGS`."""
    kinds = {block.kind for block in (*document.findings, *document.blocks) if isinstance(block, Finding | Verdict)}
    return tuple((kind, words) for kind, words in MEANINGS.items() if kind in kinds)


def notes(document: Document) -> dict[str, tuple[Phrase, ...]]:
    """The notes below each table by its name; the first that holds measured values explains their brackets."""
    found = {table.name: table.notes for table in document.tables}
    for table in document.tables:
        if measures(table):
            return found | {table.name: (BRACKETS, *table.notes)}
    return found


def resolve_references(phrase: Phrase, places: Mapping[str, PlacedBlock]) -> Phrase:
    """A phrase in which each reference is the label of its block."""
    return tuple(places[p.name].label if isinstance(p, CrossReference) else p for p in parts(phrase))


def provenance(document: Document) -> tuple[tuple[str, str], ...]:
    """The lines of the colophon, as pairs of a term and its text."""
    colophon = document.colophon
    rows = [
        ("command", colophon.command),
        ("control-workbench", colophon.version),
        ("seed", "none: nothing here is random" if colophon.seed is None else str(colophon.seed)),
        ("arithmetic", colophon.arithmetic),
        *_hexadecimal("fingerprint", colophon.fingerprints),
        ("digest", OF_A_RUN if colophon.digests else ""),
        *_hexadecimal("digest", colophon.digests),
        ("Python", colophon.python),
        ("packages", ", ".join(f"{name} {version}" for name, version in colophon.packages.items())),
    ]
    return tuple((term, words) for term, words in rows if words)


def _hexadecimal(word: str, prints: Mapping[str, str]) -> list[tuple[str, str]]:
    """A row for each name; many of them in one row, each digest once with all names that have it."""
    if len(prints) <= ROWS:
        return [(f"{word} of {name}", digest) for name, digest in prints.items()]
    bearers: dict[str, list[str]] = {}
    for name, digest in prints.items():
        bearers.setdefault(digest, []).append(name)
    return [(f"{word}s", "; ".join(f"{digest} of {', '.join(names)}" for digest, names in bearers.items()))]

"""What a study says, as data: words, equations, tables, figures and verdicts, and nothing about their looks.

No date, no running time and no path of a machine is part of a document: the same study gives the same bytes.
"""

from __future__ import annotations

import difflib
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias, get_args

from workbench.study.document.blocks import Equation, Itemize, Paragraph, Verdict
from workbench.study.document.cells import (
    Cell,
    Code,
    Column,
    Diverged,
    Emphasis,
    Measured,
    Part,
    Phrase,
    Reference,
    Strong,
    Table,
    Value,
    check_name,
    check_phrase,
    check_text,
    described,
    is_whole,
    parts,
    plain_words,
    several,
    texts,
)
from workbench.study.document.curves import Band, Label, Series, Style
from workbench.study.document.panel import Panel
from workbench.study.document.shapes import Bars, HeatMap, Mark, Points, Tiles
from workbench.validation.views import show

__all__ = [
    "Band",
    "Bars",
    "Block",
    "Cell",
    "Code",
    "Colophon",
    "Column",
    "Diverged",
    "Document",
    "Emphasis",
    "Equation",
    "Figure",
    "HeatMap",
    "Itemize",
    "Label",
    "Mark",
    "Measured",
    "Panel",
    "Paragraph",
    "Part",
    "Phrase",
    "Points",
    "Reference",
    "Section",
    "Series",
    "Strong",
    "Style",
    "Table",
    "Tiles",
    "Value",
    "Verdict",
    "parts",
]


@dataclass(frozen=True)
@show
class Figure:
    """One or more panels below a common legend, laid out row by row in so many `columns`.

    With `lead` the first panel has the whole width, above the others. `numbers` are what the figure shows, for a reader
    who goes on with them: a table of its own file, not printed.
    """

    name: str
    caption: Phrase
    panels: tuple[Panel, ...]
    columns: int = 1
    numbers: Table | None = None
    lead: bool = False

    def __post_init__(self) -> None:
        check_name("Figure", self.name)
        check_phrase(f"Figure('{self.name}', caption=...)", self.caption)
        panels = several(f"Figure('{self.name}', panels=...)", self.panels, Panel, "panel")
        object.__setattr__(self, "panels", panels)
        if not (self.panels and is_whole(self.columns) and 1 <= self.columns <= 3):
            raise ValueError(
                f"`Figure('{self.name}')` must have at least one panel, in 1 to 3 columns, to fit a page; "
                f"got {len(self.panels)} panels and for the columns {described(self.columns)}."
            )
        object.__setattr__(self, "columns", int(self.columns))
        if not isinstance(self.lead, bool):
            raise ValueError(f"`Figure('{self.name}', lead=...)` must be True or False; got {described(self.lead)}.")
        if not isinstance(self.numbers, Table | None):
            raise ValueError(f"`Figure('{self.name}', numbers=...)` must be a `Table`; got {described(self.numbers)}.")


Block: TypeAlias = Paragraph | Itemize | Equation | Table | Figure | Verdict


@dataclass(frozen=True)
@show
class Section:
    """A heading and what stands below it.

    Examples
    --------
    >>> wb.Section("What was found", (wb.Paragraph("All runs settled."),)).heading
    'What was found'
    """

    heading: Phrase
    blocks: tuple[Block, ...]

    def __post_init__(self) -> None:
        check_phrase("Section(heading)", self.heading)
        call = f"Section({plain_words(self.heading)!r}, blocks)"
        blocks = several(call, self.blocks, (*get_args(Block), str, tuple), "block")
        for block in blocks:
            if isinstance(block, (str, tuple)):
                raise ValueError(
                    f"`{call}` is made of blocks; got {type(block).__name__}: wrap text in `Paragraph(...)`."
                )
        object.__setattr__(self, "blocks", blocks)


@dataclass(frozen=True)
class Colophon:
    """How to get this report again: the command, the seed, and what the numbers were made of.

    `fingerprints` maps names to the hexadecimal digest of equations alone, `digests` to that of equations and numbers,
    `packages` the name of a package to its version; `arithmetic` is the signature of that in which the loops were run;
    `again` says what the same command would give.
    """

    command: str
    version: str
    fingerprints: Mapping[str, str] = field(default_factory=dict)
    seed: int | str | None = None
    packages: Mapping[str, str] = field(default_factory=dict)
    python: str = ""
    arithmetic: str = ""
    again: str = "The same command with the same versions gives this report again, byte for byte."
    digests: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("command", "version", "python", "again"):
            check_text(f"Colophon({name}=...)", getattr(self, name))
        for name in ("fingerprints", "digests", "packages"):
            given = getattr(self, name)
            if not isinstance(given, Mapping):
                raise ValueError(f"`Colophon({name}=...)` must map names to texts; got {described(given)}.")
            for part in (*given.keys(), *given.values()):
                check_text(f"Colophon({name}=...)", part)
        if not (isinstance(self.seed, str | None) or (is_whole(self.seed) and abs(self.seed) < 10**300)):
            raise ValueError(
                f"`Colophon(seed=...)` must be a whole number below 1e300, text or None; got {described(self.seed)}."
            )


@dataclass(frozen=True)
@show
class Document:
    """A report: its question, its method, its sections, and how to get it again.

    Raises
    ------
    ValueError
        If two blocks bear the same name, or what should be text is not.
    LookupError
        If a `Reference` names no block; the message names the nearest.
    """

    title: str
    question: Phrase
    method: Phrase
    sections: tuple[Section, ...]
    colophon: Colophon
    subtitle: str = ""
    authors: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for name in ("title", "subtitle"):
            check_text(f"Document({name}=...)", getattr(self, name))
        check_phrase("Document(question=...)", self.question)
        check_phrase("Document(method=...)", self.method)
        object.__setattr__(self, "authors", texts("Document(authors=...)", self.authors))
        object.__setattr__(self, "sections", several("Document(sections=...)", self.sections, Section, "section"))
        if not isinstance(self.colophon, Colophon):
            raise ValueError(f"`Document(colophon=...)` must be a `Colophon`; got {described(self.colophon)}.")
        names = [b.name for b in self.blocks if isinstance(b, (Table, Figure, Equation)) and b.name]
        if twice := sorted(name for name, count in Counter(names).items() if count > 1):
            raise ValueError(f"`Document(...)` needs distinct names of its blocks; {twice} came more than once.")
        for name in self._references():
            if name not in names:
                near = difflib.get_close_matches(name, names, n=1)
                hint = f" Did you mean '{near[0]}'?" if near else f" The names are: {', '.join(names) or 'none'}."
                raise LookupError(f"`Reference('{name[:80]}')` names no table, figure or equation here.{hint}")

    @property
    def blocks(self) -> tuple[Block, ...]:
        """All blocks in reading order."""
        return tuple(block for section in self.sections for block in section.blocks)

    @property
    def tables(self) -> tuple[Table, ...]:
        """The tables in reading order: the first is Table 1."""
        return tuple(block for block in self.blocks if isinstance(block, Table))

    @property
    def figures(self) -> tuple[Figure, ...]:
        """The figures in reading order: the first is Figure 1."""
        return tuple(block for block in self.blocks if isinstance(block, Figure))

    @property
    def equations(self) -> tuple[Equation, ...]:
        """The equations in reading order: the first is Equation (1)."""
        return tuple(block for block in self.blocks if isinstance(block, Equation))

    def _references(self) -> Iterator[str]:
        for held in _walk((self.question, self.method, self.sections)):
            if isinstance(held, Reference):
                yield held.name


def _walk(held: Any) -> Iterator[Any]:
    """Every phrase part of a document, depth first; what cannot hold a reference is not entered."""
    yield held
    if isinstance(held, tuple):
        for item in held:
            yield from _walk(item)
    elif isinstance(held, (Section, Paragraph, Itemize, Equation, Table, Figure, Verdict, Emphasis)):
        for item in vars(held).values():
            yield from _walk(item)

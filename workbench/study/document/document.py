"""The document of a study as data: words, equations, tables, figures and verdicts, without their layout.

No date, no running time and no path of a machine is part of a document: the same study gives the same bytes.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, is_dataclass, replace
from typing import ClassVar, Literal, TypeAlias

from workbench.core.notation.formula import Formula
from workbench.core.validation.refusals import known_name, refusal
from workbench.core.validation.signatures import check_arguments
from workbench.study.document.figure import (
    Band,
    Bars,
    Figure,
    Panel,
    Points,
    Series,
)
from workbench.study.document.finding import Finding, Variation
from workbench.study.document.phrases_and_tables import (
    BoldCell,
    Cell,
    Code,
    CrossReference,
    DivergedCell,
    MissingCell,
    Part,
    Phrase,
    ReportTable,
    Strong,
    TableColumn,
    Value,
    ValueWithError,
    check_name,
    parts,
)
from workbench.study.document.source import Source, clean_text

__all__ = [
    "Band",
    "Bars",
    "Block",
    "Cell",
    "Code",
    "Colophon",
    "TableColumn",
    "DivergedCell",
    "Document",
    "BoldCell",
    "Equation",
    "Figure",
    "Finding",
    "Itemize",
    "ValueWithError",
    "MissingCell",
    "Page",
    "Panel",
    "Paragraph",
    "Part",
    "Phrase",
    "Points",
    "CrossReference",
    "Section",
    "Series",
    "Source",
    "Strong",
    "ReportTable",
    "Value",
    "Variation",
    "Verdict",
    "parts",
]

MOST_FINDINGS = 5  # boxes below the answer, which fit on one or two screens


@dataclass(frozen=True)
@check_arguments
class Paragraph:
    """Running text.

    Examples
    --------
    >>> wb.Paragraph("All runs settled.").text
    'All runs settled.'
    """

    text: Phrase

    WAYS: ClassVar[Mapping[str, str]] = {"str": "wrap text in `Paragraph(...)`"}


@dataclass(frozen=True)
@check_arguments
class Itemize:
    """A list of points.

    Examples
    --------
    >>> len(wb.document.Itemize(("One thing.", "Another.")).items)
    2
    """

    items: tuple[Phrase, ...]


@dataclass(frozen=True)
@check_arguments
class Equation:
    """Formulas, one per line, with one equation number, a `name` for references, and a `note` on the source.

    Examples
    --------
    >>> wb.document.Equation(wb.notation.symbol("tau"), name="torque").name
    'torque'
    """

    formulas: Formula | tuple[Formula, ...]
    name: str = ""
    note: Phrase = ""

    def __post_init__(self) -> None:
        if self.name:
            check_name("Equation", self.name)
        if not self.lines:
            raise ValueError("`Equation(formulas)` must have at least one formula to number; got none.")

    @property
    def lines(self) -> tuple[Formula, ...]:
        """The formulas, one per line."""
        return self.formulas if isinstance(self.formulas, tuple) else (self.formulas,)


@dataclass(frozen=True)
@check_arguments
class Verdict:
    """A claim that `holds`, `fails` or is `open`, with its evidence, such as a bound or a witness, in one box.

    A conclusion from runs is a `Finding`.

    Examples
    --------
    >>> wb.document.Verdict("holds", "The loop is stable.", "All poles decay.").kind
    'holds'
    """

    kind: Literal["holds", "fails", "open"]
    statement: Phrase
    evidence: Phrase = ""


Block: TypeAlias = Paragraph | Itemize | Equation | ReportTable | Figure | Verdict


@dataclass(frozen=True)
@check_arguments
class Section:
    """A heading and the blocks below it.

    Examples
    --------
    >>> wb.Section("What was found", (wb.Paragraph("All runs settled."),)).heading
    'What was found'
    """

    heading: Phrase
    blocks: tuple[Block, ...]


@dataclass(frozen=True)
@check_arguments
class Page:
    """The first screen of a report and the sections below it: the answer in one line, then at most five findings.

    Examples
    --------
    >>> wb.Page("All runs settle within 2 s.", (), (wb.Section("Runs", ()),)).answer
    'All runs settle within 2 s.'
    """

    answer: Phrase
    findings: tuple[Finding, ...]
    sections: tuple[Section, ...]

    def __post_init__(self) -> None:
        if len(self.findings) > MOST_FINDINGS:
            raise refusal(
                "Page(findings=...)",
                f"at most {MOST_FINDINGS} findings, as nobody reads more; tables in the sections hold the rest",
                [one.name for one in self.findings],
            )


@dataclass(frozen=True)
class Colophon:
    """The record from which a report can be made again: command, seed, versions and digests.

    `fingerprints` maps names to the hexadecimal digest of equations alone, `digests` to that of equations and numbers;
    `arithmetic` is the signature of that of the runs; `again` says what the same command would give.
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


@dataclass(frozen=True)
class Document:
    """A report: its question, its answer and findings, its method, its sections, and the record to make it again.

    In its texts a line break or tab becomes a space, and what no file may hold, as a control character, U+FFFD.

    Raises
    ------
    ValueError
        If two blocks bear the same name.
    LookupError
        If a `CrossReference` names no block; the message names the nearest.
    """

    title: str
    question: Phrase
    method: Phrase
    sections: tuple[Section, ...]
    colophon: Colophon
    answer: Phrase = ""
    findings: tuple[Finding, ...] = ()

    def __repr__(self) -> str:
        """One line: the title and the number of sections."""
        return f"<Document {self.title!r} of {len(self.sections)} sections>"

    def __post_init__(self) -> None:
        for name in [one.name for one in fields(self)]:
            object.__setattr__(self, name, _cleaned(getattr(self, name)))
        blocks = (b for b in self.blocks if isinstance(b, ReportTable | Figure | Equation) and b.name)
        names = [block.name for block in (*self.findings, *blocks)]
        if twice := sorted(name for name, count in Counter(names).items() if count > 1):
            raise ValueError(f"`Document(...)` needs distinct names of its blocks; {twice} came more than once.")
        for part in _walk((self.question, self.method, self.answer, self.findings, self.sections)):
            if isinstance(part, CrossReference):
                known_name(part.name, names, "findings, tables, figures and equations to refer to")

    @property
    def blocks(self) -> tuple[Block, ...]:
        """All blocks in reading order."""
        return tuple(block for section in self.sections for block in section.blocks)

    @property
    def tables(self) -> tuple[ReportTable, ...]:
        """The tables in reading order: the first is Table 1."""
        return tuple(block for block in self.blocks if isinstance(block, ReportTable))

    @property
    def figures(self) -> tuple[Figure, ...]:
        """The figures in reading order: the first is Figure 1."""
        return tuple(block for block in self.blocks if isinstance(block, Figure))


def _walk(held: object) -> Iterator[object]:
    """Every part of a document, depth first."""
    yield held
    if isinstance(held, tuple):
        items = held
    else:
        items = tuple(getattr(held, part.name) for part in fields(held)) if is_dataclass(held) else ()
    for item in items:
        yield from _walk(item)


def _cleaned(held: object) -> object:
    """A part of a document whose texts are clean; the very same object where all were, as is a source, an address."""
    if isinstance(held, Source):
        return held
    if isinstance(held, str):
        clean = clean_text(held)
        return held if clean == held else clean
    if isinstance(held, tuple):
        items = tuple(map(_cleaned, held))
        return held if all(a is b for a, b in zip(items, held, strict=True)) else items
    if isinstance(held, Mapping):
        return {_cleaned(key): _cleaned(value) for key, value in held.items()}
    if is_dataclass(held) and not isinstance(held, type):
        values = {part.name: getattr(held, part.name) for part in fields(held)}
        changed = {name: new for name, old in values.items() if (new := _cleaned(old)) is not old}
        return replace(held, **changed) if changed else held
    return held

"""Publications: what the `References` sections of docstrings name, and the blocks of a loop that name them."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from dataclasses import dataclass, fields, is_dataclass
from typing import NamedTuple

from workbench.core.block import is_block
from workbench.core.validation.signatures import check_arguments

SECTION = re.compile(r"^References\n-{3,}\n(.*?)(?=\n\n[^\n]+\n-{3,}\n|\Z)", re.M | re.S)
NAME = r"(?:(?:van|von|der|den|de|Van|Vander|De|El|Sun) )*[A-ZÀ-ÖØ-Þ][\w'-]+"
AUTHORS = rf"{NAME}(?:(?:, | and |, and ){NAME})*(?: et al\.)?"
BEGINNING = rf"{AUTHORS} \(\d{{4}}\)"  # of a reference: its authors and its year
MARK = re.compile(r"^\.\. \[\w+\]\s*")  # of a reference as numpydoc has it
# What stands between a publication and the place in it: a chapter, an equation, or a remark in parentheses at the end.
PLACE = re.compile(
    r"[,;:] (?=(?:sections?|chapters?|equations?|tables?|appendix|annex|theorems?|algorithms?|example)\b|without units)"
    r"|; | (?=\([^()]*\)$)"
)


@dataclass(frozen=True)
@check_arguments
class Publication:
    """A paper, a book or a page, as a docstring names it: its authors and year where they are known, and the rest.

    Examples
    --------
    >>> from workbench.core.publications import publications_in
    >>> publications_in("Khalil (2002), Nonlinear Systems, chapter 14.")
    ((Publication(authors='Khalil', year='2002', work='Nonlinear Systems'), 'chapter 14'),)
    """

    authors: str
    year: str
    work: str

    @property
    def text(self) -> str:
        """The publication on one line, as a list of references has it."""
        return f"{self.authors} ({self.year}), {self.work}" if self.authors else self.work

    @property
    def identity(self) -> tuple[str, str, str]:
        """The part by which one publication is known, however many of its authors are named."""
        return re.split(r",| and | et al", self.authors)[0], self.year, re.sub(r"\W+", " ", self.work).lower()


class Origin(NamedTuple):
    """A block by the name of its class, and the text of its `References` section; empty without one."""

    block: str
    references: str


def references_section(docstring: str | None) -> str:
    """The text of the `References` section of a docstring in the form of numpydoc; empty without one."""
    section = SECTION.search(inspect.cleandoc(docstring)) if isinstance(docstring, str) else None
    return section[1].strip() if section else ""


def publications_in(references: str) -> tuple[tuple[Publication, str], ...]:
    """Each publication that a `References` section names, with the place in it that is named: a chapter, an equation.

    A reference begins on a new line behind a full stop, at a mark such as `.. [1]`, or with authors and a year in
    parentheses behind a full stop or a semicolon.
    """
    return tuple(_publication(entry) for entry in _entries(references))


def _entries(references: str) -> Iterator[str]:
    """The text of each reference on one line."""
    entries: list[str] = []
    for line in map(str.strip, references.splitlines()):
        marked = MARK.match(line)
        if marked or not entries or (entries[-1].endswith(".") and line[:1].isupper()):
            entries.append(line[marked.end() :] if marked else line)
        else:
            entries[-1] = f"{entries[-1]} {line}".strip()
    for entry in entries:
        yield from filter(None, re.split(rf"(?<=[.;])\s+(?={BEGINNING})", entry))


def _publication(entry: str) -> tuple[Publication, str]:
    entry = entry.strip().rstrip(".;")
    head = re.match(rf"({AUTHORS}) \((\d{{4}})\), ", entry)
    authors, year = head.groups() if head else ("", "")
    rest = entry[head.end() :] if head else entry
    cut = PLACE.search(rest)
    work, place = (rest[: cut.start()], rest[cut.end() :]) if cut else (rest, "")
    return Publication(authors, year, work), place


def origins(thing: object) -> tuple[Origin, ...]:
    """The blocks that a loop, or a block, consists of, each class once, with the references of its docstring.

    A block whose `noun` is empty stands for nothing of its own, and is listed only where it has a reference. Equations
    have the origins of the loop that they were made from.
    """
    return tuple(dict.fromkeys(_origins(thing, whole=True)))


def _origins(thing: object, whole: bool = False) -> Iterator[Origin]:
    known = getattr(thing, "origins", ())
    yield from (one for one in known if isinstance(one, Origin)) if isinstance(known, tuple) else ()
    if is_block(thing):
        yield from _own(thing)
    elif not (whole and is_dataclass(thing)):
        return
    for field in fields(thing):
        value = getattr(thing, field.name)
        for part in value if isinstance(value, tuple) else (value,):
            yield from _origins(part)


def _own(block: object) -> Iterator[Origin]:
    references = references_section(type(block).__doc__)
    if references or getattr(type(block), "noun", type(block).__name__):
        yield Origin(type(block).__name__, references)

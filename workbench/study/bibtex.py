"""BibTeX: a publication as an entry, with the fields that are known and no character that LaTeX would read."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator, Sequence

from workbench.core.publications import Publication

SPECIAL = {
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    **{c: f"\\{c}" for c in "&%$#_{}"},
}


def escape_latex(text: str) -> str:
    """The text as LaTeX prints it: none of its characters is a command, and it stays on one line."""
    return "".join(SPECIAL.get(c, c) for c in " ".join(text.split()))


def bibtex_keys(works: Sequence[Publication]) -> list[str]:
    """A key for each work: the family name of the first author, or the first word, with the year; all different."""
    keys: list[str] = []
    for work in works:
        first = re.split(r",| and | et al", work.authors)[0] if work.year else f"{work.work} work".split()[0]
        letters = unicodedata.normalize("NFKD", first).encode("ascii", "ignore").decode().lower()
        stem = (re.sub(r"[^a-z0-9]+", "", letters) or "work") + work.year
        keys.append(next(key for key in _numbered(stem) if key not in keys))
    return keys


def bibtex_entry(key: str, work: Publication, note: str) -> str:
    """The work as a `@misc` entry."""
    fields = {"author": _authors(work), "year": work.year, "note": escape_latex(note)}
    if work.authors and not work.year:  # a collective author and a title, as those of the workbench
        fields = {"author": _authors(work), "title": f"{{{escape_latex(work.work)}}}", "note": escape_latex(note)}
    lines = "".join(f"  {name} = {{{value}}},\n" for name, value in fields.items() if value)
    return f"@misc{{{key},\n{lines}}}"


def _authors(work: Publication) -> str:
    """The family names, joined as BibTeX wants them; a name of several words stays one name by its braces."""
    text = work.authors.removesuffix(" et al.")
    names = re.split(r", and |, | and ", text) if text else []
    names = [f"{{{escape_latex(name)}}}" if " " in name else escape_latex(name) for name in names]
    return " and ".join([*names, *(["others"] if text != work.authors else [])])


def _numbered(stem: str) -> Iterator[str]:
    """The stem, and then the stem with a, b, c and so on behind it."""
    yield stem
    count = 0
    while True:
        yield f"{stem}{chr(ord('a') + count % 26)}{count // 26 or ''}"
        count += 1

"""Blocks of words: running text, lists, equations, and verdicts with their evidence."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from workbench.notation.formula import Formula
from workbench.study.document.cells import Phrase, check_choice, check_name, check_phrase, phrases, several
from workbench.validation.views import show


@dataclass(frozen=True)
@show
class Paragraph:
    """Running text.

    Examples
    --------
    >>> wb.Paragraph("All runs settled.").text
    'All runs settled.'
    """

    text: Phrase

    def __post_init__(self) -> None:
        check_phrase("Paragraph(text)", self.text)


@dataclass(frozen=True)
@show
class Itemize:
    """A list of points."""

    items: tuple[Phrase, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "items", phrases("Itemize(items)", self.items))


@dataclass(frozen=True)
@show
class Equation:
    """Formulas on lines of their own below one number; the `note` says where they come from."""

    formulas: Formula | tuple[Formula, ...]
    name: str = ""
    note: Phrase = ""

    def __post_init__(self) -> None:
        if not (isinstance(self.name, str) and self.name == ""):
            check_name("Equation", self.name)
        check_phrase("Equation(note=...)", self.note)
        if not several("Equation(formulas)", self.lines, get_args(Formula), "formula"):
            raise ValueError("`Equation(formulas)` must have at least one formula to number; got none.")

    @property
    def lines(self) -> tuple[Formula, ...]:
        """The formulas, one a line."""
        return self.formulas if isinstance(self.formulas, tuple) else (self.formulas,)


@dataclass(frozen=True)
@show
class Verdict:
    """A claim with what became of it and its evidence, as a bound, a residual or a witness, in one box.

    A claim `holds`, `fails` or is `open`. What a study `found` is a plain sentence with its figure, printed without
    a word of right or wrong; one that `depends` has other answers to other questions.

    `estimand` says which statistic of which sample it speaks of, `given` who was given what, and `reversal` what
    would turn it round.
    """

    kind: Literal["holds", "fails", "open", "found", "depends"]
    statement: Phrase
    evidence: Phrase = ""
    estimand: Phrase = ""
    given: Phrase = ""
    reversal: Phrase = ""

    def __post_init__(self) -> None:
        check_choice("Verdict(kind)", self.kind, ("holds", "fails", "open", "found", "depends"))
        check_phrase("Verdict(statement)", self.statement)
        for name in ("evidence", "estimand", "given", "reversal"):
            check_phrase(f"Verdict({name}=...)", getattr(self, name))

    @property
    def terms(self) -> tuple[tuple[str, Phrase], ...]:
        """What stands in small lines below the evidence, each with its label; only what is given."""
        lines = (
            ("Statistic and sample", self.estimand),
            ("Given", self.given),
            ("Would be reversed by", self.reversal),
        )
        return tuple((label, phrase) for label, phrase in lines if phrase)

"""Findings: conclusions as objects, each with its scope and with its answer under every variation that was computed."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from workbench.core.validation.refusals import refusal
from workbench.core.validation.signatures import check_arguments
from workbench.study.document.phrases_and_tables import Phrase, check_name, parts
from workbench.study.document.words import join_names

MAX_NAMES, MAX_ANSWERS = (
    3,
    3,
)  # variations of one answer, and other answers, that the box names; its scope has a table of all


@dataclass(frozen=True)
@check_arguments
class Variation:
    """A change of the study, in `words`, and the `answer` that it gives, with its numbers in `detail`.

    Variations that answer different questions are counted separately, by their `question`: a clause such as "that count
    scenarios".

    Examples
    --------
    >>> wb.Variation("the median in place of the mean", "SMC", "1.2 against 1.4").answer
    'SMC'
    """

    words: str
    answer: str
    detail: str = ""
    question: str = ""

    def __post_init__(self) -> None:
        for part in ("words", "answer"):
            if not getattr(self, part).strip():
                raise refusal(f"Variation({part}=...)", "a text", getattr(self, part))
        for part in ("words", "answer", "detail", "question"):
            _refuse_nan(f"Variation({part}=...)", getattr(self, part))


@dataclass(frozen=True)
@check_arguments
class Finding:
    """A conclusion with its scope, and with the answer under every variation that the study has computed.

    Its `kind` follows from the fields: "open" if the runs do not decide the answer, "depends" if a variation has
    another answer, else "found".

    Attributes
    ----------
    name
        Lower-case letters, digits and underscores, for references and links.
    statement, evidence
        `statement` is the answer in one sentence, with its number; `evidence` says why one may believe it.
    statistic, sample
        What is computed, and from which runs.
    information
        What each law is given: measurements, models and disturbances.
    assumptions
        What was assumed: numbers that the source does not state, and interpretations of its text.
    fitted_numbers
        The numbers that were tuned or fitted.
    answer
        The answer in a word or a number. The answers of the `variations` are compared with it.
    limitations
        What may change the answer, and is not in the study.
    is_decided
        False if the runs do not decide the answer; the kind is then "open".
    cites
        The findings of other reports that answer the same question, as "folder/name".

    Raises
    ------
    ValueError
        If `name` has other characters, a sentence contains the number nan, two variations have the same words, or there
        are variations but no answer.

    Examples
    --------
    >>> median = wb.Variation("the median in place of the mean", "SMC")
    >>> best = wb.Finding("best", "PID has the least mean cost, 1.2.", answer="PID", variations=(median,))
    >>> best.kind, [one.words for one in best.reversals]
    ('depends', ['the median in place of the mean'])
    """

    name: str
    statement: Phrase
    evidence: Phrase = ""
    statistic: Phrase = ""
    sample: Phrase = ""
    information: Phrase = ""
    assumptions: Phrase = "nothing"
    fitted_numbers: Phrase = "nothing"
    answer: str = ""
    variations: tuple[Variation, ...] = ()
    limitations: Phrase = ""
    is_decided: bool = True
    cites: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        check_name("Finding", self.name)
        for part in ("statement", "evidence", "answer"):
            _refuse_nan(f"Finding({part}=...)", getattr(self, part))
        if twice := [words for words, count in Counter(one.words for one in self.variations).items() if count > 1]:
            raise ValueError(f"`Finding(variations=...)` needs distinct words; {twice} came more than once.")
        if self.variations and not self.answer.strip():
            raise refusal("Finding(answer=...)", "a text, with which the answers of the variations agree or not", "")
        for cited in self.cites:
            if not re.fullmatch(r"[a-z0-9_]+/[a-z0-9_]+", cited):
                raise refusal("Finding(cites=...)", "names such as 'folder/name', of a report and its finding", cited)

    @property
    def reversals(self) -> tuple[Variation, ...]:
        """The variations with another answer."""
        return tuple(one for one in self.variations if one.answer != self.answer)

    @property
    def kind(self) -> Literal["found", "depends", "open"]:
        """The kind of the finding, which decides the word beside its box."""
        if not self.is_decided:
            return "open"
        return "depends" if self.reversals else "found"

    @property
    def change(self) -> str:
        """The variations that change the answer, in one or two sentences."""
        changes, total = self.reversals, len(self.variations)
        if not total:
            return "No variation was computed."
        if not changes:
            each = f"each of {total} variations" if total > 1 else "the one variation"
            return f"The answer, {_quoted(self.answer)}, stays the same in {each}: {_named(self.variations)}."
        groups: dict[str, list[Variation]] = {}
        for one in changes:
            groups.setdefault(one.answer, []).append(one)
        counted = self._counted if total > 1 else "the one variation"
        part = f"The answer, {_quoted(self.answer)}, changes in {counted}"
        if len(groups) == 1 and len(changes) > MAX_NAMES:
            return f"{part}, always to {_quoted(changes[0].answer)}."
        answers = [f"to {_quoted(answer)} in {_few(ones)}" for answer, ones in groups.items()]
        others = len(answers) - MAX_ANSWERS
        rest = f"; and to {others} other answer{'s' * (others > 1)}" if others > 0 else ""
        return f"{part}: {'; '.join(answers[:MAX_ANSWERS])}{rest}."

    @property
    def _counted(self) -> str:
        """The number of reversals among the variations, of each question by itself."""
        totals = Counter(one.question for one in self.variations)
        changed = Counter(one.question for one in self.reversals)
        counts = (
            f"{_count_among(changed[question], n)} variations {question}".strip() for question, n in totals.items()
        )
        return " and in ".join(counts)

    @property
    def by_question(self) -> tuple[tuple[str, tuple[Variation, ...]], ...]:
        """The questions of the variations, each with the variations that answer it, in their order."""
        questions = dict.fromkeys(one.question for one in self.variations)
        return tuple((asked, tuple(one for one in self.variations if one.question == asked)) for asked in questions)

    @property
    def scope(self) -> tuple[tuple[str, Phrase], ...]:
        """The statistic, the sample and all else on which the answer rests, except the variations, with labels."""
        lines: tuple[tuple[str, Phrase], ...] = (
            ("Statistic", self.statistic),
            ("Sample", self.sample),
            ("Given", self.information),
            ("Chosen", self.assumptions),
            ("Fitted", self.fitted_numbers),
            ("Answer", self.answer),
            ("Not tried", self.limitations),
        )
        return tuple((label, phrase) for label, phrase in lines if phrase)


def _refuse_nan(call: str, phrase: Phrase) -> None:
    """Refuse a sentence with a number that was not computed."""
    for part in parts(phrase):
        if isinstance(part, str) and re.search(r"\bnan\b", part):
            must = "a sentence without 'nan', the text of a number that does not exist"
            raise refusal(call, must, part, "; say which runs were lost, and count them")


def _quoted(answer: str) -> str:
    """An answer within a sentence: several words, and a word such as "none", stand in quotation marks."""
    return f"'{answer}'" if " " in answer or answer[0].islower() else answer


def _count_among(count: int, total: int) -> str:
    """A count among a total; that of all is the total alone."""
    return f"all {total}" if count == total > 1 else f"{count} of {total}"


def _few(variations: Sequence[Variation]) -> str:
    """The variations that have one answer: a few by their words, in quotation marks, more by their number."""
    if len(variations) > MAX_NAMES:
        return f"{len(variations)}"
    return join_names(f"“{one.words}”" for one in variations)


def _named(variations: Sequence[Variation]) -> str:
    """The first few variations in words, and the number of the others."""
    rest = len(variations) - MAX_NAMES
    words = [one.words for one in variations[:MAX_NAMES]]
    return "; ".join([*words, f"{rest} more"] if rest > 0 else words)

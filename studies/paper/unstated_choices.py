"""The one list of what the paper leaves open, or states in a way that cannot be run: numbers and readings.

The numbers are those that the card assumes. The readings stand in `readings`, each with what the paper states. A study
names what it chose, what it varied and what it left out by `assumptions`, `varied_choices` and `omitted_choices`, and
never by hand.
"""

from __future__ import annotations

from collections.abc import Iterable

import workbench as wb
from studies.paper.card import CARD, FIT, LAWS, PROPOSED_LAW, SCENARIOS
from studies.paper.readings import OF_EXPERIMENT, OF_LAW, OF_RIVALS, RIVAL, Choice

# Where a number of the card is missing, and what the paper states there; of a rival it states the name alone.
PLACES = {
    "Q": ("(32), (34)", "positive definite; 'penalizes error'"),
    "R": ("(32), (34)", "'penalizes control effort'"),
    "l": ("(24)", "l >> 1"),
    "SS: a1, a2": ("section 5", "the letters a1, a2"),
    "SS: f": ("section 5", "the letter f"),
    "SS: derivatives of the reference": ("(28)", "the symbols; a jump has no derivative"),
    "FS: horizon": ("section 5", "nothing"),
    "SS: horizon": ("section 5", "nothing"),
    "sample time of (43)": ("(43)", "a mean over N samples"),
    "shape of (33)": ("(33)", "P s sign(s), which has no consistent shape"),
}
FACTORS = {  # the names of a6 that are not the last part of the card's name
    "FS: horizon": ("horizon of FS",),
    "SS: horizon": ("horizon of SS",),
    "SS: a1, a2": ("a1", "a2"),
    "SMC: K": ("K of joint 1", "K of joint 2"),
    "PID: poles": ("poles of joint 1", "poles of joint 2"),
}
FITTED_NAMES = ("SS: a1, a2",)  # beside those whose source on the card is the fit
PRINTED_NAMES = {"Q": "Q as printed", "R": "R as printed"}  # a second number on the card for the law as printed


def _name(given: wb.provenance.CardEntry) -> str:
    return given.label if isinstance(given.label, str) and given.label else given.name


def _number(given: wb.provenance.CardEntry) -> Choice:
    name = _name(given)
    head, colon, tail = name.partition(": ")
    law = head if head in LAWS else "" if colon or name == "sample time of (43)" else PROPOSED_LAW
    assumed = wb.provenance.value_text(given.value)
    if name in PRINTED_NAMES:
        assumed += f" with four repairs, {wb.provenance.value_text(CARD[PRINTED_NAMES[name]])} in the law as printed"
    readings = tuple(wb.arms.laws.SHAPES) if name == "shape of (33)" else ()
    options = ", ".join(readings)
    if given.low is not None and given.high is not None:
        options = f"{given.low:g} to {given.high:g}"
    where, states = PLACES.get(name, RIVAL)
    return Choice(
        name,
        where,
        states,
        f"{options} {given.unit}".strip() or "not varied",
        f"{assumed} {given.unit}".strip() if name not in PRINTED_NAMES else f"{assumed} ({given.unit})",
        given.source,
        law,
        head if head in SCENARIOS else "",
        readings,
        FACTORS.get(name, (tail or name,)),
        given.source == FIT or name in FITTED_NAMES,
    )


_NUMBERS = tuple(
    _number(given)
    for given in CARD
    if given.mark == "assumed"
    and given.name not in PRINTED_NAMES.values()
    and not given.name.startswith("super-twisting: ")  # no law of the paper
)
CHOICES: tuple[Choice, ...] = (*OF_LAW, *_NUMBERS, *OF_RIVALS, *OF_EXPERIMENT)


def choices_of(law: str, scenario: str = "") -> tuple[Choice, ...]:
    """The choices on which the runs of a law rest in one scenario, or in both."""
    laws = {law, ""} if law == PROPOSED_LAW else {law, "", "rivals"}
    return tuple(c for c in CHOICES if c.law in laws and c.scenario in {scenario or c.scenario, ""})


def varied_choices(factors: Iterable[str], choices: Iterable[Choice] = CHOICES) -> tuple[Choice, ...]:
    """The choices that a study with factors of these names varies, at least in part."""
    names = set(factors)
    return tuple(choice for choice in choices if names & set(choice.factors))


def omitted_choices(factors: Iterable[str], choices: Iterable[Choice] = CHOICES) -> tuple[Choice, ...]:
    """The choices that a study with factors of these names does not vary."""
    wanted = tuple(choices)
    inside = varied_choices(factors, wanted)
    return tuple(choice for choice in wanted if choice not in inside)


def assumptions(choices: Iterable[Choice], of_fit: bool = False) -> str:
    """Choices with what a1 assumes, of those that it fitted or of the others: 'sat of (29): clipped at 1; ...'."""
    words = _fitted_words if of_fit else str
    return "; ".join(words(choice) for choice in choices if choice.is_fitted == of_fit) or "nothing"


def _fitted_words(choice: Choice) -> str:
    """A fitted choice with the number that was fitted, without the one that is assumed for the law as printed."""
    if choice.name not in PRINTED_NAMES:
        return str(choice)
    (given,) = (one for one in CARD if one.name == choice.name)
    return f"{choice.name}: {wb.provenance.value_text(given.value)} {given.unit}"


def names(choices: Iterable[Choice]) -> str:
    """The names of choices: 'sat of (29), start of (24)'."""
    return ", ".join(choice.name for choice in choices) or "nothing"


def table(name: str, caption: str, choices: Iterable[Choice] = CHOICES) -> wb.document.ReportTable:
    """The choices as a report prints them, one row for each choice."""
    heads = ("unstated choice", "where", "the paper states", "could be", "assumed here", "why")
    rows = tuple((c.name, c.where, c.states, c.options, c.assumption, c.why) for c in choices)
    return wb.document.ReportTable(name, caption, tuple(map(wb.document.TableColumn, heads)), rows)

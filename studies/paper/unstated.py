"""The one list of what the paper leaves open, or states in a way that cannot be run: numbers and readings.

The numbers are those that the card assumes. The readings stand here, each with what the paper states. A study names
what it chose, what it varied and what it left out by `assumptions`, `varied` and `left_out`, and never by hand.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from studies.paper.card import CARD, FIT, LAWS, PROPOSED, SCENARIOS
from workbench.controllers.aosmc_rgs import SHAPES
from workbench.study.document.phrases import Column, Table
from workbench.study.provenance import Given, written


@dataclass(frozen=True)
class Choice:
    """A number or a reading that the paper leaves open, with its options and with what a1 assumes.

    `law` is the law that it belongs to, "rivals", or empty for the experiment; `scenario` is empty for both. `factors`
    are the names under which a6 varies it; `fitted` is true where a1 chose it for its fit to printed numbers.
    """

    name: str
    where: str  # the equation or the section that leaves it open
    states: str  # what the paper states there
    options: str  # the readings, or the range, in words
    assumed: str
    why: str
    law: str = ""
    scenario: str = ""
    readings: tuple[str, ...] = ()
    factors: tuple[str, ...] = ()
    fitted: bool = False

    def __str__(self) -> str:
        return f"{self.name}: {self.assumed}"


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
RIVAL = ("section 5", "the name of the law")
FACTORS = {  # the names of a6 that are not the last part of the card's name
    "FS: horizon": ("horizon of FS",),
    "SS: horizon": ("horizon of SS",),
    "SS: a1, a2": ("a1", "a2"),
    "SMC: K": ("K of joint 1", "K of joint 2"),
    "PID: poles": ("poles of joint 1", "poles of joint 2"),
}
FITTED = ("SS: a1, a2", "SS: horizon")  # beside those whose source on the card is the fit
REPAIRED = {"Q": "Q as printed", "R": "R as printed"}  # a second number on the card for the law as printed


def _name(given: Given) -> str:
    return given.shown if isinstance(given.shown, str) and given.shown else given.name


def _number(given: Given) -> Choice:
    name = _name(given)
    head, colon, tail = name.partition(": ")
    law = head if head in LAWS else "" if colon or name == "sample time of (43)" else PROPOSED
    assumed = written(given.value)
    if name in REPAIRED:
        assumed += f" with four repairs, {written(CARD[REPAIRED[name]])} as printed"
    readings = tuple(SHAPES) if name == "shape of (33)" else ()
    options = ", ".join(readings)
    if given.low is not None and given.high is not None:
        options = f"{given.low:g} to {given.high:g}"
    where, states = PLACES.get(name, RIVAL)
    return Choice(
        name,
        where,
        states,
        f"{options} {given.unit}".strip() or "not varied",
        f"{assumed} {given.unit}".strip() if name not in REPAIRED else f"{assumed} ({given.unit})",
        given.source,
        law,
        head if head in SCENARIOS else "",
        readings,
        FACTORS.get(name, (tail or name,)),
        given.source == FIT or name in FITTED,
    )


def _reading(
    name: str, where: str, states: str, readings: tuple[str, ...], assumed: str, why: str, law: str = PROPOSED
) -> Choice:
    return Choice(name, where, states, " / ".join(readings), assumed, why, law, readings=readings, factors=(name,))


# Readings of what is printed. The first option of each is the print where the print can be run.
OF_LAW = (
    _reading(
        "sign of (33)",
        "(33)",
        "a minus, with which K of (29) need not stay positive definite",
        ("minus", "plus"),
        "plus with four repairs, minus as printed and with two repairs",
        "with the plus K grows with the error",
    ),
    _reading(
        "velocity in (28)",
        "(28)",
        "qd_d and qdd_d, from which (30) does not follow",
        ("printed", "reference"),
        "reference with four and with two repairs, printed as printed",
        "(30) follows with qd_r = qd_d - Lambda e",
    ),
    _reading(
        "D_hat of (24)",
        "(24)",
        "the integral of eta, which follows D; it must know D",
        ("none", "eta", "its integral"),
        "eta with four repairs, its integral as printed and with two repairs",
        "D_hat follows D, as the text says",
    ),
    _reading(
        "C of (3)",
        "(3)",
        "an entry C[1,2] without velocity",
        ("right", "printed"),
        "right with four and with two repairs, printed as printed",
        "Assumption 3 holds with it (a0)",
    ),
    _reading(
        "observer (10)",
        "(10), (25)",
        "the law gets estimates, and (43) the measured positions",
        ("out", "in"),
        "in",
        "as printed",
    ),
    _reading(
        "D_hat in (10)",
        "(9), (10)",
        "no disturbance, though (1) has one",
        ("left out", "given"),
        "left out",
        "as printed; given in one run of a1",
    ),
    _reading(
        "1/phi in A of (31)",
        "(31)",
        "A = -M^-1 K, though (29) has K sat(s/phi)",
        ("left out", "kept"),
        "left out",
        "as printed",
    ),
    _reading(
        "Q and R as matrices",
        "(32), (34)",
        "two by two",
        ("a number times I", "any positive definite matrix"),
        "a number times I",
        "the plainest choice",
    ),
    _reading(
        "sat of (29)",
        "(29)",
        "a 'continuous approximation of sign'",
        ("clipped at 1", "another, as tanh"),
        "clipped at 1",
        "the usual meaning of sat",
    ),
    _reading(
        "start of (24)",
        "(24)",
        "nothing on eta(0)",
        ("zero", "another value"),
        "zero",
        "as the observer (10) starts",
    ),
    _reading(
        "C of the simulated arm",
        "(1), (3)",
        "(3), with the entry C[1,2] without velocity",
        ("derived", "printed"),
        "derived",
        "an arm obeys its energies, whatever a page prints",
    ),
    _reading(
        "direction of (34)",
        "(34)",
        "P(0) and a quadratic cost without a horizon",
        ("forward from P(0)", "backward"),
        "forward from P(0)",
        "as P(0) is stated",
    ),
    _reading(
        "sign(0) in (33)",
        "(33)",
        "sign(s), for s that may be zero",
        ("0", "1 or -1"),
        "0",
        "the usual meaning of sign",
    ),
    _reading(
        "starts in the second scenario",
        "section 5",
        "K(0), P(0) and the observer's start, before both scenarios",
        ("as stated", "others"),
        "as stated",
        "nothing else is stated",
    ),
)
OF_RIVALS = (
    _reading(
        "rivals' measurements",
        "section 5",
        "nothing; (10) serves AOSMC-RGS",
        ("exact", "by (10)"),
        "exact",
        "the best that a rival can have",
        "rivals",
    ),
    _reading(
        "rivals' Lambda and phi",
        *RIVAL,
        ("those of AOSMC-RGS", "others"),
        "those of AOSMC-RGS",
        "the rivals share what section 5 states",
        "rivals",
    ),
    _reading(
        "rivals' equations",
        *RIVAL,
        ("standard forms", "other forms"),
        "standard forms",
        "as in textbooks",
        "rivals",
    ),
    _reading(
        "derivative and start of PID",
        *RIVAL,
        ("exact velocity, integral from zero", "a filter, another start"),
        "exact velocity, integral from zero",
        "the plainest PID",
        "PID",
    ),
    _reading("G in PID", *RIVAL, ("without", "with"), "without", "the plain PID has no model", "PID"),
)
OF_EXPERIMENT = (
    _reading(
        "error in (43)",
        "(43), section 5",
        "q - q_d in (43), q_hat - q_d as the tracking error of section 5",
        ("of q", "of q_hat"),
        "of q",
        "(43) prints it; a1 has both",
        "",
    ),
    _reading(
        "first sample of (43)",
        "(43)",
        "k = 1 to N",
        ("at t = 0", "one sample later"),
        "at t = 0",
        "arrays begin with the start",
        "",
    ),
    _reading(
        "square wave of the second scenario",
        "section 5",
        "square(pi f t)",
        ("half high and half low, high first", "another duty or phase"),
        "half high and half low, high first",
        "the usual meaning of square",
        "",
    ),
    _reading("torque limit", "section 5", "nothing", ("none", "some limit"), "none", "none is mentioned", ""),
    _reading("noise", "section 5", "nothing", ("none", "some noise"), "none", "none is mentioned", ""),
    _reading(
        "solver and sampling",
        "section 5",
        "nothing",
        ("continuous time", "a period or a solver's step"),
        "continuous time",
        "(9) to (34) are differential equations; a9 varies the period",
        "",
    ),
)

_NUMBERS = tuple(
    _number(given)
    for given in CARD
    if given.mark == "assumed"
    and given.name not in REPAIRED.values()
    and not given.name.startswith("super-twisting: ")  # no law of the paper
)
CHOICES: tuple[Choice, ...] = (*OF_LAW, *_NUMBERS, *OF_RIVALS, *OF_EXPERIMENT)


def concerning(law: str, scenario: str = "") -> tuple[Choice, ...]:
    """The choices on which the runs of a law rest in one scenario, or in both."""
    laws = {law, ""} if law == PROPOSED else {law, "", "rivals"}
    return tuple(c for c in CHOICES if c.law in laws and c.scenario in {scenario or c.scenario, ""})


def varied(factors: Iterable[str], choices: Iterable[Choice] = CHOICES) -> tuple[Choice, ...]:
    """The choices that a study with factors of these names varies, at least in part."""
    names = set(factors)
    return tuple(choice for choice in choices if names & set(choice.factors))


def left_out(factors: Iterable[str], choices: Iterable[Choice] = CHOICES) -> tuple[Choice, ...]:
    """The choices that a study with factors of these names does not vary."""
    wanted = tuple(choices)
    inside = varied(factors, wanted)
    return tuple(choice for choice in wanted if choice not in inside)


def assumptions(choices: Iterable[Choice], fitted: bool = False) -> str:
    """Choices with what a1 assumes, of those that it fitted or of the others: 'sat of (29): clipped at 1; ...'."""
    return "; ".join(str(choice) for choice in choices if choice.fitted == fitted) or "nothing"


def names(choices: Iterable[Choice]) -> str:
    """The names of choices: 'sat of (29), start of (24)'."""
    return ", ".join(choice.name for choice in choices) or "nothing"


def table(name: str, caption: str, choices: Iterable[Choice] = CHOICES) -> Table:
    """The choices as a report prints them, a row a choice."""
    heads = ("left open", "where", "the paper states", "could be", "assumed here", "why")
    rows = tuple((c.name, c.where, c.states, c.options, c.assumed, c.why) for c in choices)
    return Table(name, caption, tuple(map(Column, heads)), rows)

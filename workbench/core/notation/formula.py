"""A formula as a tree of what stands on the page, without its typesetting."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

from workbench.core.validation.refusals import describe, one_of
from workbench.core.validation.signatures import check_arguments

_NAMES = (
    "alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi pi rho sigma tau upsilon phi chi psi "
    "omega Gamma Delta Theta Lambda Xi Pi Sigma Upsilon Phi Psi Omega"
)
GREEK = dict(zip(_NAMES.split(), "αβγδεζηθικλμνξπρστυϕχψωΓΔΘΛΞΠΣΥΦΨΩ", strict=True))
ACCENTS = ("hat", "tilde", "bar")
SIGNS = ("=", "==", "!=", "<", "<=", ">", ">=", "and", "or")


@dataclass(frozen=True)
@check_arguments
class Number:
    """An exact fraction, or a double that stands for itself."""

    value: Fraction | float


@dataclass(frozen=True)
@check_arguments
class Symbol:
    """A letter with its index and accents: a letter of the alphabet, a Greek one by name, or else a word.

    `index` stands below right, its parts set apart by commas; `mark` above right, as the star of q^*;
    `dots` (derivatives in time) and `accent` ("hat", "tilde" or "bar") stand over the letter.
    """

    letter: str
    index: str = ""
    dots: int = 0
    accent: str = ""
    mark: str = ""
    bold: bool = False

    def __post_init__(self) -> None:
        if self.dots not in (0, 1, 2) or self.accent not in ("", *ACCENTS):
            raise ValueError(
                f"`Symbol(dots=..., accent=...)` takes 0 to 2 dots, and one of {ACCENTS} or none; "
                f"got {describe(self.dots)} and {describe(self.accent)}."
            )


@dataclass(frozen=True)
@check_arguments
class Sum:
    """Terms added up; a term that is a negative number, or a product that begins with one, is subtracted."""

    terms: tuple[Formula, ...]


@dataclass(frozen=True)
@check_arguments
class Product:
    """Factors in the order in which they are printed; only the first may be a negative number."""

    factors: tuple[Formula, ...]


@dataclass(frozen=True)
@check_arguments
class Quotient:
    """A fraction."""

    numerator: Formula
    denominator: Formula


@dataclass(frozen=True)
@check_arguments
class Power:
    """A base with its exponent."""

    base: Formula
    exponent: Formula


@dataclass(frozen=True)
@check_arguments
class Call:
    """A function of its arguments, under the name it has in mathematics: sin, sqrt, abs, min, sat, ..."""

    function: str
    arguments: tuple[Formula, ...]


@dataclass(frozen=True)
@check_arguments
class Cases:
    """The value beside the first condition that holds, else `otherwise`."""

    branches: tuple[tuple[Formula, Formula], ...]
    otherwise: Formula


@dataclass(frozen=True)
@check_arguments
class Matrix:
    """Rows of entries; a vector is a matrix with one column."""

    rows: tuple[tuple[Formula, ...], ...]


@dataclass(frozen=True)
@check_arguments
class Relation:
    """An equation (sign "="), or a condition (any other of `SIGNS`; "==" asks whether two sides are equal)."""

    left: Formula
    sign: str
    right: Formula

    def __post_init__(self) -> None:
        one_of("Relation(sign=...)", self.sign, SIGNS)


@dataclass(frozen=True)
@check_arguments
class System:
    """Relations one below the other, aligned at their signs."""

    relations: tuple[Relation, ...]


Formula: TypeAlias = Number | Symbol | Sum | Product | Quotient | Power | Call | Cases | Matrix | Relation | System

_NAME = re.compile(
    r"(?P<head>[A-Za-z]+)(?P<digits>\d*)(\^(?P<mark>[A-Za-z0-9*]+))?(?P<tail>(_[A-Za-z0-9,]+)*)(?P<open>_?)"
)


@check_arguments
def symbol(name: str) -> Symbol:
    """The symbol that a name of the code stands for.

    The name is a letter or a Greek letter's name, then words set apart by underscores. The words hat, tilde and bar
    go over the letter, star behind it; all others go into the index, as do digits behind the letter.

        m_1, m1          m with index 1           q_ref_1     q with index ref,1
        Lambda_1         Greek, index 1           tau_max1    Greek, index max,1
        q_hat_1          q hat, index 1           q_star, q^* q with a star
        qd_1, qdd_2      q dot, q two dots        thetad      Greek theta, dot
        Kd, Cy           K index d, C index y     l_c1        l with index c1

    A `d` or `dd` behind a lower-case letter is a derivative in time; a lower-case letter behind a
    capital one is its index, as in the gains Kp and Kd. Any other name, such as a path with dots and
    brackets, is printed as it stands.
    """
    match = _NAME.fullmatch(name)
    if match is None or match["open"]:
        return Symbol(name)
    letter, dots, first = _split_head(match["head"])
    parts = [*first, *filter(None, [match["digits"]]), *filter(None, match["tail"].split("_"))]
    accents = [part for part in parts if part in ACCENTS]
    mark = match["mark"] or ("*" if "star" in parts else "")
    index = [part for part in parts if part not in (*ACCENTS, "star")]
    if len(accents) > 1:
        return Symbol(name)
    return Symbol(letter, _index(index), dots, accents[0] if accents else "", "*" if mark == "star" else mark)


def _split_head(head: str) -> tuple[str, int, list[str]]:
    for dots in (2, 1):
        letter = head.removesuffix("d" * dots)
        if letter != head and letter.islower() and (len(letter) == 1 or letter in GREEK):
            return letter, dots, []
    if len(head) == 2 and head[0].isupper() and head[1].islower() and head not in GREEK:
        return head[0], 0, [head[1]]
    return head, 0, []


def _index(parts: list[str]) -> str:
    """The index in parts set apart by commas, a word also from the number behind it: `max1` is read `max,1`."""
    return ",".join(re.sub(r"(?<=[A-Za-z]{2})(?=\d)", ",", part) for part in parts)


@check_arguments
def name_of(symbol: Symbol) -> str:
    """The name that `symbol` reads as this symbol."""
    mark = "_star" if symbol.mark == "*" else f"_{symbol.mark}" if symbol.mark else ""
    index = symbol.index.replace(",", "_")
    head = symbol.letter + "d" * symbol.dots + (f"_{symbol.accent}" if symbol.accent else "")
    return head + mark + (f"_{index}" if index else "")


@check_arguments
def symbols_of(names: Iterable[str], symbols: Mapping[str, Symbol] | None) -> dict[str, Symbol]:
    """The symbol of each name of an expression: from `symbols`, else as `symbol` reads it; none may be shared."""
    known = symbols or {}
    table = {name: known[name] if name in known else symbol(name) for name in names}
    owners: dict[Symbol, str] = {}
    for name, printed_as in table.items():
        if (other := owners.setdefault(printed_as, name)) != name:
            raise ValueError(
                f"`symbols` must tell all names of an expression apart, but '{other}' and '{name}' would both "
                f"be printed {name_of(printed_as)}. Give one of them another symbol."
            )
    return table


def children(formula: Formula) -> tuple[Formula, ...]:
    """The parts of a formula, one level down."""
    match formula:
        case Number() | Symbol():
            return ()
        case Sum(parts) | Product(parts) | Call(_, parts) | System(parts):
            return parts
        case Quotient(first, second) | Power(first, second) | Relation(first, _, second):
            return (first, second)
        case Cases(branches, otherwise):
            return (*(part for branch in branches for part in branch), otherwise)
        case Matrix(rows):
            return tuple(entry for row in rows for entry in row)


def letters(formula: Formula) -> Iterator[Symbol]:
    """Every symbol of a formula, as often as it occurs, from left to right."""
    if isinstance(formula, Symbol):
        yield formula
    for part in children(formula):
        yield from letters(part)


@check_arguments
def equations(name: Symbol, matrix: Matrix) -> list[Relation]:
    """One equation for each entry of a matrix, row by row; a long entry that came before is named: `M_21 = M_12`."""
    columns = max((len(row) for row in matrix.rows), default=0)
    comma = "," if max(len(matrix.rows), columns) > 9 else ""
    first: dict[Formula, Symbol] = {}
    relations = []
    for i, row in enumerate(matrix.rows, start=1):
        for j, entry in enumerate(row, start=1):
            place = str(i) if columns == 1 else f"{i}{comma}{j}"
            label = entry_symbol(name, place)
            short = isinstance(entry, Number | Symbol)
            known = label if short else first.setdefault(entry, label)
            relations.append(Relation(label, "=", entry if known == label else known))
    return relations


@check_arguments
def entry_symbol(name: Symbol, place: str) -> Symbol:
    """The symbol of one entry of a matrix: the matrix's own, with the place behind its index."""
    index = f"{name.index},{place}" if name.index else place
    return Symbol(name.letter, index, name.dots, name.accent, name.mark)

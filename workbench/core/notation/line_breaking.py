"""Line breaking: a formula in lines that are no wider than the page."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction

from workbench.core.notation.build import ONE, split_sign
from workbench.core.notation.formula import (
    Call,
    Formula,
    Matrix,
    Number,
    Power,
    Product,
    Quotient,
    Relation,
    Sum,
    Symbol,
    System,
    equations,
)
from workbench.core.notation.markup import Markup
from workbench.core.notation.writer import Writer

INVERSE = Number(Fraction(-1))


@dataclass(frozen=True)
class Row:
    """One line of a display: the left side of an equation if it begins here, and the rest with its sign."""

    left: str
    right: str


@dataclass(frozen=True)
class LinePart:
    """An unbroken part: its text and width, and the texts before it within a line and at its start."""

    text: str
    width: float
    glue: str = ""
    lead: str = ""


def rows(formula: Formula, markup: Markup, width: float) -> list[Row]:
    """A formula in lines of at most `width`, except for unbreakable parts: a symbol, a number, cases, a matrix.

    Sums are broken before their signs, and products before their factors; the entries of a named
    matrix that is too wide become equations of their own.
    """
    writer = Writer(markup)
    if isinstance(formula, System):
        return [row for relation in formula.relations for row in rows(relation, markup, width)]
    if not isinstance(formula, Relation) or formula.sign != "=":
        return [Row("", line) for line in lines(formula, writer, width)]
    match formula.left, formula.right:
        case Symbol() as name, Matrix() as matrix if writer.width(formula) > width:
            return rows(System(tuple(equations(name, matrix))), markup, width)
    first, *later = lines(formula.right, writer, width - writer.width(formula.left) - writer.sign)
    equals = markup.row([markup.sign("="), first])
    return [Row(writer.write(formula.left), equals), *(Row("", line) for line in later)]


def lines(formula: Formula, writer: Writer, room: float) -> list[str]:
    """A formula in lines of at most `room`."""
    filled: list[list[str]] = []
    used = 0.0
    for piece in _Breaker(writer).pieces(formula, room):
        if filled and used + piece.width <= room:
            filled[-1] += [piece.glue, piece.text]
            used += piece.width
        else:
            filled.append([piece.lead, piece.text] if filled else [piece.text])
            used = piece.width
    return [writer.markup.row(line) for line in filled]


@dataclass(frozen=True)
class _Breaker:
    writer: Writer

    def pieces(self, formula: Formula, room: float) -> list[LinePart]:
        write, markup = self.writer.write, self.writer.markup
        if (width := self.writer.width(formula)) <= room:
            return [LinePart(write(formula), width)]
        minus, size = split_sign(formula)
        if minus:
            return self._behind(markup.sign("-", unary=True), self._factor((size,), 0, room - self.writer.sign))
        match size:
            case Sum(terms):
                return [piece for i, term in enumerate(terms) for piece in self._term(term, i, room)]
            case Product(factors):
                return [piece for i in range(len(factors)) for piece in self._factor(factors, i, room)]
            case Quotient(above, below) if above == ONE:
                return self.pieces(Power(below, INVERSE), room)
            case Quotient(above, below) if self.writer.width(below) <= room / 2:
                return self.pieces(Product((Quotient(ONE, below), above)), room)
            case Quotient(above, below):
                return self.pieces(Product((above, Power(below, INVERSE))), room)
            case Power(base, exponent):
                return self._in_parentheses(base, room, exponent=write(exponent))
            case Call(function, (argument,)):
                return self._in_parentheses(argument, room, function=function)
        return [LinePart(write(formula), width)]

    def _term(self, term: Formula, i: int, room: float) -> list[LinePart]:
        minus, size = split_sign(term)
        if i == 0:
            return self.pieces(term, room) if minus else self._factor((size,), 0, room)
        return self._behind(
            self.writer.markup.sign("-" if minus else "+"), self._factor((size,), 0, room - self.writer.sign)
        )

    def _factor(self, factors: tuple[Formula, ...], i: int, room: float) -> list[LinePart]:
        factor, width = factors[i], self.writer.width(factors[i])
        before = sum(map(self.writer.width, factors[:i]))
        if isinstance(factor, Sum) and room < width + (before if before < room / 2 else 0):
            # A sum is rather broken than parted from a short factor before it.
            pieces = self._in_parentheses(factor, min(room, width - self.writer.sign))
        elif width > room and isinstance(factor, Product | Quotient | Power | Call):
            pieces = self.pieces(factor, room)
        else:
            pieces = [LinePart(self.writer.factor(factors, i), width)]
        if i == 0:
            return pieces
        spaces = self.writer.markup.spaces
        glue = spaces[self.writer.space(factors[i - 1], factor)]
        return [replace(pieces[0], glue=glue, lead=spaces["dot"]), *pieces[1:]]

    def _in_parentheses(self, inner: Formula, room: float, *, function: str = "", exponent: str = "") -> list[LinePart]:
        markup = self.writer.markup
        pieces = self.pieces(inner, room - 2 * self.writer.sign - len(function))
        pieces = self._behind(markup.open_parenthesis(function), pieces)
        last = pieces[-1]
        text = markup.row([last.text, markup.with_power(markup.closing_fence, exponent)])
        return [*pieces[:-1], replace(last, text=text, width=last.width + self.writer.sign)]

    def _behind(self, prefix: str, pieces: list[LinePart]) -> list[LinePart]:
        first = pieces[0]
        text = self.writer.markup.row([prefix, first.text])
        return [replace(first, text=text, width=first.width + self.writer.sign), *pieces[1:]]

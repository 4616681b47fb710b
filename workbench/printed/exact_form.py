"""The normal form of a formula as it was read: by exact arithmetic, no number rounded on the way."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from fractions import Fraction
from functools import reduce
from typing import Literal

from workbench.notation import waves
from workbench.notation.formula import Call, Formula, Number, Power, Product, Quotient, Sum, Symbol, letters, name_of
from workbench.notation.normal_form import NormalForm, NotInClass
from workbench.notation.waves import Terms
from workbench.printed.names import PI
from workbench.validation.signatures import door

MOST_PRODUCTS = 20_000  # of terms at once; a sheet's entries have a thousand terms at most
PI_NAME = "π"  # the number stands in monomials as a symbol does; no symbol of an arm is so called
PI_ALONE = ((PI_NAME, 1),)


@door
def normal_form(formula: Formula, names: Mapping[Symbol, str]) -> NormalForm:
    """The normal form of a formula, in the names for which its symbols stand.

    Angles are reduced by their quarter turns k pi/2; elsewhere pi is a symbol of its own, which proves
    no less than is true.

    Raises
    ------
    NotInClass
        If the formula is not of the class of `NormalForm`, or expands to too many terms.
    LookupError
        If a symbol has no name.
    """
    if foreign := {letter for letter in letters(formula) if letter not in names and letter != PI}:
        raise LookupError(f"`normal_form(names=...)` must hold all symbols; it lacks '{name_of(foreign.pop())}'.")
    return NormalForm(_terms(formula, names))


@door
def at_numbers(form: NormalForm, numbers: Mapping[str, Fraction]) -> NormalForm:
    """The normal form with numbers in place of some of its symbols.

    Raises
    ------
    NotInClass
        If a divisor is zero there.
    """
    result: Terms = {}
    for (monomial, (kind, angle)), coefficient in form.terms.items():
        oscillation = _wave(kind, _sum(_at(m, numbers, c) for m, c in angle)) if angle else {waves.UNIT: Fraction(1)}
        result = waves.added(result, waves.multiplied(_at(monomial, numbers, coefficient), oscillation))
    return NormalForm(result)


def constant(form: NormalForm) -> Fraction | None:
    """The number that a normal form is; None if it is none, or no rational one."""
    return None if form.terms.keys() - {waves.UNIT} else form.terms.get(waves.UNIT, Fraction(0))


def _at(monomial: waves.Monomial, numbers: Mapping[str, Fraction], coefficient: Fraction) -> Terms:
    left = []
    for name, exponent in monomial:
        if name not in numbers:
            left.append((name, exponent))
        elif numbers[name] == 0 and exponent < 0:
            raise NotInClass(f"DIV has no value where {name} = 0.")
        else:
            coefficient *= numbers[name] ** exponent
    return {(tuple(left), waves.PLAIN): coefficient} if coefficient else {}


def _terms(formula: Formula, names: Mapping[Symbol, str]) -> Terms:
    match formula:
        case Number(value):
            return waves.constant(Fraction(value))
        case Symbol():
            return waves.variable(PI_NAME if formula == PI and formula not in names else names[formula])
        case Sum(terms):
            return _sum(_terms(term, names) for term in terms)
        case Product(factors):
            return reduce(_times, (_terms(factor, names) for factor in factors))
        case Quotient(above, below):
            return _times(_terms(above, names), _inverse(_terms(below, names)))
        case Power(base, Number(Fraction() as exponent)) if exponent.denominator == 1:
            whole = reduce(_times, [_terms(base, names)] * abs(int(exponent)), waves.constant(Fraction(1)))
            return whole if exponent >= 0 else _inverse(whole)
        case Call("sin" | "cos" as function, (argument,)):
            return _wave(function, _terms(argument, names))
        case Call("sqrt", (argument,)):
            return _root(_terms(argument, names))
        case Call(function, _):
            raise NotInClass(f"{function.upper()} has no normal form: the class knows + - * / sin cos.")
    raise NotInClass("the normal form knows + - * / sin cos and whole powers.")


def _sum(parts: Iterable[Terms]) -> Terms:
    return reduce(waves.added, parts, {})


def _times(a: Terms, b: Terms) -> Terms:
    if len(a) * len(b) > MOST_PRODUCTS:
        raise NotInClass(f"MUL of sums of {len(a)} and {len(b)} terms: too long to expand.")
    return waves.multiplied(a, b)


def _inverse(terms: Terms) -> Terms:
    if (result := waves.inverse(terms)) is None:
        raise NotInClass("DIV has a normal form only if the divisor is a number or a product of symbols.")
    return result


def _root(terms: Terms) -> Terms:
    """The root of a number that is a square."""
    value = constant(NormalForm(terms))
    if value is not None and value >= 0:
        root = Fraction(math.isqrt(value.numerator), math.isqrt(value.denominator))
        if root**2 == value:
            return waves.constant(root)
    raise NotInClass("SQRT has a normal form only of a square number.")


def _wave(kind: Literal["sin", "cos"], argument: Terms) -> Terms:
    """A sine or cosine, its quarter turns taken off: sin(a + pi/2) = cos a, cos(a + pi/2) = -sin a."""
    if (kept := waves.wave(kind, argument)) is None:
        raise NotInClass(f"{kind.upper()} has a normal form only if no sine or cosine stands in its argument.")
    if not kept:
        return {}
    (((_, (kind, angle)), sign),) = kept.items()
    coefficients = dict(angle)
    turns = math.floor(2 * coefficients.get(PI_ALONE, Fraction(0)))
    if turns:
        coefficients[PI_ALONE] -= Fraction(turns, 2)
    if turns % 2:
        kind, turns = ("cos", turns) if kind == "sin" else ("sin", turns + 2)
    rest = waves.wave(kind, {(monomial, waves.PLAIN): c for monomial, c in coefficients.items() if c})
    return waves.scaled(rest or {}, -sign if turns % 4 > 1 else sign)

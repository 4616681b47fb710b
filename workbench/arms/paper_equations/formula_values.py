"""The value of a formula in any arithmetic, and its exact normal form."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import Generic, Literal, Protocol, Self, TypeVar

import casadi as ca
import numpy as np

from workbench.arms.paper_equations.tokens import PI, Token, refusal
from workbench.core.notation import trigonometric_sums as waves
from workbench.core.notation.formula import (
    Call,
    Formula,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    Symbol,
    children,
    letters,
    name_of,
)
from workbench.core.notation.normal_form import NormalForm, NotInClass
from workbench.core.validation.refusals import Array

HIGHEST_POWER = 16
MOST_LEVELS = 100  # of parts within parts: what goes through a formula nests up to four of its calls a level
MOST_WAVES = 100  # in a product; doubles count the terms of no more


class Value(Protocol):
    """A number of an arithmetic."""

    def __add__(self, other: Self, /) -> Self: ...
    def __mul__(self, other: Self, /) -> Self: ...
    def __truediv__(self, other: Self, /) -> Self: ...
    def __pow__(self, exponent: float, /) -> Self: ...


V = TypeVar("V", bound=Value)


@dataclass(frozen=True)
class Arithmetic(Generic[V]):
    """An arithmetic: the maker of its numbers, pi, and its functions by name."""

    number: Callable[[Fraction | float], V]
    pi: V
    functions: Mapping[str, Callable[[V], V]]


def evaluate(formula: Formula, values: Mapping[Symbol, V], arithmetic: Arithmetic[V]) -> V:
    """The value of a formula, given those of its symbols; the symbol pi is the number, where it has no other value.

    A rational number p/q before a product multiplies by p and divides by q, so that a third stays exactly one in the
    expression. A formula without a value, such as a relation, or a number beyond all doubles, is a ValueError.
    """
    match formula:
        case Number(value):
            return arithmetic.number(value)
        case Symbol():
            return arithmetic.pi if formula == PI and formula not in values else values[formula]
        case Sum(terms):
            total = evaluate(terms[0], values, arithmetic)
            for term in terms[1:]:
                total = total + evaluate(term, values, arithmetic)
            return total
        case Product((Number(Fraction() as ratio), *factors)):
            p, q = arithmetic.number(ratio.numerator), arithmetic.number(ratio.denominator)
            return _product(factors, values, arithmetic) * p / q
        case Product(factors):
            return _product(factors, values, arithmetic)
        case Quotient(above, below):
            return evaluate(above, values, arithmetic) / evaluate(below, values, arithmetic)
        case Power(base, Number(exponent)):
            return evaluate(base, values, arithmetic) ** float(exponent)
        case Call(function, (argument,)) if function in arithmetic.functions:
            return arithmetic.functions[function](evaluate(argument, values, arithmetic))
    raise ValueError(f"`evaluate(formula)` knows sums, products, powers and sin, cos, tan, sqrt; got {formula!r:.80}.")


def _product(factors: Sequence[Formula], values: Mapping[Symbol, V], arithmetic: Arithmetic[V]) -> V:
    result = evaluate(factors[0], values, arithmetic)
    for factor in factors[1:]:
        result = result * evaluate(factor, values, arithmetic)
    return result


def _number(value: Fraction | float) -> float:
    try:
        result = float(value)
    except OverflowError:
        result = math.inf
    if not math.isfinite(result) or (result == 0 and value != 0):
        raise ValueError("a number of the formula is too large or too small for any computer's arithmetic.")
    return result


def check_depth(formula: Formula, place: Token) -> Formula:
    """The formula, refused if its parts or powers are nested too deep to be multiplied out."""
    waiting = [(formula, 1, Fraction(1))]
    while waiting:
        part, level, power = waiting.pop()
        if level > MOST_LEVELS:
            raise refusal(place, f"more than {MOST_LEVELS} operations are nested in each other; write it in parts.")
        if isinstance(part, Power) and isinstance(part.exponent, Number):
            power *= max(abs(Fraction(part.exponent.value)), Fraction(1))
            if power > HIGHEST_POWER:
                raise refusal(place, f"powers, also powers of powers, go up to {HIGHEST_POWER}.")
        waiting += [(child, level + 1, power) for child in children(part)]
    return formula


def expanded_size(formula: Formula) -> float:
    """A bound on the terms that a formula, or a part of it, has once multiplied out, sines and cosines into sums."""
    match formula:
        case Sum(terms):
            return sum(map(expanded_size, terms))
        case Product(factors):
            waves = min(sum(map(_oscillates, factors)), MOST_WAVES)
            return math.prod(map(expanded_size, factors)) * 2.0 ** max(waves - 1, 0)
        case Power(base, Number(exponent)) if exponent > HIGHEST_POWER:
            return math.inf
        case Power(base, Number(exponent)) if exponent > 1:
            k, n = int(min(expanded_size(base), 1e9)), math.ceil(exponent)
            return float(math.comb(k + n - 1, n)) * 2.0 ** (n * _oscillates(base))  # monomials of degree n in k terms
        case Quotient(above, below):
            return max(expanded_size(above), expanded_size(below))
        case Call(_, arguments):
            return max(map(expanded_size, arguments))
    return 1.0


def _oscillates(formula: Formula) -> bool:
    match formula:
        case Call("sin" | "cos"):
            return True
        case Sum(parts) | Product(parts):
            return any(map(_oscillates, parts))
        case Power(base, _) | Quotient(base, _):
            return _oscillates(base)
    return False


PI_NAME = "π"  # the number stands in monomials as a symbol does; no symbol of an arm is so called
PI_ALONE = ((PI_NAME, 1),)


def normal_form(formula: Formula, names: Mapping[Symbol, str]) -> NormalForm:
    """The normal form of a formula, in the names for which its symbols stand, with no number rounded on the way.

    Angles are reduced by their quarter turns k pi/2; elsewhere pi is a symbol like any other, which is
    sound. A formula that is not of the class of `NormalForm`, or expands to too many terms, raises NotInClass.
    """
    if foreign := {letter for letter in letters(formula) if letter not in names and letter != PI}:
        raise LookupError(f"`normal_form(names=...)` must hold all symbols; it lacks '{name_of(foreign.pop())}'.")
    form: NormalForm = evaluate(formula, {x: NormalForm(waves.variable(name)) for x, name in names.items()}, EXACT)
    return form


def at_numbers(form: NormalForm, numbers: Mapping[str, Fraction]) -> NormalForm:
    """The normal form with numbers in place of some of its symbols; NotInClass if a divisor is zero there."""
    result = NormalForm({})
    for (monomial, (kind, angle)), coefficient in form.terms.items():
        argument = sum((_at(m, numbers, c) for m, c in angle), NormalForm({}))
        result += _at(monomial, numbers, coefficient) * _wave(kind, argument)
    return result


def _at(monomial: waves.Monomial, numbers: Mapping[str, Fraction], coefficient: Fraction) -> NormalForm:
    left = []
    for name, exponent in monomial:
        if name not in numbers:
            left.append((name, exponent))
        elif numbers[name] == 0 and exponent < 0:
            raise NotInClass(f"DIV has no value where {name} = 0.")
        else:
            coefficient *= numbers[name] ** exponent
    return NormalForm({(tuple(left), waves.PLAIN): coefficient} if coefficient else {})


def _tangent(argument: NormalForm) -> NormalForm:
    raise NotInClass("TAN has no normal form: the class knows + - * / sin cos.")


def _root(argument: NormalForm) -> NormalForm:
    square = argument.number
    if square is not None and square >= 0:
        root = Fraction(math.isqrt(square.numerator), math.isqrt(square.denominator))
        if root**2 == square:
            return NormalForm(waves.constant(root))
    raise NotInClass("SQRT has a normal form only of a square number.")


def _wave(kind: Literal["sin", "cos"], argument: NormalForm) -> NormalForm:
    """A sine or cosine, its quarter turns taken off: sin(a + pi/2) = cos a, cos(a + pi/2) = -sin a."""
    if not (wave := waves.wave(kind, argument.terms)):
        return NormalForm({})
    (((_, (kind, angle)), sign),) = wave.items()
    coefficients = dict(angle)
    turns = math.floor(2 * coefficients.get(PI_ALONE, Fraction(0)))
    if turns:
        coefficients[PI_ALONE] -= Fraction(turns, 2)
    if turns % 2:
        kind, turns = ("cos", turns) if kind == "sin" else ("sin", turns + 2)
    rest = waves.wave(kind, {(monomial, waves.PLAIN): c for monomial, c in coefficients.items() if c})
    return NormalForm(waves.scale(rest, -sign if turns % 4 > 1 else sign))


# In the first two a division by zero gives no finite number; the third is that of normal forms.
CASADI = Arithmetic(
    lambda value: ca.SX(_number(value)), ca.SX(math.pi), {"sin": ca.sin, "cos": ca.cos, "tan": ca.tan, "sqrt": ca.sqrt}
)
NUMPY: Arithmetic[Array | np.float64] = Arithmetic(
    lambda value: np.float64(_number(value)),
    np.float64(math.pi),
    {"sin": np.sin, "cos": np.cos, "tan": np.tan, "sqrt": np.sqrt},
)
EXACT = Arithmetic(
    lambda value: NormalForm(waves.constant(Fraction(value))),
    NormalForm(waves.variable(PI_NAME)),
    {"sin": partial(_wave, "sin"), "cos": partial(_wave, "cos"), "tan": _tangent, "sqrt": _root},
)

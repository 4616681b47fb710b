"""Formulas built as one writes them: no double signs, no nested sums, no x x for x^2; the value stays the same."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from fractions import Fraction

from workbench.core.notation.formula import (
    Call,
    Cases,
    Formula,
    Matrix,
    Number,
    Power,
    Product,
    Quotient,
    Relation,
    Sum,
    Symbol,
    children,
)

ZERO, ONE = Number(Fraction(0)), Number(Fraction(1))
OPPOSITE = {"==": "!=", "!=": "==", "<": ">=", ">=": "<", ">": "<=", "<=": ">"}
MIRRORED_SIGNS = {"==": "==", "!=": "!=", "<": ">", ">": "<", "<=": ">=", ">=": "<="}


def number(value: Fraction | float) -> Number:
    """A finite number as one writes it: 1/2, 3, 9.81, 0.1; it rounds to the double it came from."""
    try:
        exact = Fraction(value)
        double = float(exact)
    except (OverflowError, ValueError) as error:
        if isinstance(value, Fraction):
            return Number(value)
        raise ValueError(f"A formula holds finite numbers; got {value!r}.") from error
    near = exact.limit_denominator(64)
    small = abs(near.numerator) <= 64 or near.denominator == 1
    if small and float(near) == double and abs(near) < 10**9 and (near == exact or len(repr(double)) > 8):
        return Number(near)
    if Fraction(double) != exact and exact.denominator <= 10_000:
        return Number(exact)
    return Number(double)


def split_sign(term: Formula) -> tuple[bool, Formula]:
    """True and the rest if a term is subtracted, else False and the term."""
    match term:
        case Number(value) if value < 0:
            return True, Number(-value)
        case Product((Number(value), *rest)) if value < 0:
            return True, _coefficient_times(Number(-value), tuple(rest))
    return False, term


def negative(formula: Formula) -> Formula:
    """-x."""
    minus, size = split_sign(formula)
    if minus or size == ZERO:
        return size
    match size:
        case Number(value):
            return Number(-value)
        case Sum(terms) if split_sign(terms[0])[0]:
            return Sum(tuple(map(negative, terms)))
        case Product((Number(value), *rest)):
            return Product((Number(-value), *rest))
        case Product(factors):
            return Product((Number(Fraction(-1)), *factors))
    return Product((Number(Fraction(-1)), size))


def total(terms: Iterable[Formula]) -> Formula:
    """A flat sum without its zeros, in which the two halves of an if-else are joined."""
    flat: list[Formula] = []
    for term in terms:
        flat.extend(term.terms if isinstance(term, Sum) else [term] if term != ZERO else [])
    if len(flat) == 2 and (whole := _if_else(*flat)) is not None:
        return whole
    return flat[0] if len(flat) == 1 else Sum(tuple(flat)) if flat else ZERO


def collect_terms(formula: Formula) -> Formula:
    """A sum in which terms that differ by a number only are one, at the place of the first: x + x as 2 x."""
    if not isinstance(formula, Sum):
        return formula
    coefficients: dict[Formula, Fraction] = {}
    for term in formula.terms:
        minus, size = split_sign(term)
        coefficient, rest = _coefficient_and_rest(size)
        coefficients[rest] = coefficients.get(rest, Fraction(0)) + (-coefficient if minus else coefficient)
    if len(coefficients) == len(formula.terms):
        return formula
    return total(product([Number(value), rest]) for rest, value in coefficients.items())


def _if_else(one: Formula, other: Formula) -> Formula | None:
    """The if-else that CasADi keeps as (c ? a : 0) + (not c ? b : 0), if two terms are one."""
    match one, other:
        case Cases(((a, c),), rest), Cases(((b, d),), tail) if rest == tail == ZERO and negation(c) == d:
            if isinstance(b, Cases):
                return Cases(((a, c), *b.branches), b.otherwise)
            return Cases(((a, c),), b)
    return None


def product(factors: Iterable[Formula]) -> Formula:
    """A flat product: one number in front, equal bases gathered, sines and cosines last, one fraction.

    A product with a condition as a factor becomes a product that holds where the condition does.
    """
    coefficient: Fraction = Fraction(1)
    above: list[Formula] = []
    below: list[Formula] = []
    for factor in _flat(factors):
        match factor:
            case Number(Fraction() as value):
                coefficient *= value
            case Quotient(numerator, denominator):
                above.append(numerator)
                below.append(denominator)
            case _:
                above.append(factor)
    if coefficient == 0:
        return ZERO
    for i, factor in enumerate(above):
        match factor:
            case Cases(((then, when),), otherwise) if otherwise == ZERO:
                inner = [Number(coefficient), *above[:i], then, *above[i + 1 :], *(quotient(ONE, b) for b in below)]
                return Cases(((product(inner), when),), ZERO)
    if below:
        return quotient(product([Number(coefficient), *above]), product(below))
    gathered = _gather_powers(above)
    doubles = [f for f in gathered if isinstance(f, Number)]
    rest = tuple(sorted((f for f in gathered if not isinstance(f, Number)), key=_is_oscillation))
    if not doubles:
        return _coefficient_times(Number(coefficient), rest)
    signs, sizes = zip(*map(split_sign, doubles), strict=True)
    size = _coefficient_times(Number(abs(coefficient)), (*sizes, *rest))
    return negative(size) if (sum(signs) + (coefficient < 0)) % 2 else size


def _is_oscillation(factor: Formula) -> bool:
    """True if a factor belongs at the end, where `sin q` needs no parentheses."""
    base = factor.base if isinstance(factor, Power) else factor
    return isinstance(base, Call) and base.function in ("sin", "cos", "tan")


def _flat(factors: Iterable[Formula]) -> Iterable[Formula]:
    for factor in factors:
        if isinstance(factor, Product):
            yield from _flat(factor.factors)
        else:
            yield factor


def _coefficient_times(coefficient: Number, rest: tuple[Formula, ...]) -> Formula:
    if not rest:
        return coefficient
    if coefficient != ONE:
        return Product((coefficient, *rest))
    return rest[0] if len(rest) == 1 else Product(rest)


def _gather_powers(factors: list[Formula]) -> list[Formula]:
    """Factors with equal bases as one power, at the place of the first."""
    exponents: dict[Formula, Fraction] = {}
    for factor in factors:
        base, exponent = _base_and_exponent(factor)
        exponents[base] = exponents.get(base, Fraction(0)) + exponent
    return [power(base, Number(exponent)) for base, exponent in exponents.items() if exponent != 0]


def _base_and_exponent(factor: Formula) -> tuple[Formula, Fraction]:
    match factor:
        case Power(base, Number(Fraction() as exponent)) if exponent.denominator == 1:
            return base, exponent
    return factor, Fraction(1)


def quotient(numerator: Formula, denominator: Formula) -> Formula:
    """A fraction in lowest terms of its numbers, with its sign in front and no fraction inside."""
    minus = split_sign(numerator)[0] != split_sign(denominator)[0]
    first, above = _coefficient_and_rest(split_sign(numerator)[1])
    second, below = _coefficient_and_rest(split_sign(denominator)[1])
    if isinstance(below, Quotient):
        above = product([above, below.denominator])
        below = below.numerator
    if isinstance(above, Quotient):
        below = product([above.denominator, below])
        above = above.numerator
    if second == 0:
        return Quotient(numerator, denominator)
    ratio = first / second
    result: Formula
    if below == ONE or ratio == 0:
        result = product([Number(ratio), above])
    else:
        over, under = Number(Fraction(ratio.numerator)), Number(Fraction(ratio.denominator))
        result = Quotient(product([over, above]), product([under, below]))
    return negative(result) if minus else result


def _coefficient_and_rest(size: Formula) -> tuple[Fraction, Formula]:
    match size:
        case Number(Fraction() as value):
            return value, ONE
        case Product((Number(Fraction() as value), *rest)):
            return value, _coefficient_times(ONE, tuple(rest))
    return Fraction(1), size


def power(base: Formula, exponent: Formula) -> Formula:
    """A power: x^-n as a fraction, x^(1/2) as a root, (x^m)^n with whole m, n as x^(mn)."""
    match exponent:
        case Number(value) if value == 1:
            return base
        case Number(value) if value == 0:
            return ONE
        case Number(Fraction() as value) if value < 0:
            return quotient(ONE, power(base, Number(-value)))
        case Number(value) if value == 0.5:
            return Call("sqrt", (base,))
        case Number(Fraction() as value) if value.denominator == 1 and isinstance(base, Power):
            inner, first = _base_and_exponent(base)
            if inner is not base:
                return Power(inner, Number(first * value))
    return Power(base, exponent)


def call(function: str, *arguments: Formula) -> Formula:
    """A function of its arguments; min(1, max(-1, x)) is sat(x), the saturation of sliding modes."""
    if function in ("min", "max"):
        outer, inner = (ONE, Number(Fraction(-1))) if function == "min" else (Number(Fraction(-1)), ONE)
        other = "max" if function == "min" else "min"
        for bound, rest in (arguments, arguments[::-1]):
            if bound == outer and isinstance(rest, Call) and rest.function == other and inner in rest.arguments:
                a, b = rest.arguments
                return Call("sat", (b if a == inner else a,))
    return Call(function, arguments)


def condition(left: Formula, sign: str, right: Formula) -> Formula:
    """A comparison with the number on its right."""
    if isinstance(left, Number) and not isinstance(right, Number):
        return Relation(right, MIRRORED_SIGNS[sign], left)
    return Relation(left, sign, right)


def truth(formula: Formula) -> Formula:
    """A formula as a condition: a number holds unless it is zero."""
    return formula if isinstance(formula, Relation) else Relation(formula, "!=", ZERO)


def value(formula: Formula) -> Formula:
    """A formula as a number: a condition is 1 where it holds."""
    return Cases(((ONE, formula),), ZERO) if isinstance(formula, Relation) else formula


def negation(formula: Formula) -> Formula:
    """The condition that holds where this one does not."""
    match truth(formula):
        case Relation(left, "and" | "or" as sign, right):
            return Relation(negation(left), "or" if sign == "and" else "and", negation(right))
        case Relation(left, sign, right):
            return Relation(left, OPPOSITE[sign], right)
    return formula


def parts(formula: Formula) -> Iterator[Formula]:
    """A formula and all its parts, from the outside in."""
    yield formula
    for part in children(formula):
        yield from parts(part)


def substitute(formula: Formula, meanings: Mapping[Symbol, Formula]) -> Formula:
    """The formula with each symbol that has a meaning replaced by it."""
    if isinstance(formula, Symbol):
        return meanings.get(formula, formula)
    return rebuilt(formula, [substitute(part, meanings) for part in children(formula)])


def rebuilt(formula: Formula, among: Sequence[Formula]) -> Formula:
    """A formula of the same kind with other parts; of a sum or a product there may be more or fewer."""
    match formula:
        case Sum() | Product():
            return (total if isinstance(formula, Sum) else product)(among)
        case Quotient() | Power():
            return (quotient if isinstance(formula, Quotient) else power)(*among)
        case Call(function):
            return call(function, *among)
        case Relation(_, sign, _):
            return Relation(among[0], sign, among[1])
        case Cases():
            return Cases(tuple(zip(among[:-1:2], among[1::2], strict=True)), among[-1])
        case Matrix(rows):
            entries = iter(among)
            return Matrix(tuple(tuple(next(entries) for _ in row) for row in rows))
    return formula

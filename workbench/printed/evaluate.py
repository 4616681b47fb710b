"""The value of a formula over anything that adds and multiplies: CasADi symbols, numbers, arrays."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from workbench.notation.formula import Call, Formula, Number, Power, Product, Quotient, Sum, Symbol
from workbench.printed.assembly import HIGHEST_POWER
from workbench.printed.names import PI

MOST_WAVES = 100  # in a product; doubles count the terms of no more


class Arithmetic(NamedTuple):
    """What makes a number, and the functions by their names; in both a division by zero gives no finite number."""

    number: Callable[[float], Any]
    functions: Mapping[str, Callable[[Any], Any]]


CASADI = Arithmetic(ca.SX, {"sin": ca.sin, "cos": ca.cos, "tan": ca.tan, "sqrt": ca.sqrt})
NUMPY = Arithmetic(np.float64, {"sin": np.sin, "cos": np.cos, "tan": np.tan, "sqrt": np.sqrt})


def evaluate(formula: Formula, values: Mapping[Symbol, Any], arithmetic: Arithmetic) -> Any:
    """The value of a formula, given those of its symbols.

    A rational number p/q before a product multiplies by p and divides by q, so that a third stays
    exactly one in the expression. The symbol pi is the number, where it has no other value.

    Raises
    ------
    LookupError
        If a symbol has no value.
    ValueError
        If the formula holds what has none, such as a relation, or a number beyond all doubles.
    """
    match formula:
        case Number(value):
            return arithmetic.number(_number(value))
        case Symbol():
            return arithmetic.number(math.pi) if formula == PI and formula not in values else values[formula]
        case Sum(terms):
            total = evaluate(terms[0], values, arithmetic)
            for term in terms[1:]:
                total = total + evaluate(term, values, arithmetic)
            return total
        case Product((Number(Fraction() as ratio), *factors)):
            p, q = (arithmetic.number(_number(part)) for part in (ratio.numerator, ratio.denominator))
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


def _product(factors: Any, values: Mapping[Symbol, Any], arithmetic: Arithmetic) -> Any:
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

"""The value of a formula over anything that adds and multiplies: CasADi symbols, numbers, arrays."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

import casadi as ca
import numpy as np

from workbench.notation.formula import Call, Formula, Number, Power, Product, Quotient, Sum, Symbol
from workbench.notation.parsing.names import PI

Functions = Mapping[str, Callable[[Any], Any]]
CASADI: Functions = {"sin": ca.sin, "cos": ca.cos, "tan": ca.tan, "sqrt": ca.sqrt}
NUMPY: Functions = {"sin": np.sin, "cos": np.cos, "tan": np.tan, "sqrt": np.sqrt}


def evaluate(formula: Formula, values: Mapping[Symbol, Any], functions: Functions) -> Any:
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
            return _number(value)
        case Symbol():
            return math.pi if formula == PI and formula not in values else values[formula]
        case Sum(terms):
            total = evaluate(terms[0], values, functions)
            for term in terms[1:]:
                total = total + evaluate(term, values, functions)
            return total
        case Product((Number(Fraction() as ratio), *factors)):
            return _product(factors, values, functions) * _number(ratio.numerator) / _number(ratio.denominator)
        case Product(factors):
            return _product(factors, values, functions)
        case Quotient(above, below):
            return evaluate(above, values, functions) / evaluate(below, values, functions)
        case Power(base, Number(exponent)):
            return evaluate(base, values, functions) ** float(exponent)
        case Call(function, (argument,)) if function in functions:
            return functions[function](evaluate(argument, values, functions))
    raise ValueError(f"`evaluate(formula)` knows sums, products, powers and sin, cos, tan, sqrt; got {formula!r:.80}.")


def _product(factors: Any, values: Mapping[Symbol, Any], functions: Functions) -> Any:
    result = evaluate(factors[0], values, functions)
    for factor in factors[1:]:
        result = result * evaluate(factor, values, functions)
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
    """A bound on the terms that a formula has once multiplied out, sines and cosines into sums."""
    match formula:
        case Sum(terms):
            return sum(map(expanded_size, terms))
        case Product(factors):
            return math.prod(map(expanded_size, factors)) * 2.0 ** max(sum(map(_oscillates, factors)) - 1, 0)
        case Power(base, Number(exponent)) if exponent > 1:
            k, n = int(min(expanded_size(base), 1e9)), math.ceil(exponent)
            return float(math.comb(k + n - 1, n)) * 2.0 ** (n * _oscillates(base))  # monomials of degree n in k terms
        case Quotient(above, _):
            return expanded_size(above)
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

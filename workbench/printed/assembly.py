"""Parts that were read put together: matrices are scaled and added entry by entry, all else as `build` does."""

from __future__ import annotations

from fractions import Fraction

from workbench.notation import build
from workbench.notation.formula import Formula, Matrix, Number, Power, children
from workbench.printed.tokens import Token, refusal

LARGEST_EXPONENT_OF_TEN = 99
HIGHEST_POWER = 16
MOST_LEVELS = 100  # of parts within parts: what goes through a formula nests up to four of its calls a level


def bounded(formula: Formula, place: Token) -> Formula:
    """A formula whose parts and powers are not nested beyond what can be gone through and multiplied out."""
    waiting = [(formula, 1, Fraction(1))]
    while waiting:
        part, level, power = waiting.pop()
        if level > MOST_LEVELS:
            raise refusal(
                place, f"more than {MOST_LEVELS} operations are nested in each other; write the formula in parts."
            )
        if isinstance(part, Power) and isinstance(part.exponent, Number):
            power *= max(abs(Fraction(part.exponent.value)), Fraction(1))
            if power > HIGHEST_POWER:
                raise refusal(place, f"powers, also powers of powers, go up to {HIGHEST_POWER}.")
        waiting += [(child, level + 1, power) for child in children(part)]
    return formula


def matrix(rows: list[list[Formula]], opening: Token) -> Formula:
    """The matrix of these rows; a lone entry is itself, and a row of rows is what they make one below the other."""
    if len(rows) == 1 and len(rows[0]) == 1:
        return rows[0][0]
    if len(rows) == 1 and any(isinstance(entry, Matrix) and len(entry.rows) == 1 for entry in rows[0]):
        rows = [list(entry.rows[0]) if isinstance(entry, Matrix) else [entry] for entry in rows[0]]
    if len({len(row) for row in rows}) > 1:
        raise refusal(
            opening, f"the rows of a matrix are equally long; these have {', '.join(str(len(row)) for row in rows)}."
        )
    if any(isinstance(entry, Matrix) for row in rows for entry in row):
        raise refusal(opening, "an entry of a matrix is a number, no matrix.")
    return Matrix(tuple(map(tuple, rows)))


def number(token: Token) -> Number:
    """The exact value of a number as it is written."""
    mantissa, _, exponent = token.text.lower().partition("e")
    if exponent and abs(int(exponent)) > LARGEST_EXPONENT_OF_TEN:
        raise refusal(token, f"a number lies between 1e-{LARGEST_EXPONENT_OF_TEN} and 1e{LARGEST_EXPONENT_OF_TEN}.")
    return Number(Fraction(mantissa) * Fraction(10) ** int(exponent or 0))


def product(factors: list[Formula]) -> Formula:
    """The product of numbers, or of numbers and one matrix."""
    matrices = [factor for factor in factors if isinstance(factor, Matrix)]
    if not matrices:
        return build.product(factors) if len(factors) > 1 else factors[0]
    if len(matrices) > 1:
        raise ValueError("a product of two matrices is not read; write its entries.")
    scale = [factor for factor in factors if not isinstance(factor, Matrix)]
    return Matrix(tuple(tuple(build.product([*scale, entry]) for entry in row) for row in matrices[0].rows))


def total(terms: list[Formula]) -> Formula:
    """The sum of numbers, or of matrices of one shape."""
    matrices = [term for term in terms if isinstance(term, Matrix)]
    if not matrices:
        return build.total(terms)
    shapes = {(len(term.rows), len(term.rows[0])) for term in matrices}
    if len(matrices) < len(terms) or len(shapes) > 1:
        raise ValueError("only matrices of one shape are added; write the entries of the sum.")
    rows, columns = shapes.pop()
    return Matrix(
        tuple(tuple(build.total([m.rows[i][j] for m in matrices]) for j in range(columns)) for i in range(rows))
    )

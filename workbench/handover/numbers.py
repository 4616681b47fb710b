"""An arm with its nominal numbers in place of its letters, and without what rounding would leave of them."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import casadi as ca

from workbench.core import AbstractArm, Dynamics
from workbench.notation.normal_form import NormalForm, NotInClass, normal_forms
from workbench.notation.reader import MOST_NODES_OF_TEXTBOOKS
from workbench.validation.signatures import door

SHORT = 2**26  # the denominator of a constant that is meant as it stands: a whole number, a half
LAST_DIGITS = 2**51
MOVED = Fraction(1, 4)  # of a coefficient: what moves by more when last digits do is nothing but these


@door
def in_numbers(arm: AbstractArm, name: str = "") -> Dynamics:
    """The dynamics of an arm over q and qd alone.

    Each number is taken for the decimal fraction that it is printed as, and the sums are exact: what cancels for all
    numbers is gone, however small what stays. Rotations and axes are no fractions. A coefficient that moves by a
    quarter of itself when their last digits move is their rounding, and is left out. An arm whose entries are too long
    for that keeps the arithmetic of doubles.
    """
    plain, letters = Dynamics.of(arm, name, symbolic=False), Dynamics.of(arm, name)
    if ca.n_nodes(ca.horzcat(plain.M, plain.C, plain.G)) > MOST_NODES_OF_TEXTBOOKS:
        return plain
    rows = zip(letters.p.labels, letters.p.default, strict=True)
    numbers = {label: Fraction(repr(float(value))) for label, value in rows}
    try:
        M, C, G = (_without_dust(matrix, numbers, plain) for matrix in (letters.M, letters.C, letters.G))
    except NotInClass:
        return plain
    return replace(plain, M=M, C=C, G=G)


def _without_dust(matrix: ca.SX, numbers: dict[str, Fraction], plain: Dynamics) -> ca.SX:
    exact, *others = (normal_forms(matrix, numbers, constant) for constant in (Fraction, _moved, _moved_otherwise))
    symbols = {symbol.name(): symbol for symbol in ca.vertsplit(ca.vertcat(plain.q, plain.qd))}
    return ca.blockcat(
        [
            [_firm(form, [other[i][j] for other in others]).to_casadi(symbols) for j, form in enumerate(row)]
            for i, row in enumerate(exact)
        ]
    )


def _firm(form: NormalForm, others: list[NormalForm]) -> NormalForm:
    """The terms that stay when last digits move."""
    zero = Fraction(0)
    return NormalForm(
        {
            key: value
            for key, value in form.terms.items()
            if all(abs(other.terms.get(key, zero) - value) <= MOVED * abs(value) for other in others)
        }
    )


def _moved(value: float, digit: int = 1) -> Fraction:
    """A constant with its last digits moved, by one of four amounts that its own digits choose."""
    exact = Fraction(value)
    if exact.denominator <= SHORT:
        return exact
    return exact * (1 + Fraction(2 * (abs(exact.numerator) // digit % 4) - 3, LAST_DIGITS))


def _moved_otherwise(value: float) -> Fraction:
    return _moved(value, 64)

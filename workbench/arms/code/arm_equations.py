"""The equations of an arm for reading: the meaning of its letters, then M, C and G entry by entry.

Where the entries are short they stand in the form of a textbook. Elsewhere the parts that occur more than
once are given names, in order, each before it is used.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from typing import NamedTuple

import casadi as ca
import numpy as np

from workbench.arms.dynamics import AbstractArm, Dynamics
from workbench.core.layout import letters
from workbench.core.notation import latex, mathml, text, typst_math
from workbench.core.notation.comments import harmless
from workbench.core.notation.formula import Matrix, Symbol, System, equations
from workbench.core.notation.normal_form import NormalForm, NotInClass, normal_forms
from workbench.core.notation.reader import MOST_NODES_OF_TEXTBOOKS, equations_of
from workbench.core.templates import fill
from workbench.core.validation.notebook_display import table_to_html
from workbench.core.validation.signatures import check_arguments


@check_arguments
def as_text(dynamics: Dynamics) -> str:
    """Plain text, for a terminal; the letters as comments above, so that `workbench verify` reads it.

    Examples
    --------
    >>> from workbench.arms.code import as_latex, as_mathml, as_text, as_typst
    >>> from workbench.arms.dynamics import Dynamics
    >>> arm = Dynamics.of(wb.robot("planar-1r"), "planar-1r")
    >>> as_text(arm).splitlines()[-1]
    'G_1 = m_1*g*d_1*cos(q_1) + m_1*g*c_1*sin(q_1)'
    >>> [len(write(arm)) > 100 for write in (as_latex, as_mathml, as_typst)]
    [True, True, True]
    """
    head = (f"# {line}" if line else "" for line in _head(dynamics))
    return "\n".join([*head, *("\n" + text.emit(block) for block in _blocks(dynamics))])


@check_arguments
def as_latex(dynamics: Dynamics) -> str:
    """Displays for a document with amsmath; the letters as comments above."""
    head = (f"% {line}".rstrip() for line in _head(dynamics))
    displays = ("\n" + latex.display(block.relations) for block in _blocks(dynamics))
    return "\n".join([*head, "", r"\allowdisplaybreaks", *displays])


@check_arguments
def as_typst(dynamics: Dynamics) -> str:
    """A Typst document; the letters as comments above."""
    head = (f"// {line}".rstrip() for line in _head(dynamics))
    displays = (f"\n$ {typst_math.emit(block)} $" for block in _blocks(dynamics))
    return "\n".join([*head, "", "#set text(11pt)", "#show math.equation: set block(breakable: true)", *displays])


@check_arguments
def as_mathml(dynamics: Dynamics) -> str:
    """A page for a browser."""
    rows = [(letters(letter.name), letter.path, f"{letter.value:g}", letter.unit) for letter in letters_of(dynamics)]
    table = table_to_html("", ("letter", "parameter", "value", "unit"), rows)
    blocks = [mathml.emit(block) for block in _blocks(dynamics)]
    words = {"name": harmless(dynamics.name), "title": title(dynamics), "table": table, "blocks": blocks}
    return fill("workbench.arms", "equations.html.j2", **words).removesuffix("\n")


def _head(dynamics: Dynamics) -> list[str]:
    lines = (f"{x.name:6} {x.path:20} {x.value:g} {x.unit}".rstrip() for x in letters_of(dynamics))
    friction = ["The friction F(qd) is left out here; the programs of this arm have it in tau."]
    return [title(dynamics), *(friction if has_friction(dynamics) else []), *(["", *lines] if dynamics.p.size else [])]


def _blocks(dynamics: Dynamics) -> Iterator[System]:
    definitions, matrices = equations_of({"M": dynamics.M, "C": dynamics.C, "G": dynamics.G}, dynamics.names())
    if definitions:
        yield System(definitions)
    for relation in matrices:
        name, right = relation.left, relation.right
        assert isinstance(name, Symbol)
        yield System(tuple(equations(name, right if isinstance(right, Matrix) else Matrix(((right,),)))))


ROUNDING_OF_TWO_ROADS = 1e-9  # relative; a friction that is smaller would not be felt either


class Letter(NamedTuple):
    """A parameter: how it is printed, its path, its value and unit."""

    name: str
    path: str
    value: float
    unit: str


def title(dynamics: Dynamics) -> str:
    """The heading: the equation of motion, the name of the arm, and its joints without a motor."""
    friction = " + F(qd)" if has_friction(dynamics) else ""
    idle = ", ".join(f"tau_{i + 1} = 0" for i in range(dynamics.dof) if i not in dynamics.motors)
    equation = f"M(q) qdd + C(q, qd) qd + G(q){friction} = tau, n = {dynamics.dof}"
    return f"{harmless(dynamics.name)}: {equation}{f', without a motor: {idle}' if idle else ''}"


def has_friction(dynamics: Dynamics) -> bool:
    """True if the joints have friction, so that a constant velocity takes more than C qd + G."""
    bias = ca.substitute(dynamics.tau, dynamics.qdd, ca.SX.zeros(dynamics.dof))
    smooth = dynamics.C @ dynamics.qd
    unexplained, known = bias - smooth - dynamics.G, ca.fabs(smooth) + ca.fabs(dynamics.G)
    function = ca.Function("friction", [dynamics.q, dynamics.qd, dynamics.symbols], [unexplained, known])
    one = np.ones(dynamics.dof)
    gap, size = (np.array(part) for part in function(one, one, dynamics.p.default))
    return bool(np.any(np.abs(gap) > ROUNDING_OF_TWO_ROADS * np.max(size)))


def letters_of(dynamics: Dynamics) -> list[Letter]:
    """The parameters in their order."""
    names, p = dynamics.names(), dynamics.p
    units = [entry.unit for entry in p.entries for _ in entry.labels()]
    rows = zip(p.labels, p.default, units, strict=True)
    return [Letter(harmless(names[path]), harmless(path), float(value), harmless(unit)) for path, value, unit in rows]


SHORT = 2**26  # the denominator of a constant that is meant as it stands: a whole number, a half
LAST_DIGITS = 2**51
LARGEST_MOVE = Fraction(1, 4)  # of a coefficient: one that moves by more when last digits do is nothing but these


@check_arguments
def in_numbers(arm: AbstractArm, name: str = "") -> Dynamics:
    """The dynamics of an arm over q and qd alone.

    Each number is taken for the decimal fraction that it is printed as, and the sums are exact: terms that cancel are
    gone. Rotations and axes are no fractions. A coefficient that moves by a quarter of itself when their last digits
    move is their rounding, and is left out. An arm whose entries are too long for that keeps the arithmetic of doubles.

    Examples
    --------
    >>> from workbench.arms.code import in_numbers
    >>> in_numbers(wb.robot("planar-1r")).G
    SX((4.905*sin(q[0])))
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
    exact, *others = (
        normal_forms(matrix, numbers, constant)
        for constant in (Fraction, _move_last_digits, lambda value: _move_last_digits(value, 64))
    )
    symbols = {symbol.name(): symbol for symbol in ca.vertsplit(ca.vertcat(plain.q, plain.qd))}
    result = ca.SX(*matrix.shape)
    for i, row in enumerate(exact):
        for j, form in enumerate(row):
            firm = form.terms
            for other in others:
                moved = other[i][j].terms
                firm = {key: x for key, x in firm.items() if abs(moved.get(key, 0) - x) <= LARGEST_MOVE * abs(x)}
            result[i, j] = NormalForm(firm).to_casadi(symbols)
    return result


def _move_last_digits(value: float, digit: int = 1) -> Fraction:
    """A constant with its last digits moved, by one of four amounts that its own digits choose."""
    exact = Fraction(value)
    if exact.denominator <= SHORT:
        return exact
    return exact * (1 + Fraction(2 * (abs(exact.numerator) // digit % 4) - 3, LAST_DIGITS))

"""The letters of an arm, and numbers that a sheet gives for some of them, which then hold for the arm too."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from fractions import Fraction

import casadi as ca
import numpy as np

from workbench.core import Dynamics
from workbench.core.layout import Entry, Layout
from workbench.core.numbers import Bounds
from workbench.notation.formula import Formula, Matrix, Symbol, letters, symbol
from workbench.notation.normal_form import NotInClass
from workbench.printed.exact_form import constant, normal_form
from workbench.printed.grammar import parse
from workbench.printed.names import Names, key_of
from workbench.printed.statements import Statement
from workbench.printed.tokens import refusal
from workbench.validation.refusals import finite, known, nearest
from workbench.validation.signatures import door

LARGEST = 10**99  # and one over it: sizes of numbers that a sheet may give


@door
def symbols_of(dynamics: Dynamics) -> dict[Symbol, str]:
    """The symbols by which an arm is printed, with the names of its expressions' symbols."""
    return {symbol(printed): name for name, printed in dynamics.names().items()}


@door
def narrowed(dynamics: Dynamics, fixed: Mapping[str, float]) -> Dynamics:
    """The same arm with some of its parameters, by their paths, held at numbers.

    Whole numbers are put into its matrices, as doubles compute with them exactly; other parameters keep their
    letters there. One that is a component of a vector becomes an entry of its own.

    Raises
    ------
    LookupError
        If a path is none of the arm's.
    ValueError
        If a number is not finite.
    """
    for label in fixed:
        known(label, dynamics.p.labels, f"parameters of '{dynamics.name}'")
        finite(f"narrowed(fixed={{'{label}': ...}})", fixed[label])
    whole = {label: value for label, value in fixed.items() if float(value).is_integer()}
    places = [dynamics.p.labels.index(label) for label in whole]
    matrices = [dynamics.M, dynamics.C, dynamics.G]
    if places:
        numbers = ca.SX(ca.DM(list(whole.values())))
        matrices = ca.substitute(matrices, [dynamics.symbols[places]], [numbers])
    M, C, G = map(ca.densify, matrices)
    entries = (part for entry in dynamics.p.entries for part in _held(entry, fixed, dynamics.names()))
    return replace(dynamics, M=M, C=C, G=G, p=Layout(tuple(entries)))


def _held(entry: Entry, fixed: Mapping[str, float], names: Mapping[str, str]) -> Iterator[Entry]:
    """An entry, or each of its numbers if one of them is held."""
    if not any(label in fixed for label in entry.labels()):
        yield entry
        return
    for label, default in zip(entry.labels(), entry.default.ravel(order="F"), strict=True):
        value = fixed.get(label, float(default))
        bounds = Bounds(value, value) if label in fixed else entry.bounds
        yield Entry(label, np.array(value), entry.unit, bounds, names[label])


def numbers_given(declared: Mapping[Symbol, Statement], dynamics: Dynamics) -> dict[Symbol, tuple[str, Fraction]]:
    """The declarations that give a number to a parameter of the robot, with its path.

    Raises
    ------
    FormulaError
        If a path is none of the robot's, or is given no number, or one out of its bounds.
    """
    given: dict[Symbol, tuple[str, Fraction]] = {}
    for name, statement in declared.items():
        said = statement.name.text
        if "." in said and said not in dynamics.p.labels:
            raise refusal(
                statement.name,
                f"there is no '{said}' among the numbers of this robot." + nearest(said, dynamics.p.labels),
            )
        if (label := label_of(name, statement, dynamics)) is None:
            continue
        if all(token.kind != "name" for token in statement.right):
            given[name] = label, _number(label, statement, dynamics)
        elif said == label:
            raise refusal(statement.name, f"'{said}' is the robot's own; it can be given a number, as `{said} = 0`.")
    return given


def label_of(name: Symbol, statement: Statement, dynamics: Dynamics) -> str | None:
    """The path of the parameter that is spelled as a declared name; None if there is none."""
    if statement.name.text in dynamics.p.labels:
        return statement.name.text
    wanted = key_of(replace(name, bold=False))
    return next((label for label in dynamics.p.labels if key_of(symbol(dynamics.names()[label])) == wanted), None)


def is_bound(declared: Symbol, statement: Statement, dynamics: Dynamics) -> bool:
    """Whether a declared name is a letter of the robot; another name for one of its numbers may be."""
    by_path = len(statement.right) == 1 and statement.right[0].text in dynamics.p.labels
    return not by_path and label_of(declared, statement, dynamics) is not None


def refuse_half_bound(
    declared: Symbol, statement: Statement, formula: Formula, dynamics: Dynamics, joints: Mapping[Symbol, Symbol]
) -> None:
    """Refuse a formula of constants for a letter of the robot.

    It would hold on the sheet and not in the robot. A shorthand such as c_2 = cos(q_2), and another parameter by
    its path, can be meant for the sheet only.
    """
    if not any(letter in joints or letter.dots for letter in letters(formula)):
        raise refusal(
            statement.name,
            f"'{statement.name.shown}' is this robot's letter for {label_of(declared, statement, dynamics)}, to which "
            "a sheet gives a number or nothing, as a formula would not hold for the robot too; choose another letter.",
        )


def _number(label: str, statement: Statement, dynamics: Dynamics) -> Fraction:
    """The number that a formula without names is."""
    formula = parse(statement.right, Names({}, {}))
    try:
        found = None if isinstance(formula, Matrix) else constant(normal_form(formula, {}))
    except NotInClass:
        found = None
    if found is None:
        raise refusal(statement.name, f"'{statement.name.shown}' of this robot takes one rational number.")
    bounds = next(entry.bounds for entry in dynamics.p.entries if label in entry.labels())
    if found and not Fraction(1, LARGEST) <= abs(found) <= LARGEST:
        raise refusal(statement.name, f"'{label}' must be zero, or of a size between 1e-99 and 1e99; got neither.")
    if not bounds.allow(np.array(float(found))):
        raise refusal(statement.name, f"'{label}' must be {bounds}; got {float(found):g}.")
    return found


def unnamed_zeros(entries: Iterable[Formula], dynamics: Dynamics) -> frozenset[str]:
    """The parameters that are zero in the arm, stand in its M, C or G, and are named by no entry."""
    used = {letter for entry in entries for letter in letters(entry)}
    needed = {s.name() for s in ca.symvar(ca.veccat(dynamics.M, dynamics.C, dynamics.G))}
    names = dynamics.names()
    return frozenset(
        label
        for label, value in zip(dynamics.p.labels, dynamics.p.default, strict=True)
        if value == 0 and label in needed and symbol(names[label]) not in used
    )

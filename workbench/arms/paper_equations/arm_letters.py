"""The letters of an arm on a sheet: its joints however written, rates of angles, and numbers that the sheet gives."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from fractions import Fraction

import casadi as ca
import numpy as np

from workbench.arms.dynamics import Dynamics
from workbench.arms.paper_equations.formula_values import normal_form
from workbench.arms.paper_equations.grammar import parse
from workbench.arms.paper_equations.statements import Statement
from workbench.arms.paper_equations.tokens import Key, Names, key_of, refusal
from workbench.core.layout import Entry, Layout
from workbench.core.notation import build
from workbench.core.notation.formula import Formula, Matrix, Product, Quotient, Sum, Symbol, letters, name_of, symbol
from workbench.core.notation.normal_form import NotInClass
from workbench.core.numbers import Bounds
from workbench.core.validation.refusals import finite, known_name, nearest
from workbench.core.validation.signatures import check_arguments

LARGEST = 10**99  # and one over it: sizes of numbers that a sheet may give


def symbols_of(dynamics: Dynamics) -> dict[Symbol, str]:
    """The symbols by which an arm is printed, with the names of its expressions' symbols."""
    return {symbol(printed): name for name, printed in dynamics.names().items()}


@check_arguments
def fix_parameters(dynamics: Dynamics, fixed_numbers: Mapping[str, float]) -> Dynamics:
    """The same arm with some of its parameters, by their paths, fixed to numbers.

    Whole numbers are put into its matrices, as doubles compute with them exactly; other parameters keep their
    letters there. One that is a component of a vector becomes an entry of its own.
    """
    for label in fixed_numbers:
        known_name(label, dynamics.p.labels, f"parameters of '{dynamics.name}'")
        finite(f"narrowed(fixed={{'{label}': ...}})", fixed_numbers[label])
    whole = {label: value for label, value in fixed_numbers.items() if float(value).is_integer()}
    places = [dynamics.p.labels.index(label) for label in whole]
    matrices = [dynamics.M, dynamics.C, dynamics.G]
    if places:
        numbers = ca.SX(ca.DM(list(whole.values())))
        matrices = ca.substitute(matrices, [dynamics.symbols[places]], [numbers])
    M, C, G = map(ca.densify, matrices)
    entries = (part for entry in dynamics.p.entries for part in _fixed_entries(entry, fixed_numbers, dynamics.names()))
    return replace(dynamics, M=M, C=C, G=G, p=Layout(tuple(entries)))


def _fixed_entries(entry: Entry, fixed_numbers: Mapping[str, float], names: Mapping[str, str]) -> Iterator[Entry]:
    if not any(label in fixed_numbers for label in entry.labels()):
        yield entry
        return
    for label, default in zip(entry.labels(), entry.default.ravel(order="F"), strict=True):
        value = fixed_numbers.get(label, float(default))
        bounds = Bounds(value, value) if label in fixed_numbers else entry.bounds
        yield Entry(label, np.array(value), entry.unit, bounds, names[label])


def numbers_given(declarations: Mapping[Symbol, Statement], dynamics: Dynamics) -> dict[Symbol, tuple[str, Fraction]]:
    """The declarations that give a number to a parameter of the robot, with its path; one out of bounds is refused."""
    given: dict[Symbol, tuple[str, Fraction]] = {}
    for name, statement in declarations.items():
        path, label = statement.name.text, parameter_of(name, statement, dynamics)
        if "." in path and label is None:
            near = nearest(path, dynamics.p.labels)
            raise refusal(statement.name, f"there is no '{path}' among the numbers of this robot.{near}")
        if label and all(token.kind != "name" for token in statement.right):
            given[name] = label, _number(label, statement, dynamics)
        elif path == label:
            raise refusal(statement.name, f"'{path}' is the robot's own; it can be given a number, as `{path} = 0`.")
    return given


def parameter_of(name: Symbol, statement: Statement, dynamics: Dynamics) -> str | None:
    """The path of the parameter that is spelled as a declared name; None if there is none."""
    if statement.name.text in dynamics.p.labels:
        return statement.name.text
    wanted = key_of(replace(name, bold=False))
    return next((label for label in dynamics.p.labels if key_of(symbol(dynamics.names()[label])) == wanted), None)


def _number(label: str, statement: Statement, dynamics: Dynamics) -> Fraction:
    formula = parse(statement.right, Names({}, {}))
    try:
        number = None if isinstance(formula, Matrix) else normal_form(formula, {}).number
    except NotInClass:
        number = None
    if number is None:
        raise refusal(statement.name, f"'{statement.name.quotation}' of this robot takes one rational number.")
    bounds = next(entry.bounds for entry in dynamics.p.entries if label in entry.labels())
    if number and not Fraction(1, LARGEST) <= abs(number) <= LARGEST:
        raise refusal(statement.name, f"'{label}' must be zero, or of a size between 1e-99 and 1e99; got neither.")
    if not bounds.allow(np.array(float(number))):
        raise refusal(statement.name, f"'{label}' must be {bounds}; got {float(number):g}.")
    return number


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


def names_of(dynamics: Dynamics, printed_symbols: Iterable[Symbol], declared_symbols: Iterable[Symbol]) -> Names:
    """The names that a formula of a sheet may use; those that the sheet prints or declares come first.

    A declared name takes the spellings of its rate with it: where theta_2 is not q_2, theta_2' is not qd_2.
    The rate of a declared name is that name with a dot.
    """
    known: dict[Key, Symbol] = {}
    for letter in symbols_of(dynamics):
        if (other := known.setdefault(key_of(letter), letter)) != letter:
            raise ValueError(f"this robot prints both '{name_of(other)}' and '{name_of(letter)}', which read alike.")
    joints: dict[Key, Symbol] = {}
    for i in range(1, dynamics.dof + 1):
        q, qd = Symbol("q", str(i)), Symbol("q", str(i), 1)
        for head in ("q", "theta"):
            for index in (str(i), "") if dynamics.dof == 1 else (str(i),):
                joints |= {(head + index, 0, ""): q, (head + index, 1, ""): qd}
                joints |= dict.fromkeys(_rates_in_letters(head, index), qd)
    keys = {key: letter for key, letter in joints.items() if key not in known} | known
    own = list(declared_symbols)
    for angle in own:
        if angle.dots == 0:
            rate = replace(angle, dots=1)
            keys[key_of(rate)] = rate
            keys |= {key: rate for key in _rates_in_letters(angle.letter, angle.index) if key in joints}
    paths = {label: symbol(dynamics.names()[label]) for label in dynamics.p.labels}
    return Names(keys | {key_of(name): name for name in (*printed_symbols, *own)}, paths)


def _rates_in_letters(letter: str, index: str) -> Iterator[Key]:
    """The rate of an angle without a dot: dtheta_1, thetadot_1, theta_1dot."""
    for name in (f"d{letter}{index}", f"{letter}dot{index}", f"{letter}{index}dot"):
        yield name, 0, ""


def rate_of(formula: Formula, joints: Mapping[Symbol, Symbol]) -> Formula | None:
    """The derivative in time of a formula that is linear in the angles of the joints; None of any other.

    `joints` has the symbol of each velocity by that of its angle; all other letters without a dot are constant.
    """
    match formula:
        case Symbol(dots=0):
            return joints.get(formula, build.ZERO)
        case Sum(terms):
            rates = [rate_of(term, joints) for term in terms]
            return None if None in rates else build.total(rate for rate in rates if rate is not None)
        case Product(factors):
            moving = [i for i, factor in enumerate(factors) if rate_of(factor, joints) != build.ZERO]
            if not moving:
                return build.ZERO
            rate = rate_of(factors[moving[0]], joints) if len(moving) == 1 else None
            return None if rate is None else build.product([*factors[: moving[0]], rate, *factors[moving[0] + 1 :]])
        case Quotient(above, below) if rate_of(below, joints) == build.ZERO:
            rate = rate_of(above, joints)
            return None if rate is None else build.quotient(rate, below)
    constant = not any(letter in joints or letter.dots for letter in letters(formula))
    return build.ZERO if constant else None

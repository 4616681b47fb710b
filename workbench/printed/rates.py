"""The names of a sheet: an arm's letters, its joints however written, and the rates of declared angles."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

from workbench.core import Dynamics
from workbench.notation import build
from workbench.notation.formula import Formula, Number, Product, Quotient, Sum, Symbol, letters, name_of, symbol
from workbench.printed.given import symbols_of
from workbench.printed.names import Key, Names, key_of


def names_of(dynamics: Dynamics, printed: Iterable[Symbol], declared: Iterable[Symbol]) -> Names:
    """What a formula of a sheet may name; what the sheet prints or declares comes first.

    A declared name takes the spellings of its rate with it: where theta_2 is not q_2, theta_2' is not qd_2.
    The rate of a declared name is that name with a dot.

    Raises
    ------
    ValueError
        If two letters of the arm read alike.
    """
    known: dict[Key, Symbol] = {}
    for letter in symbols_of(dynamics):
        if (other := known.setdefault(key_of(letter), letter)) != letter:
            raise ValueError(f"this robot prints both '{name_of(other)}' and '{name_of(letter)}', which read alike.")
    joints = _joints(dynamics)
    keys = {key: letter for key, letter in joints.items() if key not in known} | known
    own = list(declared)
    for angle in own:
        if angle.dots == 0:
            rate = replace(angle, dots=1)
            keys[key_of(rate)] = rate
            keys |= {key: rate for key in _rates_in_letters(angle.letter, angle.index) if key in joints}
    paths = {label: symbol(dynamics.names()[label]) for label in dynamics.p.labels}
    return Names(keys | {key_of(name): name for name in (*printed, *own)}, paths)


def _joints(dynamics: Dynamics) -> dict[Key, Symbol]:
    """How else the angles and velocities of the joints are written."""
    keys: dict[Key, Symbol] = {}
    for i in range(1, dynamics.dof + 1):
        q, qd = Symbol("q", str(i)), Symbol("q", str(i), 1)
        for letter in ("q", "theta"):
            for index in (str(i), "") if dynamics.dof == 1 else (str(i),):
                keys[letter + index, 0, ""] = q
                keys[letter + index, 1, ""] = qd
                keys |= dict.fromkeys(_rates_in_letters(letter, index), qd)
    return keys


def _rates_in_letters(letter: str, index: str) -> Iterator[Key]:
    """The rate of an angle without a dot: dtheta_1, thetadot_1, theta_1dot."""
    for name in (f"d{letter}{index}", f"{letter}dot{index}", f"{letter}{index}dot"):
        yield name, 0, ""


def rate_of(formula: Formula, joints: Mapping[Symbol, Symbol]) -> Formula | None:
    """The derivative in time of a formula that is linear in the angles of the joints; None of any other.

    Parameters
    ----------
    joints
        The symbol of each velocity by that of its angle; all other letters without a dot are constant.
    """
    match formula:
        case Symbol(dots=0):
            return joints.get(formula, build.ZERO)
        case Number():
            return build.ZERO
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

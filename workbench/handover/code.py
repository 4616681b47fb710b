"""The programs of an arm, and what their comments say, in whichever language."""

from __future__ import annotations

import keyword
from collections.abc import Iterable, Mapping
from typing import NamedTuple

import casadi as ca

from workbench.core import Dynamics
from workbench.handover.letters import letters_of, title
from workbench.notation.program import CALLED, Dialect, Program, straight_line

# Names that the written functions use themselves.
OWN = (
    "q qd qdd tau p M C G n i j k l D LT order rest matrices torque ca np NOMINAL "
    "dynamics inverse_dynamics forward_dynamics"
)
C_WORDS = (
    "auto break case char const continue default do double else enum extern float for goto if inline int long "
    "register restrict return short signed sizeof static struct switch typedef union unsigned void volatile while "
    "j0 j1 jn y0 y1 yn gamma exp2 div abs main signgam"
)
RESERVED = frozenset([*OWN.split(), *C_WORDS.split(), *CALLED.split(), "min", "max", *keyword.kwlist])


class Routine(NamedTuple):
    """Where each variable is read from, as `m_1 = p[0]`, and the program over these."""

    reads: list[str]
    program: Program


def matrices_of(dynamics: Dynamics, dialect: Dialect) -> Routine:
    """(q, qd, p) -> M, C, G."""
    return _routine(dynamics, {"M": dynamics.M, "C": dynamics.C, "G": dynamics.G}, dialect)


def torque_of(dynamics: Dynamics, dialect: Dialect) -> Routine:
    """(q, qd, qdd, p) -> tau."""
    return _routine(dynamics, {"tau": dynamics.tau}, dialect)


def _routine(dynamics: Dynamics, matrices: Mapping[str, ca.SX], dialect: Dialect) -> Routine:
    joints = [(letter, i) for letter in ("q", "qd", "qdd") for i in range(dynamics.dof)]
    letters = {f"{letter}[{i}]": f"{letter}_{i + 1}" for letter, i in joints}
    program = straight_line(matrices, letters | dynamics.names(), dialect)
    variables = {name: variable for variable, name in program.inputs}
    places = {name: name for name in letters} | {path: f"p[{k}]" for k, path in enumerate(dynamics.p.labels)}
    return Routine([f"{variables[name]} = {place}" for name, place in places.items() if name in variables], program)


def about(dynamics: Dynamics) -> list[str]:
    """The equation of motion and what each argument means, one a line."""
    lengths, forces = _units(dynamics.units), _units("N" if unit == "m" else "N m" for unit in dynamics.units)
    meanings = {
        "q, qd, qdd": f"positions, velocities and accelerations of the joints, in {lengths}, per s and s^2",
        "tau": f"what drives the joints, in {forces}",
        "p": "parameters, in the order of the nominal values below" if dynamics.p.size else "",
        "M, C, G": "C of the Christoffel symbols: M' - 2 C is skew",
    }
    return [title(dynamics), "", *(f"{name:<12}{meaning}" for name, meaning in meanings.items() if meaning)]


def _units(each: Iterable[str]) -> str:
    """The units of the joints, one by one where they differ."""
    units = list(each)
    return units[0] if len(set(units)) == 1 else f"({', '.join(units)})"


def nominal(dynamics: Dynamics) -> list[tuple[str, str]]:
    """The nominal values in their order, each with what it is."""
    return [(repr(x.value), f"{x.name}, {x.path}{f' [{x.unit}]' if x.unit else ''}") for x in letters_of(dynamics)]

"""The letters of an arm, and numbers that a sheet gives for some of them, which then hold for the arm too."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import casadi as ca
import numpy as np

from workbench.core import Dynamics
from workbench.core.layout import Bounds, Layout
from workbench.notation.formula import Formula, Number, Symbol, letters, symbol
from workbench.notation.parsing.grammar import parse
from workbench.notation.parsing.names import Names, key_of
from workbench.notation.parsing.statements import Statement
from workbench.notation.parsing.tokens import refusal


def symbols_of(dynamics: Dynamics) -> dict[Symbol, str]:
    """The symbols by which an arm is printed, with the names of its expressions' symbols."""
    return {symbol(printed): name for name, printed in dynamics.names().items()}


def narrowed(dynamics: Dynamics, fixed: Mapping[str, float]) -> Dynamics:
    """The same arm with some of its parameters, by their paths, fixed to numbers."""
    places = [dynamics.p.labels.index(label) for label in fixed]
    numbers = ca.SX(ca.DM(list(fixed.values())))
    matrices = [dynamics.M, dynamics.C, dynamics.G]
    if places:
        matrices = ca.substitute(matrices, [dynamics.symbols[places]], [numbers])
    entries = (
        replace(entry, default=np.array(fixed[entry.name]), bounds=Bounds(fixed[entry.name], fixed[entry.name]))
        if entry.name in fixed
        else entry
        for entry in dynamics.p.entries
    )
    M, C, G = map(ca.densify, matrices)
    return replace(dynamics, M=M, C=C, G=G, p=Layout(tuple(entries)))


def numbers_given(declared: Mapping[Symbol, Statement], dynamics: Dynamics) -> dict[Symbol, tuple[str, float]]:
    """The declarations that give a number to a parameter of the robot, with its path."""
    labels = {key_of(symbol(dynamics.names()[label])): label for label in dynamics.p.labels}
    given: dict[Symbol, tuple[str, float]] = {}
    for name, statement in declared.items():
        said = statement.name.text
        label = said if said in dynamics.p.labels else labels.get(key_of(replace(name, bold=False)))
        if any(token.kind in ("name", "function") for token in statement.right):
            if said in dynamics.p.labels:
                raise refusal(
                    statement.name, f"'{said}' is the robot's own; it can be given a number, as `{said} = 0`."
                )
        elif label is not None:
            value = parse(statement.right, Names({}, {}))
            if not isinstance(value, Number) or label not in dynamics.p.names:
                raise refusal(statement.name, f"'{statement.name.shown}' of this robot takes one number.")
            if not dynamics.p[label].bounds.allow(np.array(float(value.value))):
                raise refusal(
                    statement.name, f"'{label}' must be {dynamics.p[label].bounds}; got {float(value.value):g}."
                )
            given[name] = label, float(value.value)
    return given


def unnamed_zeros(entries: Iterable[Formula], dynamics: Dynamics) -> dict[str, float]:
    """The parameters that are zero in the arm and that no entry names."""
    used = {letter for entry in entries for letter in letters(entry)}
    names = dynamics.names()
    return {
        entry.name: 0.0
        for entry in dynamics.p.entries
        if not entry.shape and entry.default == 0 and symbol(names[entry.name]) not in used
    }

"""The values of an arm's letters and entries at some states, by which formulas are told apart without algebra."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from workbench.core import Dynamics
from workbench.notation.formula import Symbol
from workbench.printed.given import symbols_of
from workbench.printed.sheet import Place
from workbench.proofs.witness import Witness, candidates
from workbench.validation.refusals import Array

STATES = 8  # two equations agree by chance at one, not at so many


@dataclass(frozen=True, eq=False)
class Values:
    """The values of all letters of an arm, and of its entries of M, C and G, each (K,); velocities are (n, K)."""

    symbols: Mapping[Symbol, Array]
    entries: Mapping[Place, Array]
    velocities: Array


def varied_values(derived: Dynamics) -> Values:
    """The values near some states, each with parameters of its own."""
    return _at(derived, candidates(derived)[-STATES:])


def nominal_values(derived: Dynamics) -> Values:
    """The values near some states, at the nominal parameters."""
    return _at(derived, candidates(derived)[:STATES])


def _at(derived: Dynamics, states: Sequence[Witness]) -> Values:
    q, qd, p = (np.stack([getattr(state, name) for state in states], axis=1) for name in ("q", "qd", "p"))
    off = 0.01 * np.sqrt(np.arange(2.0, 2.0 + q.size)).reshape(q.shape)  # sums of round numbers vanish
    q, qd = q + off, qd + off
    names = [s.name() for s in ca.vertsplit(ca.vertcat(derived.q, derived.qd, derived.symbols))]
    rows = dict(zip(names, np.vstack([q, qd, p]), strict=True))
    symbols = {letter: rows[name] for letter, name in symbols_of(derived).items()}
    entries: dict[Place, Array] = {}
    for name, matrix in (("M", derived.M), ("C", derived.C), ("G", derived.G)):
        numbers = np.array(ca.Function("entries", [derived.q, derived.qd, derived.symbols], [ca.vec(matrix)])(q, qd, p))
        for k, row in enumerate(numbers):
            entries[name, k % matrix.shape[0] + 1, k // matrix.shape[0] + 1] = row
    return Values(symbols, entries, qd)

"""Identities of an arm: an expression that is zero in all states, proved, refuted by a witness, or left open.

A witness is a state with plain numbers at which a claim about an arm fails. The search for one is deterministic and
takes round numbers, the plainest first; then other parameters, as a misprint may hide at the nominal ones.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import casadi as ca
import numpy as np

from workbench.arms.dynamics import Dynamics
from workbench.core.numbers import Bounds
from workbench.core.validation.refusals import Array, numbers
from workbench.core.validation.signatures import check_arguments
from workbench.proofs.branch_and_bound import sequence
from workbench.proofs.equality import Kind, reason_unproved, vanishes

STATES = 200
MOST_ENTRIES = 20_000  # two matrices of a hundred joints
# A difference counts from this share of the largest term it is made of: the first is one that a reader sees at once,
# the second far above rounding (1e-15 a term) and far below any misprint.
VISIBLE, FAINT = 1e-3, 1e-9


@dataclass(frozen=True, eq=False)
@check_arguments
class Witness:
    """A state (q, qd) of an arm with its parameters p (np,), in words and as a line of Python.

    `changed_parameters` holds the parameters that are not nominal, and those that a sheet holds at a number.
    """

    q: Array
    qd: Array
    p: Array
    changed_parameters: dict[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("q", "qd", "p"):
            numbers(f"Witness({name}=...)", getattr(self, name), ndim=1)

    def __str__(self) -> str:
        numbers = ", ".join(f"{name} = {value:g}" for name, value in self.changed_parameters.items())
        return (
            f"q = {_tuple(self.q, short=True)}, qd = {_tuple(self.qd, short=True)}, {numbers or 'nominal parameters'}"
        )

    @property
    def replay(self) -> str:
        """The line of Python that gives M, C and G at this state, for any `dynamics` in question."""
        p = f", dynamics.p.pack({self.changed_parameters})[0]" if self.changed_parameters else ""
        return f"M, C, G = dynamics.matrices({_tuple(self.q)}, {_tuple(self.qd)}{p})"


@dataclass(frozen=True, eq=False)
class WitnessSearch:
    """The outcome of a search: the first witness and the expression there (k,), or none in so many finite samples."""

    witness: Witness | None
    values: Array
    samples: int


@check_arguments
def search(expression: ca.SX, terms: ca.SX, dynamics: Dynamics) -> WitnessSearch:
    """The first candidate at which `expression` (k, 1) is plainly not zero, beside the largest of its `terms`."""
    for name, sought in (("expression", expression), ("terms", terms)):
        if not 0 < sought.numel() <= MOST_ENTRIES:
            raise ValueError(f"`search({name}=...)` must have 1 to {MOST_ENTRIES} entries; got {sought.numel()}.")
    states, inputs = candidates(dynamics), [dynamics.q, dynamics.qd, dynamics.symbols]
    known = {symbol.name() for symbol in ca.symvar(ca.vertcat(*inputs))}
    for symbol in ca.symvar(ca.veccat(expression, terms)):
        if symbol.name() not in known:
            raise ValueError(f"A witness gives numbers to the symbols of an arm; it has none for '{symbol.name()}'.")
    function = ca.Function("sought", inputs, [ca.vec(ca.densify(expression)), ca.vec(ca.densify(terms))])
    columns = [np.stack([getattr(s, name) for s in states], axis=1) for name in ("q", "qd", "p")]
    values, sizes = (np.array(part).T for part in function(*columns))
    finite = np.isfinite(values).all(axis=1) & np.isfinite(sizes).all(axis=1)
    scale = np.abs(sizes[finite]).max(initial=0.0)
    largest = np.where(finite, np.abs(np.where(finite[:, None], values, 0)).max(axis=1, initial=0.0), 0.0)
    for threshold in (VISIBLE, FAINT):
        if (found := np.flatnonzero(largest > threshold * scale)).size:
            return WitnessSearch(states[found[0]], values[found[0]], int(finite.sum()))
    return WitnessSearch(None, np.zeros(0), int(finite.sum()))


@check_arguments
@lru_cache(maxsize=4)  # every entry of an arm is searched at the same states
def candidates(dynamics: Dynamics) -> tuple[Witness, ...]:
    """States in the order of the search: at nominal parameters first, then at varied ones."""
    n = dynamics.dof
    plain = np.concatenate([0.5 * np.arange(1, n + 1), (-1.0) ** np.arange(n)])
    spread = np.round((sequence(STATES - 1, 2 * n) - 0.5) * np.repeat([6.0, 4.0], n), 1)
    states = np.vstack([plain, spread])
    layout, fixed = dynamics.p, fixed_parameters(dynamics)
    nominal = [Witness(x[:n], x[n:], layout.default, fixed) for x in states]
    places = [
        (label, i, entry.bounds)
        for entry in layout.entries
        for label, i in zip(entry.labels(), layout.indices(entry.name), strict=True)
    ]
    draws = zip(states, sequence(STATES, layout.size), strict=True)
    varied = [_varied_witness(dynamics, x, u, places, fixed) for x, u in draws]
    return tuple(nominal + varied if dynamics.p.size else nominal)


def fixed_parameters(dynamics: Dynamics) -> dict[str, float]:
    """The parameters that can have one value only, by their paths."""
    return {entry.name: float(entry.default) for entry in dynamics.p.entries if entry.bounds.low == entry.bounds.high}


def _varied_witness(
    dynamics: Dynamics, x: Array, u: Array, places: Sequence[tuple[str, int, Bounds]], fixed_values: Mapping[str, float]
) -> Witness:
    n, nominal = dynamics.dof, dynamics.p.default
    wanted = np.round(np.where(nominal == 0, 1.0, nominal) * np.round(0.5 + 1.5 * u, 1), 12)
    changed, p = dict(fixed_values), nominal.copy()
    for label, i, bounds in places:
        if wanted[i] != nominal[i] and bounds.allow(wanted[i]):
            changed[label] = float(wanted[i])
            p[i] = wanted[i]
    return Witness(x[:n], x[n:], p, changed)


def _tuple(values: Array, *, short: bool = False) -> str:
    """Numbers as a tuple of Python: in few digits if `short` or where that is the same number, else in all."""
    said = [f"{x:g}" if short or float(f"{x:g}") == x else repr(float(x)) for x in values]
    return f"({said[0]},)" if len(said) == 1 else f"({', '.join(said)})"


@dataclass(frozen=True, eq=False)
class IdentityVerdict:
    """The verdict on `expression = 0`, its evidence, and the outcome of the search for a witness if there was one."""

    kind: Kind
    evidence: str
    search: WitnessSearch | None


@check_arguments
def judge_zero(expression: ca.SX, terms: ca.SX, dynamics: Dynamics) -> IdentityVerdict:
    """Judge whether every element of `expression`, a difference of `terms`, is zero for all q, qd and parameters.

    `proved` rests on exact rational arithmetic alone, `refuted` on a state where the value is plainly not zero; numbers
    that happen to agree prove nothing, and are called `not refuted`.
    """
    return proved_or_searched(lambda: vanishes(expression), expression, terms, dynamics)


def proved_or_searched(
    equal: Callable[[], bool], expression: ca.SX, terms: ca.SX, dynamics: Dynamics
) -> IdentityVerdict:
    """The verdict by `equal`, which compares normal forms or raises NotInClass, else by a search for a witness."""
    if not (why := reason_unproved(equal, "state")):
        return IdentityVerdict("proved", "equal normal forms: an identity in all states and all parameters", None)
    found = search(expression, terms, dynamics)
    if found.witness is not None:
        return IdentityVerdict("refuted", f"at {found.witness}", found)
    return IdentityVerdict("not refuted", f"not refuted in {found.samples} samples, and not proved: {why}", found)

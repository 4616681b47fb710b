"""Identities: an expression that is zero for all values of its symbols, proved, refuted by a witness, or left open."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import casadi as ca
import numpy as np

from workbench.core import Dynamics
from workbench.notation.normal_form import NotInClass, normal_forms
from workbench.notation.program import Walk, walk
from workbench.proofs.interval import Interval, NoBound, evaluate
from workbench.proofs.witness import Search, search
from workbench.validation.refusals import Array
from workbench.validation.signatures import door

Kind = Literal["proved", "refuted", "not refuted"]

POINTS = 64
# A difference counts from this share of the larger side: far above rounding, far below any slip.
PLAIN = 1e-6


@dataclass(frozen=True, eq=False)
class Judgement:
    """The verdict on `expression = 0`, its evidence, and the outcome of the search for a witness if there was one."""

    kind: Kind
    evidence: str
    search: Search | None


@door
def judge_zero(expression: ca.SX, terms: ca.SX, dynamics: Dynamics) -> Judgement:
    """Judge whether every element of `expression` is zero for all q, qd and parameters.

    `proved` rests on exact rational arithmetic alone, `refuted` on a state where the value is not zero; numbers that
    happen to agree prove nothing, and are called `not refuted`. The scale of the search for a witness are the `terms`
    that the expression is the difference of.
    """
    return proved_or_searched(lambda: _vanishes(expression), expression, terms, dynamics)


def proved_or_searched(vanishes: Callable[[], bool], expression: ca.SX, terms: ca.SX, dynamics: Dynamics) -> Judgement:
    """The verdict by `vanishes`, which compares normal forms or raises NotInClass, else by a search for a witness."""
    why = "the normal forms differ, but no state was found where the values do"
    try:
        if vanishes():
            return Judgement("proved", "equal normal forms: an identity in all states and all parameters", None)
    except NotInClass as outside:
        why = str(outside)
    found = search(expression, terms, dynamics)
    if found.witness is not None:
        return Judgement("refuted", f"at {found.witness}", found)
    return Judgement("not refuted", f"not refuted in {found.samples} samples, and not proved: {why}", found)


@dataclass(frozen=True, eq=False)
class Equality:
    """The verdict on `left = right`, entry by entry and all at once.

    If refuted, `point` has the values of the symbols, by name, at which the two differ, and both sides there, flat.
    """

    kind: Kind
    evidence: str
    point: dict[str, float] | None = None
    left: Array | None = None
    right: Array | None = None


@door
def judge_equal(left: ca.SX, right: ca.SX) -> Equality:
    """Judge `left = right` for all values of the symbols in them.

    The witness is the first of a fixed list of points with one decimal: small whole numbers are tried first, in
    the order of the symbols' names. There intervals must prove that the two differ: what rounding makes of terms
    that cancel refutes nothing.
    """
    if left.shape != right.shape:
        raise ValueError(f"`judge_equal(left, right)` compares equal shapes; got {left.shape} and {right.shape}.")
    try:
        if _vanishes(ca.vec(left - right)):
            return Equality("proved", "equal normal forms: an identity in all symbols")
        why = "the normal forms differ, but no point was found where the values do"
    except NotInClass as outside:
        why = str(outside)
    symbols = sorted(ca.symvar(ca.vertcat(ca.vec(left), ca.vec(right))), key=lambda symbol: str(symbol.name()))
    names = [symbol.name() for symbol in symbols]
    sides = ca.Function("sides", [ca.vertcat(*symbols)], [ca.densify(ca.vec(left)), ca.densify(ca.vec(right))])
    steps, seen = walk(left - right), 0
    for point in _points(len(names)):
        a, b = (np.array(side).ravel() for side in sides(point))
        if not np.isfinite([a, b]).all():
            continue
        seen += 1
        values = dict(zip(names, point.tolist(), strict=True))
        plain = (np.abs(a - b) > PLAIN * np.maximum(np.maximum(np.abs(a), np.abs(b)), 1e-3)).any()
        if plain and _apart(steps, values):
            shown = ", ".join(f"{name} = {value:g}" for name, value in values.items())
            return Equality("refuted", f"at {shown}", values, a, b)
    return Equality("not refuted", f"not refuted in {seen} samples, and not proved: {why}")


def _vanishes(expression: ca.SX) -> bool:
    forms = normal_forms(ca.densify(expression))
    return all(form.is_zero for row in forms for form in row)


def _apart(difference: Walk, values: dict[str, float]) -> bool:
    try:
        entries = evaluate(difference, {name: Interval(*[np.array([x])] * 2) for name, x in values.items()})
    except NoBound:  # an operation of which no interval is known
        return False
    return any(bool(entry.low[0] > 0 or entry.high[0] < 0) for entry in entries)


def _points(size: int) -> Array:
    """Points (POINTS, size) with one decimal: a plain one first, then some that are spread by a fixed seed."""
    plain = 1 + np.arange(size) % 3 / 2
    spread = np.round(np.random.default_rng(0).uniform(-3, 3, (POINTS - 1, size)), 1)
    return np.vstack([plain, spread])

"""Equality of two expressions for all values of their symbols: proved, refuted by a witness, or left open."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import casadi as ca
import numpy as np

from workbench.core.notation.normal_form import NotInClass, normal_forms
from workbench.core.notation.program import Walk, walk
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.proofs.interval import Interval, NoBound, evaluate

Kind = Literal["proved", "refuted", "not refuted"]

POINTS = 64  # at which two sides are compared
PLAIN = 1e-6  # of the larger side, from which on a difference counts: far above rounding


def reason_unproved(equal: Callable[[], bool], place: str) -> str:
    """The reason why normal forms prove nothing; empty if they prove that an expression vanishes."""
    try:
        return "" if equal() else f"the normal forms differ, but no {place} was found where the values do"
    except NotInClass as outside:
        return str(outside)


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


@check_arguments
def judge_equal(left: ca.SX, right: ca.SX) -> Equality:
    """Judge `left = right` for all values of the symbols in them.

    The witness is the first of a fixed list of points with one decimal at which intervals prove that the two differ. So
    a rounding error in terms that cancel does not refute the equality.
    """
    if left.shape != right.shape:
        raise ValueError(f"`judge_equal(left, right)` compares equal shapes; got {left.shape} and {right.shape}.")
    if not (why := reason_unproved(lambda: vanishes(ca.vec(left - right)), "point")):
        return Equality("proved", "equal normal forms: an identity in all symbols")
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


def vanishes(expression: ca.SX) -> bool:
    """True if the normal form of every entry is zero."""
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

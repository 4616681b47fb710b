"""Are two expressions equal for all values of their symbols? Proved by normal form, or refuted at a plain point."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from workbench.notation.normal_form import NotInClass, normal_forms
from workbench.notation.program import Walk, walk
from workbench.proofs.identity import Kind
from workbench.proofs.interval import Interval, NoBound, evaluate
from workbench.validation.refusals import Array
from workbench.validation.signatures import door

POINTS = 64
# A difference counts from this share of the larger side: far above rounding, far below any slip.
PLAIN = 1e-6


@dataclass(frozen=True, eq=False)
class Equality:
    """How it stands with `left = right`, entry by entry and all at once.

    Attributes
    ----------
    point
        The values of the symbols, by name, at which the two differ; None unless refuted.
    left, right
        Both sides there, flat.
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

    Raises
    ------
    ValueError
        If the two have different shapes: then there is nothing to compare.
    """
    if left.shape != right.shape:
        raise ValueError(f"`judge_equal(left, right)` compares equal shapes; got {left.shape} and {right.shape}.")
    difference = ca.vec(ca.densify(left - right))
    try:
        if all(form.is_zero for row in normal_forms(difference) for form in row):
            return Equality("proved", "equal normal forms: an identity in all symbols")
        why = "the normal forms differ, but no point was found where the values do"
    except NotInClass as outside:
        why = str(outside)
    return _sought(left, right, why)


def _sought(left: ca.SX, right: ca.SX, why: str) -> Equality:
    """A witness among the points, or none."""
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


def _apart(difference: Walk, values: dict[str, float]) -> bool:
    """Whether an entry of a difference is proved not to be zero at a point."""
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

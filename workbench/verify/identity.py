"""Is an expression zero for all states and parameters? Proved, refuted by a witness, or left open."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import casadi as ca

from workbench.core import Dynamics
from workbench.notation.normal_form import NotInClass, normal_forms
from workbench.verify.witness import Search, search

Kind = Literal["proved", "refuted", "not refuted"]
# A thousand roundings of all terms together: no misprint is as small.
LAST_DIGITS = 1e-13


@dataclass(frozen=True, eq=False)
class Judgement:
    """How it stands with `expression = 0`, on what evidence, and what the search for a witness found."""

    kind: Kind
    evidence: str
    search: Search | None


def judge_zero(expression: ca.SX, terms: ca.SX, dynamics: Dynamics) -> Judgement:
    """Judge whether every element of `expression` is zero for all q, qd and parameters.

    `proved` rests on exact rational arithmetic alone, `refuted` on a state where the value is not
    zero; numbers that happen to agree prove nothing, and are called `not refuted`.

    Parameters
    ----------
    terms
        What the expression is the difference of: the scale of the search for a witness.
    """
    zero, why = _zero_by_normal_form(expression)
    if zero:
        return Judgement("proved", "equal normal forms: an identity in all states and all parameters", None)
    found = search(expression, terms, dynamics)
    if found.witness is not None:
        return Judgement("refuted", f"at {found.witness}", found)
    return Judgement("not refuted", f"not refuted in {found.samples} samples, and not proved: {why}", found)


def share_left(expression: ca.SX, terms: ca.SX) -> float | None:
    """The share of `terms` that is left of an expression that is zero but for rounding; None of any other.

    CasADi folds constants in doubles, so that an identity can hold to the last digits of them only. Then
    all coefficients of its normal form, which bound it wherever its symbols are at most 1, are such digits.
    """
    try:
        left, whole = (
            sum(abs(float(c)) for row in normal_forms(ca.densify(x)) for form in row for c in form.terms.values())
            for x in (expression, terms)
        )
    except NotInClass:
        return None
    return left / (whole or 1.0) if left <= LAST_DIGITS * whole else None


def _zero_by_normal_form(expression: ca.SX) -> tuple[bool, str]:
    """Whether all elements have the normal form 0, and if not so, why it is no proof."""
    try:
        forms = [form for row in normal_forms(ca.densify(expression)) for form in row]
    except NotInClass as outside:
        return False, str(outside)
    return all(form.is_zero for form in forms), "the normal forms differ, but no state was found where the values do"

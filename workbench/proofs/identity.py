"""Is an expression zero for all states and parameters? Proved, refuted by a witness, or left open."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

import casadi as ca

from workbench.core import Dynamics
from workbench.notation.normal_form import NotInClass, normal_forms
from workbench.proofs.witness import Search, search
from workbench.validation.refusals import finite
from workbench.validation.signatures import door

Kind = Literal["proved", "refuted", "not refuted"]


@dataclass(frozen=True, eq=False)
class Judgement:
    """How it stands with `expression = 0`, on what evidence, and what the search for a witness found."""

    kind: Kind
    evidence: str
    search: Search | None


@door
def judge_zero(expression: ca.SX, terms: ca.SX, dynamics: Dynamics) -> Judgement:
    """Judge whether every element of `expression` is zero for all q, qd and parameters.

    `proved` rests on exact rational arithmetic alone, `refuted` on a state where the value is not
    zero; numbers that happen to agree prove nothing, and are called `not refuted`.

    Parameters
    ----------
    terms
        What the expression is the difference of: the scale of the search for a witness.

    Raises
    ------
    ValueError
        As `search`.
    """
    zero, why = _zero_by_normal_form(expression)
    if zero:
        return Judgement("proved", "equal normal forms: an identity in all states and all parameters", None)
    found = search(expression, terms, dynamics)
    if found.witness is not None:
        return Judgement("refuted", f"at {found.witness}", found)
    return Judgement("not refuted", f"not refuted in {found.samples} samples, and not proved: {why}", found)


@door
def zero_at(expression: ca.SX, numbers: Mapping[str, float]) -> bool:
    """Whether every element is proved zero where some symbols, by name, are exactly these doubles.

    An identity that holds but for the rounding of numbers in the equations is none, however little is left of it.
    """
    exact = {name: Fraction(finite("zero_at(numbers=...)", number)) for name, number in numbers.items()}
    return _zero_by_normal_form(expression, exact)[0]


def _zero_by_normal_form(expression: ca.SX, numbers: Mapping[str, Fraction] | None = None) -> tuple[bool, str]:
    """Whether all elements have the normal form 0, and if not so, why it is no proof."""
    try:
        forms = [form for row in normal_forms(ca.densify(expression), numbers) for form in row]
    except NotInClass as outside:
        return False, str(outside)
    return all(form.is_zero for form in forms), "the normal forms differ, but no state was found where the values do"

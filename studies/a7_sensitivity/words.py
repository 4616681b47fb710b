"""How a7 writes factors, groups of them, and indices with their intervals."""

from collections.abc import Sequence
from decimal import ROUND_HALF_EVEN, Context

import numpy as np

from studies.a7_sensitivity.factors import MODEL, PARTS
from studies.a7_sensitivity.sweeps import NARROW
from workbench.notation.formula import symbol
from workbench.study.document.phrases import Part, Phrase
from workbench.study.uncertainty import Estimate

GREEK = {"Lambda": "Lambda", "phi": "phi", "gamma": "gamma", "Gamma": "Gamma", "sigma": "sigma"}
LETTERS = {"m1": "m_1", "m2": "m_2", "l1": "l_1", "l2": "l_2", "L1": "L_1", "L2": "L_2", "k1": "k_1", "k2": "k_2"}
GROUPS = ("gains", "arm", "model")


def written(factor: str) -> Phrase:
    """A factor as a page prints it."""
    if factor.startswith(MODEL):
        return ("model ", *_parts(factor.removeprefix(MODEL)))
    return _parts(factor)


def _parts(name: str) -> tuple[Part, ...]:
    start = name.removesuffix("(0)")
    if start in GREEK or start in LETTERS or len(start) == 1:
        letter = symbol(GREEK.get(start, LETTERS.get(start, start)))
        return (letter, "(0)") if name != start else (letter,)
    return (name,)


def group_of(factor: str) -> str:
    """Whether a factor is a gain, part of the arm and its disturbance, or of the model."""
    if factor.startswith(MODEL):
        return "model"
    return "arm" if factor in (*PARTS, "g", "D") else "gains"


def labels(factors: Sequence[str]) -> dict[str, Phrase]:
    """How pictures write factors."""
    return {factor: written(factor) for factor in factors}


def percent(share: float) -> str:
    """A share in whole percents."""
    return f"{100 * share:.0f} %"


def plain(value: float, rounding: str = ROUND_HALF_EVEN) -> str:
    """A number to two digits."""
    return f"{float(Context(2, rounding).create_decimal(value)):,g}"


def with_interval(value: float, half: float, digits: int = 2) -> str:
    """A number with its interval, rounded up."""
    return f"{value:.{digits}f} \N{PLUS-MINUS SIGN} {np.ceil(10**digits * half) / 10**digits:.{digits}f}"


def leaders(factors: Sequence[str], total: Estimate) -> tuple[str, ...]:
    """The factors whose total index the runs do not tell from the largest, that one first."""
    order = np.argsort(-total.value, kind="stable")
    least = total.low[order[0]]
    return tuple(factors[i] for i in order if total.high[i] >= least or i == order[0])


def narrow(*estimates: Estimate) -> bool:
    """Whether every interval is narrow enough for a sentence to rest on it."""
    return all(bool((2 * one.half < NARROW).all()) for one in estimates)

"""Other numbers of some laws, from other searches and half of the budget: how far an answer rests on a search."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

import workbench as wb
from studies.a8_fair_comparison.ablations import RETUNED, RICCATI
from studies.a8_fair_comparison.entrants import BOTH, ENTRANTS, PROPOSED, Entrant

CONTENDERS = 3  # laws of least training cost, and AOSMC-RGS
NUMBERS = {3: "three", 4: "four"}  # how many laws contend, in words
PLAIN = "ASMC"  # adaptive sliding mode without a Riccati equation
RIVALS = {PLAIN: next(one for one in ENTRANTS[BOTH.key] if one.name == PLAIN), RICCATI: RETUNED[RICCATI]}


def ranked_searches(tuned: wb.tuning.Tuned) -> list[int]:
    """The seeds of the searches: first that of the best numbers of all, then by their least objectives."""
    own = int(np.searchsorted(np.cumsum(tuned.used), tuned.place, side="right"))
    return [one.seed for one in sorted(tuned.searches, key=lambda one: (one.search != own, float(one.bests[-1])))]


def second_search(tuned: wb.tuning.Tuned) -> dict[str, float]:
    """The best numbers of the second best search."""
    return tuned.best_of(ranked_searches(tuned)[1])


def third_search(tuned: wb.tuning.Tuned) -> dict[str, float]:
    """The best numbers of the third best search."""
    return tuned.best_of(ranked_searches(tuned)[2])


def half_budget(tuned: wb.tuning.Tuned) -> dict[str, float]:
    """The best of the first evaluations of each search, half as many as the shortest of them used."""
    return tuned.best_within(min(tuned.used) // 2)


AGAIN: Mapping[
    str, tuple[str, Callable[[wb.tuning.Tuned], dict[str, float]]]
] = {  # a kind of sweeps to its words and numbers
    "_other": ("the second best search", second_search),
    "_third": ("the third best search", third_search),
    "_half": ("half of the budget", half_budget),
}


def run_name(law: str, kind: str = "") -> str:
    """The name of a law with other numbers, of a kind of `AGAIN`; as tuned without one."""
    return f"{law}, {AGAIN[kind][0]}" if kind else law


def contenders(entrants: Sequence[Entrant], tuned: Mapping[str, wb.tuning.Tuned]) -> tuple[Entrant, ...]:
    """The laws of least training cost of those that are given the same, and AOSMC-RGS."""
    least = sorted(entrants, key=lambda one: tuned[one.key].objective)[:CONTENDERS]
    return tuple(one for one in entrants if one in least or one.name == PROPOSED)


def run_again(tuned: Mapping[str, wb.tuning.Tuned]) -> tuple[Entrant, ...]:
    """The laws that run with other numbers: the contenders with each kind of measurements, and the rivals of (34)."""
    some = (one for entrants in ENTRANTS.values() for one in contenders(entrants, tuned))
    return tuple({one.key: one for one in (*some, *RIVALS.values())}.values())

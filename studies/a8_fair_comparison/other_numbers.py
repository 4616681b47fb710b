"""Other numbers of some laws, from other searches and half of the budget: how far an answer rests on a search."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

import workbench as wb
from studies.a8_fair_comparison.ablations import RETUNED_ENTRANTS, RICCATI
from studies.paper.entrants import BOTH, ENTRANTS, PROPOSED_LAW, Entrant

CONTENDERS = 3  # laws of least training cost, and AOSMC-RGS
NUMBERS = {3: "three", 4: "four"}  # how many laws contend, in words
PLAIN = "ASMC"  # adaptive sliding mode without a Riccati equation
RIVALS = {PLAIN: next(one for one in ENTRANTS[BOTH.key] if one.name == PLAIN), RICCATI: RETUNED_ENTRANTS[RICCATI]}


def ranked_searches(tuning_result: wb.tuning.TuningResult) -> list[int]:
    """The seeds of the searches: first that of the best numbers of all, then by their least objectives."""
    own = int(np.searchsorted(np.cumsum(tuning_result.evaluations), tuning_result.place, side="right"))
    return [
        one.seed for one in sorted(tuning_result.searches, key=lambda one: (one.search != own, float(one.bests[-1])))
    ]


def second_search(tuning_result: wb.tuning.TuningResult) -> dict[str, float]:
    """The best numbers of the second best search."""
    return tuning_result.best_of(ranked_searches(tuning_result)[1])


def third_search(tuning_result: wb.tuning.TuningResult) -> dict[str, float]:
    """The best numbers of the third best search."""
    return tuning_result.best_of(ranked_searches(tuning_result)[2])


def half_budget(tuning_result: wb.tuning.TuningResult) -> dict[str, float]:
    """The best of the first evaluations of each search, half as many as the shortest of them used."""
    return tuning_result.best_within(min(tuning_result.evaluations) // 2)


AGAIN: Mapping[
    str, tuple[str, Callable[[wb.tuning.TuningResult], dict[str, float]]]
] = {  # a kind of sweeps to its words and numbers
    "_other": ("the second best search", second_search),
    "_third": ("the third best search", third_search),
    "_half": ("half of the budget", half_budget),
}


def run_name(law: str, kind: str = "") -> str:
    """The name of a law with other numbers, of a kind of `AGAIN`; as tuned without one."""
    return f"{law}, {AGAIN[kind][0]}" if kind else law


def contenders(
    entrants: Sequence[Entrant], tuning_results: Mapping[str, wb.tuning.TuningResult]
) -> tuple[Entrant, ...]:
    """The laws of least training cost of those that are given the same, and AOSMC-RGS."""
    least = sorted(entrants, key=lambda one: tuning_results[one.key].objective)[:CONTENDERS]
    return tuple(one for one in entrants if one in least or one.name == PROPOSED_LAW)


def run_again(tuning_results: Mapping[str, wb.tuning.TuningResult]) -> tuple[Entrant, ...]:
    """The laws that run with other numbers: the contenders with each kind of measurements, and the rivals of (34)."""
    some = (one for entrants in ENTRANTS.values() for one in contenders(entrants, tuning_results))
    return tuple({one.key: one for one in (*some, *RIVALS.values())}.values())

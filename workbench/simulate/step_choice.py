"""The choice of a step for a tolerance: the one place where `simulate`, `measure` and sweeps ask for it."""

from __future__ import annotations

from math import ceil
from typing import Any

from workbench.core import Ode, Sampled, Step, rk4
from workbench.core.switches import DENSEST
from workbench.simulate.step_size import HALVINGS, Make, step_for_tolerance
from workbench.validation.refusals import Array

COUNT = 100  # of the longest steps that are tried, in a horizon, or about that many
SUBSTEPS = 7  # halvings of a sampling period at most: all substeps of a period are written out


def step_of(equation: Ode | Sampled, h: float) -> Step:
    """The step of length h [s] of an equation; of a sampled loop its period in substeps of that length."""
    return equation.step(equation.substeps(h)) if isinstance(equation, Sampled) else rk4(equation, h)


def longest_step(equation: Ode | Sampled, p: Array, until: float, unit: float) -> float:
    """The longest step that is tried, in s: the period of a sampled loop, else a part of `unit` and of the horizon.

    It has no more switches of one kind than `simulate` allows for the rows p (B, np).
    """
    if isinstance(equation, Sampled):
        return equation.period
    longest = unit / ceil(COUNT * unit / until)
    while equation.switches.densest(p) * DENSEST < longest:
        longest /= 2
    return longest


def choose_step(
    equation: Ode | Sampled,
    make: Make,
    p: Array,
    x0: Array,
    until: float,
    unit: float,
    tolerance: float,
    seed: int = 0,
    arithmetic: str | None = None,
    keep_lost: bool = False,
) -> float:
    """The longest step h in s at which the pilot runs p, x0 change by no more than the tolerance to h / 2.

    `make` makes the steps of an equation, with metrics beside it if need be. Of a sampled loop h is the period, its
    half, its quarter and so on; else a whole number of steps makes `unit`, in s.
    """
    halvings = SUBSTEPS if isinstance(equation, Sampled) else HALVINGS
    longest = longest_step(equation, p, until, unit)
    how: Any = {"halvings": halvings, "seed": seed, "arithmetic": arithmetic, "keep_lost": keep_lost}
    return step_for_tolerance(make, p, x0, until, tolerance, longest, **how)

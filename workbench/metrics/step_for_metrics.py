"""The choice of a step for metrics: pilot runs of an equation with its metrics beside it."""

from __future__ import annotations

from functools import cache

import numpy as np

from workbench.core import Ode
from workbench.metrics.measured_equation import MeasuredEquation
from workbench.simulate.step_choice import choose_step, longest_step
from workbench.validation.refusals import Array


def chosen_step(
    measured: MeasuredEquation,
    p: Array,
    x0: Array,
    until: float,
    every: float | None,
    tolerance: float,
    seed: int = 0,
    arithmetic: str | None = None,
) -> float:
    """The longest step h in s at which the error of the pilot runs p, x0 keeps the tolerance.

    Of a sampled loop it is the period, its half, its quarter and so on; p and x0 are of the equation alone.
    """
    make, equation, unit = cache(measured.step), measured.equation, until
    if isinstance(equation, Ode):
        unit = measured.grid(until, *([] if every is None else [every])) or every or until
    step = make(longest_step(equation, p, until, unit))
    start = np.hstack([x0, np.tile(step.states.default[x0.shape[1] :], (len(x0), 1))])
    # the error is twice the change from h to h / 2
    return choose_step(equation, make, p, start, until, unit, tolerance / 2, seed, arithmetic)

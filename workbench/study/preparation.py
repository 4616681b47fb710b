"""From a sweep to its equation and its steps; where it names no step, pilot runs choose one for all."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from workbench.core import Ode, Sampled, Step
from workbench.metrics.accumulated import maker, resolved
from workbench.metrics.measure import chosen_step
from workbench.simulate.arithmetic import default_for
from workbench.study.contract import equations_of
from workbench.study.prepared import Prepared
from workbench.study.run import Run
from workbench.study.sweep import Sweep
from workbench.study.uncertainty.designs import AbstractDesign
from workbench.study.uncertainty.factors import Space
from workbench.validation.words import Array, multiple


def prepared(
    sweep: Sweep, arithmetic: str | None = None, pilots: Array | None = None, *, searches: bool = False
) -> Prepared:
    """The sweep with its equation, in an arithmetic by its name, or else in the one that serves best here.

    Parameters
    ----------
    pilots
        Points (R, d) of the unit cube whose runs choose the step where the sweep names none; those of its own with the
        least and the largest value of each factor if not given.
    searches
        Whether the runs are at twice the step, as those of a search.

    Raises
    ------
    LookupError
        If a factor varies what the loop does not have, or a metric watches what it does not put out.
    ValueError
        If two factors move one number, one leads out of its bounds, or a metric means nothing for the loop.
    """
    run = sweep.run
    equation: Ode | Sampled = equations_of(run.loop, sweep.name)
    metrics = resolved(equation, run.metrics, run.until)
    make: Callable[[str, float], Step] = maker(equation, metrics)
    space = Space(sweep.factors, equation.parameters, equation.states)
    if run.h is None:
        rows = space.rows(_extremes(sweep.design) if pilots is None else pilots)
        run = replace(run, h=_step(run, equation, *rows))
    h = run.doubled(equation, f"Trial(run=...) of {sweep.name!r}") if searches else run.h
    assert h is not None
    coarse = make("rk4", h)
    multiple(f"Sweep({sweep.name!r}, run=Run(every=...))", run.kept, coarse.h, "the step")
    chosen, rounding = sweep.run.h is None, arithmetic or default_for(coarse)
    sweep, fine = replace(sweep, run=replace(run, h=h)), make("rk4", h / 2)
    return Prepared(sweep, equation, metrics, coarse, fine, space, rounding, chosen=chosen)


def _extremes(design: AbstractDesign) -> Array:
    """The points of a design with the least and the largest coordinate along each axis."""
    points = design.points()
    return np.asarray(points[np.unique([points.argmin(axis=0), points.argmax(axis=0)])])


def _step(run: Run, equation: Ode | Sampled, p: Array, x0: Array) -> float:
    """The step in s at which pilots from the rows p (R, np) and x0 (R, nx) keep the tolerance of a run."""
    assert run.tolerance is not None
    return chosen_step(equation, run.metrics, p, x0, run.until, run.kept, run.tolerance, run.seed) / 2

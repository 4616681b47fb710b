"""Small results with known answers, and one picture of each kind, for tests."""

import numpy as np

from workbench.report.pictures import (
    budget_curves,
    indices_over_time,
    morris_plane,
    pareto_fronts,
    quantile_bands,
    rank_figure,
    sobol_bars,
    tornado_figure,
)
from workbench.report.table_text import plain
from workbench.study.document.document import Points, Series
from workbench.study.uncertainty import (
    MonteCarlo,
    MorrisDesign,
    OneAtATime,
    SobolDesign,
    morris,
    quantiles,
    sobol,
    tornado,
)

NOTE = "320 runs, 0 of them diverged; seed 0; step 0.001 s; step error of y at most 2.1×10⁻⁵ rad"
ABC = ("a", "b", "c")


def tornado_of(of, factors=ABC, levels=(0.05, 0.95)):
    design = OneAtATime(len(factors), levels)
    return tornado(design, of(design.points()), ("y",), factors=factors)


def morris_effects(of, factors=ABC, trajectories=10):
    design = MorrisDesign(len(factors), trajectories)
    return morris(design, of(design.points()), ("y",), factors=factors)


def indices(of, factors=ABC, names=("y",), second_order=False, base=64):
    design = SobolDesign(len(factors), base, second_order=second_order)
    return sobol(design, of(design.points()), names, factors=factors)


def made(note):
    """A way to make each kind of picture, with this note."""
    t, random = np.array([1.0, 2.0]), MonteCarlo(1, 100)
    together = indices(lambda u: u[:, 0] + 3 * u[:, 1] * u[:, 2], second_order=True)
    course = indices(lambda u: np.column_stack([u[:, 0], u[:, 1]]), names=("one", "two"))
    bands = {"PID": quantiles(random, random.points() * t)}
    return {
        "tornado": lambda: tornado_figure("f", "", tornado_of(lambda u: u[:, 0]), note),
        "morris": lambda: morris_plane("f", "", morris_effects(lambda u: u @ [1, 2, 3]), note),
        "sobol": lambda: sobol_bars("f", "", together, note),
        "indices over time": lambda: indices_over_time("f", "", t, course, note),
        "quantiles": lambda: quantile_bands("f", "", t, bands, note, "e [rad]"),
        "fronts": lambda: pareto_fronts("f", "", {"PID": [[1, 2], [2, 1]]}, note, "x", "y"),
        "budgets": lambda: budget_curves("f", "", {"PID": (t, t[::-1])}, note, "objective"),
        "ranks": lambda: rank_figure("f", "", {"PID": [1.0, 0.0], "SMC": [0.0, 1.0]}, note),
    }


def words(caption):
    """A caption as plain text."""
    return plain(caption)


def points_of(figure):
    """The points of its first panel."""
    return next(mark for mark in figure.panels[0].series if isinstance(mark, Points))


def line(panel, label):
    """The ordinates of a curve by its label."""
    return next(mark.y for mark in panel.series if isinstance(mark, Series) and mark.label == label)


def bar_ends(panel):
    """The ends of all bars, one row a series."""
    return [np.asarray(mark.ends) for mark in panel.series]

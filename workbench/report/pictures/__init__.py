"""Pictures of the results of many runs: indices, effects, quantiles, standings, fronts.

This package turns results into figures as data, each with a caption that ends with its note (runs, failed runs, seed,
step error); it does not draw them. Read `captions` first.

Examples
--------
>>> wb.pictures.Window(0.0, 2.0).end
2.0
"""

from workbench.report.pictures.law_pictures import budget_curves, pareto_fronts, quantile_bands
from workbench.report.pictures.screening_pictures import morris_plane, tornado_figure
from workbench.report.pictures.sobol_pictures import indices_over_time, sobol_bars
from workbench.report.pictures.standings_pictures import rank_figure, standings_figure
from workbench.report.pictures.traces import Window, components, curve, loops_section, traces

__all__ = [
    "Window",
    "budget_curves",
    "components",
    "curve",
    "indices_over_time",
    "loops_section",
    "morris_plane",
    "pareto_fronts",
    "quantile_bands",
    "rank_figure",
    "sobol_bars",
    "standings_figure",
    "tornado_figure",
    "traces",
]

"""What many runs say as figures; each caption ends with its note: runs, failed runs, seed, step error."""

from workbench.study.pictures.bands import quantile_bands
from workbench.study.pictures.budgets import budget_curves
from workbench.study.pictures.fronts import pareto_fronts
from workbench.study.pictures.morris import morris_plane
from workbench.study.pictures.over_time import indices_over_time
from workbench.study.pictures.rank import rank_figure
from workbench.study.pictures.second_order import second_order_map
from workbench.study.pictures.sobol import sobol_bars
from workbench.study.pictures.standings import standings_figure
from workbench.study.pictures.tornado import tornado_figure

__all__ = [
    "budget_curves",
    "indices_over_time",
    "morris_plane",
    "pareto_fronts",
    "quantile_bands",
    "rank_figure",
    "second_order_map",
    "sobol_bars",
    "standings_figure",
    "tornado_figure",
]

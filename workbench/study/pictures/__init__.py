"""What many runs say as figures; each caption ends with its note: runs, failed runs, seed, step error."""

from workbench.study.pictures.morris import morris_plane
from workbench.study.pictures.sobol import sobol_bars
from workbench.study.pictures.tornado import tornado_figure

__all__ = ["morris_plane", "sobol_bars", "tornado_figure"]

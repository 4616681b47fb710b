"""What a study is written with, by one import; each name is loaded from its file when it is first asked for."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from workbench.study.comparison import side_by_side
    from workbench.study.document.document import Figure, Itemize, Paragraph, Section, Table, Verdict
    from workbench.study.pictures import morris_plane, quantile_bands, second_order_map, sobol_bars, tornado_figure
    from workbench.study.run import Run
    from workbench.study.study import Case, Results, Study
    from workbench.study.sweep import Sweep
    from workbench.study.tuning import Trial, Tuning
    from workbench.study.uncertainty.designs import LatinHypercube, MonteCarlo, MorrisDesign, OneAtATime
    from workbench.study.uncertainty.distributions import LogNormal, LogUniform, Normal, Triangular, Uniform
    from workbench.study.uncertainty.effects import morris, tornado
    from workbench.study.uncertainty.factors import Factor
    from workbench.study.uncertainty.indices import sobol
    from workbench.study.uncertainty.quantiles import quantiles
    from workbench.study.uncertainty.sobol_design import SobolDesign

_FILES = {
    "comparison": ("side_by_side",),
    "uncertainty.distributions": ("LogNormal", "LogUniform", "Normal", "Triangular", "Uniform"),
    "document.document": ("Figure", "Itemize", "Paragraph", "Section", "Table", "Verdict"),
    "uncertainty.factors": ("Factor",),
    "pictures": ("morris_plane", "quantile_bands", "second_order_map", "sobol_bars", "tornado_figure"),
    "run": ("Run",),
    "uncertainty": (
        "LatinHypercube",
        "MonteCarlo",
        "MorrisDesign",
        "OneAtATime",
        "SobolDesign",
        "morris",
        "quantiles",
        "sobol",
        "tornado",
    ),
    "study": ("Case", "Results", "Study"),
    "sweep": ("Sweep",),
    "tuning": ("Trial", "Tuning"),
}
_HOMES = {name: file for file, names in _FILES.items() for name in names}

__all__ = [
    "Case",
    "Factor",
    "Figure",
    "Itemize",
    "LatinHypercube",
    "LogNormal",
    "LogUniform",
    "MonteCarlo",
    "MorrisDesign",
    "Normal",
    "OneAtATime",
    "Paragraph",
    "Results",
    "Run",
    "Section",
    "SobolDesign",
    "Study",
    "Sweep",
    "Table",
    "Trial",
    "Triangular",
    "Tuning",
    "Uniform",
    "Verdict",
    "morris",
    "morris_plane",
    "quantile_bands",
    "quantiles",
    "second_order_map",
    "side_by_side",
    "sobol",
    "sobol_bars",
    "tornado",
    "tornado_figure",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)

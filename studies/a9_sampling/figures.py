"""The figures of a9: error and chattering over the period, and chattering over the step of the simulation."""

from collections.abc import Sequence

import numpy as np

from studies.a1_paper_tables.study import STYLES
from studies.a9_sampling.card import PERIODS
from studies.a9_sampling.evidence import PLACES, ROWS, Evidence
from studies.a9_sampling.loops import RMSE, TV
from studies.a9_sampling.steps import LAWS, Curve
from studies.paper.comparison import SCENARIOS as TITLES
from workbench.study.document.document import Figure, Panel, Series

PERIOD = "sampling period [ms]"
NOTE = "A line ends where the run diverges; the step errors are in the last section."


def errors(evidence: Evidence) -> Figure:
    """RMSE (43) over the period."""
    return _over_periods(evidence, RMSE, "rmse_periods", "RMSE (43) [rad]", "RMSE (43) over the sampling period.")


def variations(evidence: Evidence) -> Figure:
    """Total variation over the period."""
    caption = (
        "Total variation of the held torque over the sampling period, with exact readings and without delay. Marks at "
        "the left edge: in continuous time."
    )
    return _over_periods(evidence, TV, "tv_periods", "TV [N m/s]", caption)


def _over_periods(evidence: Evidence, metric: str, name: str, ylabel: str, caption: str) -> Figure:
    panels = []
    x = 1e3 * np.array(PERIODS)
    for scenario, joint in PLACES:
        series = []
        for law, way, label in ROWS:
            y = np.array([evidence.at(metric, T, stepping=way)(law, scenario, joint)[0] for T in PERIODS])
            y[np.isinf(y)] = np.nan
            style = STYLES[law] if way == "euler" else len(STYLES)
            series.append(Series(label, x, y, style))
            still = evidence.still(metric)(law, scenario, joint)[0]
            series.append(Series(label, [x[0]], [still], style, look="marks"))
        title = f"{TITLES[scenario]}, joint {joint + 1}"
        panels.append(Panel(ylabel, tuple(series), PERIOD, xscale="log", yscale="log", title=title))
    return Figure(name, f"{caption} {NOTE}", tuple(panels), columns=2)


def steps(curves: Sequence[Curve]) -> Figure:
    """Total variation over the step of the simulation."""
    panels = []
    for law in LAWS:
        mine = [curve for curve in curves if curve.law == law]
        lines = [Series(c.label, 1e3 * c.h, c.TV[:, 0], style) for style, c in enumerate(mine)]
        marks = [Series(c.label, 1e3 * c.h, c.TV[:, 0], style, look="marks") for style, c in enumerate(mine)]
        panels.append(
            Panel("TV of joint 1 [N m/s]", (*lines, *marks), "step [ms]", xscale="log", yscale="log", title=law)
        )
    caption = (
        "Total variation of the first torque over the step of Runge-Kutta, first scenario, 10 s: in continuous time a "
        "step of the loop, with the computer a step of the plant within its period."
    )
    return Figure("tv_steps", caption, tuple(panels), columns=2)

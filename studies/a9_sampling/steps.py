"""Chattering over the step of the simulation: what belongs to the computer stays, what belongs to the step moves."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from studies.a9_sampling.loops import TV, last
from studies.paper.linearization import PROPOSED, loop_of
from workbench.metrics import measured, total_variation
from workbench.study.document.document import Figure, Panel, Series
from workbench.validation.refusals import Array

LAWS = ("SMC", PROPOSED)
UNTIL, PERIOD = 10.0, 1e-3  # s, of the first scenario
STEPS = (5e-5, 1e-4, 2e-4, 5e-4, 1e-3, 2e-3)  # s, of RK4 through the loop in continuous time
SUBSTEPS = (1, 2, 5)  # of the plant within a period of the computer
WORDS = {"clip": "layer", "sign": "relay"}


@dataclass(frozen=True, eq=False)
class Curve:
    """TV (N, 2) in N m/s over steps h (N,) in s, of one law, one switching, with or without a computer of 1 ms."""

    law: str
    switching: str
    digital: bool
    h: Array
    TV: Array


def curves() -> tuple[Curve, ...]:
    """Both laws, with layer and relay, in continuous time and run by a computer."""
    return tuple(curve(law, switching, digital) for law in LAWS for switching in WORDS for digital in (False, True))


def curve(law: str, switching: str, digital: bool) -> Curve:
    """One of them; the torque is looked at once a step, or once a period of the computer, which holds it."""
    loop = loop_of(law, "FS")
    loop = replace(loop, controller=replace(loop.controller, saturation=switching))
    equation = loop.digital(PERIOD) if digital else loop.ode()
    h = [PERIOD / m for m in SUBSTEPS] if digital else list(STEPS)
    grids = [(total_variation(PERIOD if digital else length),) for length in h]
    runs = [last(measured(equation, grid, length), grid, UNTIL) for grid, length in zip(grids, h, strict=True)]
    return Curve(law, switching, digital, np.array(h), np.array([values[TV][0] for values in runs]))


def figure(curves: Sequence[Curve]) -> Figure:
    """Total variation over the step of the simulation."""
    panels = []
    for law in LAWS:
        series = []
        for style, one in enumerate(curve for curve in curves if curve.law == law):
            label = f"{WORDS[one.switching]}, {'computer of 1 ms' if one.digital else 'continuous time'}"
            points = label, 1e3 * one.h, one.TV[:, 0], style
            series += [Series(*points), Series(*points, look="marks")]
        axes = "TV of joint 1 [N m/s]", tuple(series), "step [ms]"
        panels.append(Panel(*axes, xscale="log", yscale="log", title=law))
    caption = (
        "Total variation of the first torque over the step of Runge-Kutta, first scenario, 10 s: in continuous time a "
        "step of the loop, with the computer a step of the plant within its period."
    )
    return Figure("tv_steps", caption, tuple(panels), columns=2)

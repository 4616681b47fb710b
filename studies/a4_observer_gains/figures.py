"""The figures of a4: poles in the plane, rates along the path, noise against rate, errors over time."""

import numpy as np

from studies.a4_observer_gains.candidates import CHOSEN, HOW, PAPER, SURFACE, audits, followed, path, trade_off
from workbench.notation.formula import symbol
from workbench.study.document.document import Figure, Panel, Series
from workbench.study.pictures.traces import Window, curve
from workbench.study.study import Outcome, Results

STYLES = {name: i for i, name in enumerate(HOW)}
SHOWN = 300  # states of the cloud of poles


def poles() -> Figure:
    """The frozen poles of the paper's gains and of the chosen ones, at states of the region."""
    panels = []
    for name in (PAPER, CHOSEN):
        cloud = audits()[name].frozen.poles[:SHOWN].ravel()
        marks = Series(name, cloud.real, cloud.imag, STYLES[name], look="marks")
        panels.append(Panel("imaginary part [1/s]", (marks,), xlabel="real part [1/s]", vlines=(0.0,), title=name))
    caption = (
        f"Poles of the error with state and torque frozen, at {SHOWN} states of the region. Right of the line at zero "
        "a mode grows."
    )
    return Figure("poles", caption, tuple(panels), columns=2)


def along_the_path() -> Figure:
    """How fast the slowest mode decays along the desired motion."""
    t = path()[0]
    series = [Series(name, t, found.rates, STYLES[name]) for name, found in followed().items()]
    series.append(Series("surface", t, np.full(len(t), SURFACE), "bound"))
    caption = (
        "Rate of the slowest frozen mode along the desired motion of the first scenario; at and below zero a mode does "
        "not decay."
    )
    return Figure("along_the_path", caption, (Panel("slowest frozen mode [1/s]", tuple(series)),))


def noise_and_rate() -> Figure:
    """Noise against the slowest mode."""
    slowest, noisy = trade_off()
    line = Series("double poles", slowest, noisy, "reference")
    marks = [
        Series(name, [found.frozen.slowest], [found.noise.velocity], STYLES[name], look="marks")
        for name, found in audits().items()
    ]
    caption = (
        "Noise in the velocity estimate, as an H2 norm, against the slowest frozen mode seen in the region. The line "
        "are double poles at -22 to -60 1/s; left of zero a mode grows somewhere."
    )
    panel = Panel(
        "noise gain [s^(-3/2)]", (*marks, line), xlabel="slowest frozen mode [1/s]", yscale="log", vlines=(0.0, SURFACE)
    )
    return Figure("noise_and_rate", caption, (panel,))


def errors(results: Results, scenario: str) -> Figure:
    """The estimation errors of joint 2 over time, position and velocity, early and late."""
    outcomes = results.scenario(scenario)
    early, late = Window(0.0, 1.0), Window(5.0, 10.0)
    panels = tuple(
        Panel(
            ylabel,
            tuple(_shown(o, signal, window) for o in outcomes),
            xlim=(window.start, window.end),
        )
        for signal, ylabel in (
            ("q_error", ("error of ", symbol("q_2"), " [rad]")),
            ("qd_error", ("error of ", symbol("qd_2"), " [rad/s]")),
        )
        for window in (early, late)
    )
    caption = f"Estimation errors of joint 2, {scenario}: the first second, and once the start is forgotten."
    return Figure("estimation_errors", caption, panels, columns=2)


def _shown(outcome: Outcome, signal: str, window: Window) -> Series:
    return curve(outcome, signal, 1, window, outcome.case.law, outcome.case.style)

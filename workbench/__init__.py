"""control-workbench: from the equations of a control system to verdicts, numbers and a running controller.

`import workbench as wb` loads nothing by itself; each of the names of `wb` comes from its room when it is first asked
for. `dir(wb)` lists them, and `help(wb.X)` tells of one, with its shapes, units and an example.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import Any

__version__ = "0.1.0"

_ROOMS = {
    "core": "Layout Ode Sampled SampledLaw Signals block initial layout option parameter rk4 runge_kutta_step",
    "loop": "ClosedLoop Controller DigitalLoop GaussMarkov Instruments Observer Plant RandomWalk Reference "
    "SecondOrderNoise open_loop",
    "robots": "base_parameters named paper_arm regressor",
    "robots.urdf": "read_urdf",
    "plants": "Backlash BuckConverter CartPole DCMotor DeadZone Disturbed Equipped FirstOrder FurutaPendulum "
    "LinearPlant Manipulator OdePlant PadeDelay PlanarQuadrotor Quadrotor QuadrupleTank Quantiser RateLimit Saturation "
    "SingleTrackVehicle StirredTank TwoMasses",
    "controllers": "Cascade LinearLaw PID PID2 Regulator SlidingMode StateFeedback",
    "observers": "ExtendedKalmanFilter ExtendedStateObserver FullState LinearObserver SteadyKalmanFilter "
    "UnscentedKalmanFilter",
    "signals": "Chirp Hold PulseTrain Ramp Sines Step Table Together Trapezoid WayPoints",
    "simulate": "simulate",
    "metrics": "effort measure overshoot peak_error rmse settling_time total_variation",
    "design": "linearize",
    "design.frequency": "bandwidth c2d condition_number h2_norm hinf_norm pole_zero_structure relative_gains "
    "stability_margins",
    "design.linear": "equilibria lead_lag place",
    "design.linear_loop": "linear_loop",
    "design.step_response": "step_info",
    "design.riccati": "lqg lqr steady_kalman",
    "study": "Case Factor Finding Knob LogUniform Page Paragraph Run Section SobolDesign Study Sweep Uniform Variation "
    "Work side_by_side sobol sobol_bars",
    "study.evidence": "LoopLimits largest_setting",
    "study.live.turned": "turned turned_linear",
    "study.pictures.loop_gain_pictures": "loop_gain_pictures",
    "cli.script": "load",
    "handover.c99.c_code": "c_code",
    "handover.fmi.archive": "fmu",
    "handover.law_export": "export",
    "handover.recording": "record",
    "handover.replays": "replay",
    "report.loop_page": "live",
    "report.object_plots": "plot",
    "report.loop_plots": "bode nichols nyquist pole_zero_map root_locus singular_values step_response",
    "study.loop_pictures": "FrequencyCurve GainBound",
    "study.specifications": "Specification",
}
_HOMES = {name: room for room, names in _ROOMS.items() for name in names.split()}
_THERE = {  # the names that a room calls otherwise
    "Controller": "AbstractController",
    "Observer": "AbstractObserver",
    "Plant": "AbstractPlant",
    "Reference": "AbstractReference",
    "read_urdf": "read",
}
__all__ = [*_HOMES]


def __getattr__(name: str) -> Any:
    """A name of the face, loaded from its room when it is first asked for."""
    if name not in _HOMES:
        from difflib import get_close_matches  # the nearest of `validation` would load NumPy

        near = "".join(f" Did you mean '{other}'?" for other in get_close_matches(name, _HOMES, 1))
        raise AttributeError(f"module 'workbench' has no attribute '{name}'.{near}")
    held = getattr(import_module(f"workbench.{_HOMES[name]}"), _THERE.get(name, name))
    globals()[name] = held
    return held


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOMES})


class _Face(ModuleType):
    """The class of the package: it keeps `wb.simulate` the function when the room `workbench.engine` is imported."""

    def __setattr__(self, name: str, value: object) -> None:
        if not (name in _HOMES and isinstance(value, ModuleType)):
            ModuleType.__setattr__(self, name, value)


sys.modules[__name__].__class__ = _Face

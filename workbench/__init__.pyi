"""The face for editors and mypy: each name of `wb`, and the room that it comes from."""

from workbench.arms.laws import PID, SlidingMode, StateFeedback
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import base_parameters, named, paper_arm, regressor
from workbench.arms.mechanics.urdf import read as read_urdf
from workbench.arms.observers import ExtendedStateObserver, FullState
from workbench.blocks.laws import PID2, Cascade, LinearLaw, Regulator
from workbench.blocks.loop import AbstractController as Controller
from workbench.blocks.loop import AbstractObserver as Observer
from workbench.blocks.loop import AbstractPlant as Plant
from workbench.blocks.loop import AbstractReference as Reference
from workbench.blocks.loop import (
    ClosedLoop,
    DigitalLoop,
    GaussMarkov,
    Instruments,
    RandomWalk,
    SecondOrderNoise,
    open_loop,
)
from workbench.blocks.observers import ExtendedKalmanFilter, LinearObserver, SteadyKalmanFilter, UnscentedKalmanFilter
from workbench.blocks.plants import (
    Backlash,
    BuckConverter,
    CartPole,
    DCMotor,
    DeadZone,
    Disturbed,
    Equipped,
    FirstOrder,
    FurutaPendulum,
    LinearPlant,
    OdePlant,
    PadeDelay,
    PlanarQuadrotor,
    Quadrotor,
    QuadrupleTank,
    Quantiser,
    RateLimit,
    Saturation,
    SingleTrackVehicle,
    StirredTank,
    TwoMasses,
)
from workbench.blocks.signals import Chirp, Hold, PulseTrain, Ramp, Sines, Step, Table, Together, Trapezoid, WayPoints
from workbench.cli.script import load
from workbench.core import (
    Layout,
    Ode,
    Sampled,
    SampledLaw,
    Signals,
    block,
    initial,
    layout,
    option,
    parameter,
    rk4,
    runge_kutta_step,
)
from workbench.design import linearize
from workbench.design.frequency import (
    bandwidth,
    c2d,
    condition_number,
    h2_norm,
    hinf_norm,
    pole_zero_structure,
    relative_gains,
    stability_margins,
)
from workbench.design.linear import equilibria, lead_lag, place
from workbench.design.linear_loop import linear_loop
from workbench.design.riccati import lqg, lqr, steady_kalman
from workbench.design.step_response import step_info
from workbench.engine import simulate
from workbench.engine.distributions import LogUniform, Uniform
from workbench.engine.factors import Factor
from workbench.engine.metrics import effort, measure, overshoot, peak_error, rmse, settling_time, total_variation
from workbench.handover.c99.c_code import c_code
from workbench.handover.fmi.archive import fmu
from workbench.handover.law_export import export
from workbench.handover.recording import record
from workbench.handover.replays import replay
from workbench.report.live.turned import turned, turned_linear
from workbench.report.loop_page import live
from workbench.report.loop_plots import (
    bode,
    nichols,
    nyquist,
    pole_zero_map,
    root_locus,
    singular_values,
    step_response,
)
from workbench.report.object_plots import plot
from workbench.report.pictures import sobol_bars
from workbench.report.pictures.loop_gain_pictures import loop_gain_pictures
from workbench.study.contract import Run, Sweep
from workbench.study.document.document import Page, Paragraph, Section
from workbench.study.document.finding import Finding, Variation
from workbench.study.document.frequency_curves import FrequencyCurve
from workbench.study.document.gain_bounds import GainBound
from workbench.study.evidence import LoopLimits, largest_setting
from workbench.study.evidence.law_tables import side_by_side
from workbench.study.knob import Knob
from workbench.study.specifications import Specification
from workbench.study.study import Case, Study
from workbench.study.uncertainty import SobolDesign, sobol
from workbench.study.work import Work

__version__: str
__all__ = [
    "Backlash",
    "BuckConverter",
    "CartPole",
    "Cascade",
    "Case",
    "Chirp",
    "ClosedLoop",
    "Controller",
    "DCMotor",
    "DeadZone",
    "DigitalLoop",
    "Disturbed",
    "Equipped",
    "ExtendedKalmanFilter",
    "ExtendedStateObserver",
    "Factor",
    "Finding",
    "FirstOrder",
    "FrequencyCurve",
    "FullState",
    "FurutaPendulum",
    "GainBound",
    "GaussMarkov",
    "Hold",
    "Instruments",
    "Knob",
    "Layout",
    "LinearLaw",
    "LinearObserver",
    "LinearPlant",
    "LogUniform",
    "LoopLimits",
    "Manipulator",
    "Observer",
    "Ode",
    "OdePlant",
    "PID",
    "PID2",
    "PadeDelay",
    "Page",
    "Paragraph",
    "PlanarQuadrotor",
    "Plant",
    "PulseTrain",
    "Quadrotor",
    "QuadrupleTank",
    "Quantiser",
    "Ramp",
    "RandomWalk",
    "RateLimit",
    "Reference",
    "Regulator",
    "Run",
    "Sampled",
    "SampledLaw",
    "Saturation",
    "SecondOrderNoise",
    "Section",
    "Signals",
    "Sines",
    "SingleTrackVehicle",
    "SlidingMode",
    "SobolDesign",
    "Specification",
    "StateFeedback",
    "SteadyKalmanFilter",
    "Step",
    "StirredTank",
    "Study",
    "Sweep",
    "Table",
    "Together",
    "Trapezoid",
    "TwoMasses",
    "Uniform",
    "UnscentedKalmanFilter",
    "Variation",
    "WayPoints",
    "Work",
    "bandwidth",
    "base_parameters",
    "block",
    "bode",
    "c2d",
    "c_code",
    "condition_number",
    "effort",
    "equilibria",
    "export",
    "fmu",
    "h2_norm",
    "hinf_norm",
    "initial",
    "largest_setting",
    "layout",
    "lead_lag",
    "linear_loop",
    "linearize",
    "live",
    "load",
    "loop_gain_pictures",
    "lqg",
    "lqr",
    "measure",
    "named",
    "nichols",
    "nyquist",
    "open_loop",
    "option",
    "overshoot",
    "paper_arm",
    "parameter",
    "peak_error",
    "place",
    "plot",
    "pole_zero_map",
    "pole_zero_structure",
    "read_urdf",
    "record",
    "regressor",
    "relative_gains",
    "replay",
    "rk4",
    "rmse",
    "root_locus",
    "runge_kutta_step",
    "settling_time",
    "side_by_side",
    "simulate",
    "singular_values",
    "sobol",
    "sobol_bars",
    "stability_margins",
    "steady_kalman",
    "step_info",
    "step_response",
    "total_variation",
    "turned",
    "turned_linear",
]

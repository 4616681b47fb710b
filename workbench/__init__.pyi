"""The face for editors and mypy: each name of `wb`, and the room that it comes from."""

from workbench import arms as arms
from workbench import core as core
from workbench import handover as handover
from workbench import identification as identification
from workbench import planning as planning
from workbench import proofs as proofs
from workbench import study as study
from workbench import testing as testing
from workbench.arms.laws import ArmPID, ArmStateFeedback, SlidingMode
from workbench.arms.log_regression import fit_inverse_dynamics
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import base_parameters, paper_arm, regressor, robot
from workbench.arms.mechanics.urdf import read_urdf as read_urdf
from workbench.arms.observers import ArmFullState, ExtendedStateObserver
from workbench.blocks import loop as loop
from workbench.blocks import plants as plants
from workbench.blocks.laws import (
    PID,
    Cascade,
    LimitedLaw,
    LinearLaw,
    ModelPredictive,
    NonlinearPredictive,
    SafetyFilter,
    ScheduledLaw,
    StateFeedback,
    TrajectoryFeedback,
)
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
from workbench.blocks.observers import (
    ExtendedKalmanFilter,
    FullState,
    LinearObserver,
    OffsetFreeObserver,
    SteadyKalmanFilter,
    UnscentedKalmanFilter,
)
from workbench.blocks.plants import (
    Backlash,
    BuckConverter,
    CartPole,
    DCMotor,
    DeadZone,
    DisturbedPlant,
    EquippedPlant,
    FirstOrder,
    FurutaPendulum,
    InputDisturbances,
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
from workbench.blocks.signals import (
    Chirp,
    CombinedReference,
    Constant,
    PlannedReference,
    PulseTrain,
    Ramp,
    Sines,
    SineTorque,
    SquareWave,
    Step,
    Table,
    Trapezoid,
    WayPoints,
)
from workbench.cli.script import load
from workbench.core import (
    Layout,
    Ode,
    SampledLaw,
    SampledSystem,
    Signals,
    block,
    initial,
    layout,
    option,
    parameter,
    rk4,
    runge_kutta_step,
)
from workbench.core import notation as notation
from workbench.core.bounded_loop import bounded_loop
from workbench.core.validation.refusals import Array
from workbench.design import chattering as chattering
from workbench.design import frequency as frequency
from workbench.design import linear as linear
from workbench.design import linear_loop as linear_loops
from workbench.design import linearize
from workbench.design import pid_design as pid_design
from workbench.design import reduction as reduction
from workbench.design import riccati as riccati
from workbench.design import riccati_flow as riccati_flow
from workbench.design import scheduling as scheduling
from workbench.design import structured_tuning as structured_tuning
from workbench.design import structured_uncertainty as structured_uncertainty
from workbench.design import synthesis as synthesis
from workbench.design.frequency import (
    bandwidth,
    c2d,
    condition_number,
    d2c,
    h2_norm,
    hinf_norm,
    pole_zero_structure,
    relative_gains,
    stability_margins,
)
from workbench.design.linear import equilibria, lead_lag, place
from workbench.design.linear_loop import linear_loop
from workbench.design.pid_design import tune_pid
from workbench.design.riccati import lqg, lqr, steady_kalman
from workbench.design.step_response import step_info
from workbench.design.synthesis import (
    coprime_margin,
    h2_controller,
    hinf_controller,
    least_sensitivity,
    lqg_integral,
    mixed_sensitivity,
)
from workbench.engine import metrics as metrics
from workbench.engine import simulate
from workbench.engine.distributions import LogUniform, Uniform
from workbench.engine.factors import Factor
from workbench.engine.metrics import effort, measure, overshoot, peak_error, rmse, settling_time, total_variation
from workbench.engine.reference import reference_run as reference_run
from workbench.handover.c99.c_files import c_code
from workbench.handover.fmi.archive import fmu
from workbench.handover.law_export import export
from workbench.handover.recording import record
from workbench.handover.replays import replay
from workbench.identification import filters as filters
from workbench.identification import linear_models as linear_models
from workbench.identification.datasets import Dataset, check_data
from workbench.identification.estimation import FittedParameters, fit, identifiability
from workbench.identification.experiments import design_experiment
from workbench.planning import ConeLimit, nonlinear_predictive_design, predictive_design
from workbench.planning.trajectories import plan
from workbench.report import loop_pictures as loop_pictures
from workbench.report import pictures as pictures
from workbench.report.fit_page import fit_page
from workbench.report.fit_section import fit_section
from workbench.report.live.turned_knobs import linear_loop_at_knobs, turn_knobs
from workbench.report.loop_page import live
from workbench.report.loop_plots import (
    bode,
    nichols,
    nyquist,
    pole_zero_map,
    root_locus,
    singular_values_plot,
    step_response,
)
from workbench.report.object_plots import plot
from workbench.report.pictures import sobol_bars
from workbench.report.pictures.loop_gain_pictures import loop_gain_pictures
from workbench.study import document as document
from workbench.study import evidence as evidence
from workbench.study import loop_tuning as loop_tuning
from workbench.study import provenance as provenance
from workbench.study import tuning as tuning
from workbench.study import uncertainty as uncertainty
from workbench.study.citation import cite
from workbench.study.design_knob import DesignKnob
from workbench.study.document.document import Page, Paragraph, Section
from workbench.study.document.finding import Finding, Variation
from workbench.study.document.frequency_curves import FrequencyCurve
from workbench.study.document.gain_bounds import GainBound
from workbench.study.evidence import LoopLimits, largest_setting
from workbench.study.evidence.law_tables import side_by_side
from workbench.study.knob import Knob
from workbench.study.loop_tuning import tune
from workbench.study.pid_specification import PidSpecification
from workbench.study.run_and_sweep import Run, Sweep
from workbench.study.specifications import Specification
from workbench.study.study import Case, Results, Study
from workbench.study.study_works import Work
from workbench.study.uncertainty import SobolDesign, sobol

__version__: str
__all__ = [
    "ArmFullState",
    "ArmPID",
    "ArmStateFeedback",
    "Array",
    "Backlash",
    "BuckConverter",
    "CartPole",
    "Cascade",
    "Case",
    "Chirp",
    "ClosedLoop",
    "CombinedReference",
    "ConeLimit",
    "Constant",
    "Controller",
    "DCMotor",
    "Dataset",
    "DeadZone",
    "DesignKnob",
    "DigitalLoop",
    "DisturbedPlant",
    "EquippedPlant",
    "ExtendedKalmanFilter",
    "ExtendedStateObserver",
    "Factor",
    "Finding",
    "FirstOrder",
    "FittedParameters",
    "FrequencyCurve",
    "FullState",
    "FurutaPendulum",
    "GainBound",
    "GaussMarkov",
    "InputDisturbances",
    "Instruments",
    "Knob",
    "Layout",
    "LimitedLaw",
    "LinearLaw",
    "LinearObserver",
    "LinearPlant",
    "LogUniform",
    "LoopLimits",
    "Manipulator",
    "ModelPredictive",
    "NonlinearPredictive",
    "Observer",
    "Ode",
    "OdePlant",
    "OffsetFreeObserver",
    "PID",
    "PadeDelay",
    "Page",
    "Paragraph",
    "PidSpecification",
    "PlanarQuadrotor",
    "PlannedReference",
    "Plant",
    "PulseTrain",
    "Quadrotor",
    "QuadrupleTank",
    "Quantiser",
    "Ramp",
    "RandomWalk",
    "RateLimit",
    "Reference",
    "Results",
    "Run",
    "SafetyFilter",
    "SampledLaw",
    "SampledSystem",
    "Saturation",
    "ScheduledLaw",
    "SecondOrderNoise",
    "Section",
    "Signals",
    "SineTorque",
    "Sines",
    "SingleTrackVehicle",
    "SlidingMode",
    "SobolDesign",
    "Specification",
    "SquareWave",
    "StateFeedback",
    "SteadyKalmanFilter",
    "Step",
    "StirredTank",
    "Study",
    "Sweep",
    "Table",
    "TrajectoryFeedback",
    "Trapezoid",
    "TwoMasses",
    "Uniform",
    "UnscentedKalmanFilter",
    "Variation",
    "WayPoints",
    "Work",
    "arms",
    "bandwidth",
    "base_parameters",
    "block",
    "bode",
    "bounded_loop",
    "c2d",
    "c_code",
    "chattering",
    "check_data",
    "cite",
    "condition_number",
    "coprime_margin",
    "core",
    "d2c",
    "design_experiment",
    "document",
    "effort",
    "equilibria",
    "evidence",
    "export",
    "filters",
    "fit",
    "fit_inverse_dynamics",
    "fit_page",
    "fit_section",
    "fmu",
    "frequency",
    "h2_controller",
    "h2_norm",
    "handover",
    "hinf_controller",
    "hinf_norm",
    "identifiability",
    "identification",
    "initial",
    "largest_setting",
    "layout",
    "lead_lag",
    "least_sensitivity",
    "linear",
    "linear_loop",
    "linear_loop_at_knobs",
    "linear_loops",
    "linear_models",
    "linearize",
    "live",
    "load",
    "loop",
    "loop_gain_pictures",
    "loop_pictures",
    "loop_tuning",
    "lqg",
    "lqg_integral",
    "lqr",
    "measure",
    "metrics",
    "mixed_sensitivity",
    "nichols",
    "nonlinear_predictive_design",
    "notation",
    "nyquist",
    "open_loop",
    "option",
    "overshoot",
    "paper_arm",
    "parameter",
    "peak_error",
    "pictures",
    "pid_design",
    "place",
    "plan",
    "planning",
    "plants",
    "plot",
    "pole_zero_map",
    "pole_zero_structure",
    "predictive_design",
    "proofs",
    "provenance",
    "read_urdf",
    "record",
    "reduction",
    "reference_run",
    "regressor",
    "relative_gains",
    "replay",
    "riccati",
    "riccati_flow",
    "rk4",
    "rmse",
    "robot",
    "root_locus",
    "runge_kutta_step",
    "scheduling",
    "settling_time",
    "side_by_side",
    "simulate",
    "singular_values_plot",
    "sobol",
    "sobol_bars",
    "stability_margins",
    "steady_kalman",
    "step_info",
    "step_response",
    "structured_tuning",
    "structured_uncertainty",
    "study",
    "synthesis",
    "testing",
    "total_variation",
    "tune",
    "tune_pid",
    "tuning",
    "turn_knobs",
    "uncertainty",
]

"""control-workbench: from the equations of a control system to verdicts, numbers and a running controller.

`import workbench as wb` loads nothing by itself; each of the names of `wb` comes from its room when it is first asked
for. `dir(wb)` lists them, and `help(wb.X)` tells of one, with its shapes, units and an example. A family of names has a
room: `wb.document.ReportTable` is a table of a report, `wb.evidence.judge` compares laws, `dir(wb.metrics)` lists
metrics.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

__version__ = "0.1.0"

_ROOMS = {
    "core": "Layout Ode SampledSystem SampledLaw Signals block initial layout option parameter rk4 runge_kutta_step",
    "core.bounded_loop": "bounded_loop",
    "core.validation.refusals": "Array",
    "blocks.laws": "Cascade LimitedLaw LinearLaw ModelPredictive NonlinearPredictive PID SafetyFilter ScheduledLaw "
    "StateFeedback TrajectoryFeedback",
    "blocks.loop": "ClosedLoop Controller DigitalLoop GaussMarkov Instruments Observer Plant RandomWalk Reference "
    "SecondOrderNoise open_loop",
    "blocks.observers": "ExtendedKalmanFilter FullState LinearObserver OffsetFreeObserver SteadyKalmanFilter "
    "UnscentedKalmanFilter",
    "blocks.plants": "Backlash BuckConverter CartPole DCMotor DeadZone DisturbedPlant EquippedPlant FirstOrder "
    "FurutaPendulum InputDisturbances LinearPlant OdePlant PadeDelay PlanarQuadrotor Quadrotor QuadrupleTank "
    "Quantiser RateLimit Saturation SingleTrackVehicle StirredTank TwoMasses",
    "blocks.signals": "Chirp Constant PlannedReference PulseTrain Ramp Sines SineTorque SquareWave Step Table "
    "CombinedReference Trapezoid WayPoints",
    "arms.laws": "ArmPID ArmStateFeedback SlidingMode",
    "arms.log_regression": "fit_inverse_dynamics",
    "arms.manipulator": "Manipulator",
    "arms.mechanics": "base_parameters robot paper_arm regressor",
    "arms.mechanics.urdf": "read_urdf",
    "arms.observers": "ArmFullState ExtendedStateObserver",
    "engine": "simulate",
    "engine.reference": "reference_run",
    "engine.metrics": "effort measure overshoot peak_error rmse settling_time total_variation",
    "planning": "ConeLimit nonlinear_predictive_design predictive_design",
    "design": "linearize",
    "design.frequency": "bandwidth c2d condition_number d2c h2_norm hinf_norm pole_zero_structure relative_gains "
    "stability_margins",
    "design.linear": "equilibria lead_lag place",
    "design.linear_loop": "linear_loop",
    "design.pid_design": "tune_pid",
    "design.riccati": "lqg lqr steady_kalman",
    "design.step_response": "step_info",
    "design.synthesis": "coprime_margin h2_controller hinf_controller least_sensitivity lqg_integral mixed_sensitivity",
    "identification.estimation": "FittedParameters fit identifiability",
    "identification.datasets": "Dataset check_data",
    "identification.experiments": "design_experiment",
    "planning.trajectories": "plan",
    "study": "Case DesignKnob Factor Finding Knob LogUniform Page Paragraph PidSpecification Results Run Section "
    "SobolDesign Study Sweep Uniform Variation Work side_by_side sobol",
    "study.citation": "cite",
    "study.document.frequency_curves": "FrequencyCurve",
    "study.document.gain_bounds": "GainBound",
    "study.evidence": "LoopLimits largest_setting",
    "study.loop_tuning": "tune",
    "study.specifications": "Specification",
    "report.fit_page": "fit_page",
    "report.fit_section": "fit_section",
    "report.live.turned_knobs": "linear_loop_at_knobs turn_knobs",
    "report.loop_page": "live",
    "report.loop_plots": "bode nichols nyquist pole_zero_map root_locus singular_values_plot step_response",
    "report.object_plots": "plot",
    "report.pictures": "sobol_bars",
    "report.pictures.loop_gain_pictures": "loop_gain_pictures",
    "handover.c99.c_files": "c_code",
    "handover.fmi.archive": "fmu",
    "handover.law_export": "export",
    "handover.recording": "record",
    "handover.replays": "replay",
    "cli.script": "load",
}
_HOMES = {name: room for room, names in _ROOMS.items() for name in names.split()}
_THERE = {  # the names that a room calls otherwise
    "Controller": "AbstractController",
    "Observer": "AbstractObserver",
    "Plant": "AbstractPlant",
    "Reference": "AbstractReference",
}
_SPACES = {  # the rooms whose families of names are used by the name of the room, as in `wb.evidence.judge`
    "arms": "arms",
    "chattering": "design.chattering",
    "core": "core",
    "document": "study.document",
    "evidence": "study.evidence",
    "filters": "identification.filters",
    "frequency": "design.frequency",
    "handover": "handover",
    "identification": "identification",
    "linear": "design.linear",
    "linear_loops": "design.linear_loop",
    "linear_models": "identification.linear_models",
    "loop": "blocks.loop",
    "loop_pictures": "report.loop_pictures",
    "loop_tuning": "study.loop_tuning",
    "metrics": "engine.metrics",
    "notation": "core.notation",
    "pictures": "report.pictures",
    "pid_design": "design.pid_design",
    "planning": "planning",
    "plants": "blocks.plants",
    "proofs": "proofs",
    "provenance": "study.provenance",
    "reduction": "design.reduction",
    "riccati": "design.riccati",
    "riccati_flow": "design.riccati_flow",
    "scheduling": "design.scheduling",
    "structured_uncertainty": "design.structured_uncertainty",
    "structured_tuning": "design.structured_tuning",
    "study": "study",
    "synthesis": "design.synthesis",
    "testing": "testing",
    "tuning": "study.tuning",
    "uncertainty": "study.uncertainty",
}
__all__ = [*_HOMES, *_SPACES]
_OTHER_TOOLBOXES = {  # what MATLAB or python-control calls otherwise, and what does it here
    "acker": "wb.place",
    "allmargin margin": "wb.stability_margins(G) for a system, or wb.linear_loop(loop).margins() for a loop",
    "arx armax oe bj n4sid polyest": "wb.linear_models.arx, armax, output_error, box_jenkins, subspace_model",
    "etfe spa tfestimate": "wb.linear_models.spectral_response, periodic_response or local_polynomial_response",
    "balred balreal modred hsvd": "wb.reduction.balanced_truncation, singular_perturbation or hankel_values",
    "bode_plot bodeplot bodemag": "wb.bode",
    "care riccati_equation": "wb.riccati.care",
    "ctrb obsv": "wb.linear.controllability and wb.linear.observability",
    "damp pole poles": "wb.linear.poles",
    "dare": "wb.riccati.dare",
    "diskmargin disk_margins": "wb.linear_loop(loop).disk_margin",
    "dlqr": "wb.lqr(..., discrete=True)",
    "dlyap": "wb.riccati.discrete_lyapunov",
    "dlqe kalman lqe": "wb.steady_kalman for a loop, wb.riccati.lqe for matrices, or wb.filters for a log",
    "hankelmr hankel_singular_values": "wb.reduction.hankel_norm_reduction or wb.reduction.hankel_values",
    "feedback interconnect connect": "wb.ClosedLoop",
    "find_operating_point findop trim": "wb.equilibria",
    "freqresp evalfr": "wb.linear_loop(loop).response",
    "h2syn": "wb.h2_controller",
    "hinfnorm getPeakGain": "wb.hinf_norm",
    "hinfsyn mixsyn": "wb.mixed_sensitivity, then wb.hinf_controller",
    "linmod": "wb.linearize",
    "lsim forced_response ode45 sim": "wb.simulate",
    "lqi": "wb.synthesis.lqi, or wb.lqg_integral",
    "ltrsyn": "wb.synthesis.loop_transfer_recovery",
    "lyap": "wb.riccati.lyapunov",
    "dksyn musyn": "wb.structured_uncertainty.dk_iteration",
    "mussv ab13md": "wb.structured_uncertainty.structured_singular_value",
    "ncfsyn ncfmargin": "wb.coprime_margin",
    "nichols_plot nicholsplot": "wb.nichols",
    "norm": "wb.h2_norm or wb.hinf_norm",
    "nyquist_plot nyquistplot": "wb.nyquist",
    "pade": "wb.PadeDelay",
    "pidtune": "wb.tune_pid",
    "pole_zero_plot pzmap": "wb.pole_zero_map",
    "rlocus root_locus_plot": "wb.root_locus",
    "robstab robgain": "wb.structured_uncertainty.robustness_over_frequency",
    "sample_system": "wb.c2d",
    "sigma": "wb.singular_values_plot",
    "ss tf zpk StateSpace TransferFunction": "control.ss or control.tf, and wb.LinearPlant or wb.LinearLaw in a loop",
    "step impulse": "wb.step_response(G) for a system, or wb.linear_loop(loop).plot(...) for a loop",
    "stepinfo": "wb.step_info",
    "systune looptune hinfstruct": "wb.tune for a loop, or wb.structured_tuning.structured_controller for a plant",
    "tzero zero zeros": "wb.pole_zero_structure",
}
_RENAMED = {  # what the face called otherwise before all names were plain
    "Disturbed": "DisturbedPlant",
    "Equipped": "EquippedPlant",
    "Hold": "Constant",
    "PID2": "PID",
    "Regulator": "StateFeedback",
    "Sampled": "SampledSystem",
    "Together": "CombinedReference",
    "named": "robot",
    "singular_values": "singular_values_plot",
    "turn_knobs_linear": "linear_loop_at_knobs",
    "turned": "turn_knobs",
    "turned_linear": "linear_loop_at_knobs",
}


def __getattr__(name: str) -> Any:
    """A name of the face, loaded from its room when it is first asked for."""
    if name in _SPACES:
        return globals().setdefault(name, import_module(f"workbench.{_SPACES[name]}"))
    if name not in _HOMES:
        raise AttributeError(f"module 'workbench' has no attribute '{name}'.{_advice(name)}")
    held = getattr(import_module(f"workbench.{_HOMES[name]}"), _THERE.get(name, name))
    globals()[name] = held
    return held


def _advice(name: str) -> str:
    """The answer to an earlier name or one of another toolbox, or else the name of the face that is most like it."""
    from difflib import get_close_matches  # the nearest of `validation` would load NumPy

    if name in _RENAMED:
        return f" It is called '{_RENAMED[name]}' now."
    for names, ours in _OTHER_TOOLBOXES.items():
        if name in names.split():
            more = "the how-to 'Come from MATLAB or python-control' has more"
            return f" In place of '{name}' of MATLAB or python-control, use {ours}; {more}."
    return "".join(f" Did you mean '{other}'?" for other in get_close_matches(name, __all__, 1))


def __dir__() -> list[str]:
    return sorted({*__all__, *(name for name in globals() if name.startswith("__"))})

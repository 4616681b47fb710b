"""PI and PID laws for each process of the batch: the optimum under a limit, and two rules."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

import workbench as wb
from studies.d1_benchmarks.batch import Process
from studies.d1_benchmarks.linear_systems import step_response, transfer_function

LIMIT = 1.4  # of Ms and Mt, at which the rule AMIGO aims
SETTLED = 40.0  # s, after which the step responses of P9 have settled
STEP_COUNT = 20_000
COMPLEX = 0.1  # of the size of the poles: a smaller imaginary part is that of a multiple real pole, by rounding


@dataclass(frozen=True)
class TunedLaw:
    """A law for a process: its gains, the certified peaks with their bounds, and IAE after a step of load.

    IAE is NaN where it cannot be computed well. `reason` says why there is no law, '' if there is one.
    """

    k: float = np.nan
    ki: float = np.nan
    kd: float = 0.0
    N: float = np.inf
    Ms: float = np.nan
    Mt: float = np.nan
    Ms_width: float = np.nan
    IAE: float = np.nan
    reason: str = ""


@dataclass(frozen=True)
class ProcessDesigns:
    """The laws for a process, and the time constants of the model on which the rules act."""

    lag: float
    late: float
    PI: TunedLaw
    PID: TunedLaw
    simc: TunedLaw
    amigo: TunedLaw


def designs(process: Process) -> ProcessDesigns:
    """The optimum PI and PID laws of a process, and PI laws by the rules SIMC and AMIGO."""
    plant, late = transfer_function(process.num, process.den), process.delay
    model = model_of(process)
    return ProcessDesigns(
        model.T,
        model.L,
        tuned_law(lambda: wb.tune_pid(plant, delay=late, Ms=LIMIT)),
        tuned_law(lambda: wb.tune_pid(plant, delay=late, Ms=LIMIT, form="PID", criterion="IE")),
        tuned_law(lambda: wb.pid_design.simc(plant, model, delay=late)),
        tuned_law(lambda: wb.pid_design.amigo(plant, model, delay=late)),
    )


def model_of(process: Process) -> wb.pid_design.StepModel:
    """The model with one lag and a delay: by the half rule, or of the step response where poles are complex."""
    plant = transfer_function(process.num, process.den)
    if np.iscomplexobj(roots := np.roots(process.den)) and np.abs(roots.imag).max() > COMPLEX * np.abs(roots).max():
        return wb.pid_design.step_model(*step_response(plant, SETTLED, STEP_COUNT))
    return wb.pid_design.half_rule_model(plant, process.delay)


def tuned_law(design: Callable[[], wb.pid_design.PidDesign]) -> TunedLaw:
    """The numbers of a design, or the reason why there is none."""
    try:
        found = design()
    except wb.linear.DesignError as error:
        return TunedLaw(reason=str(error))
    held = found.certificate.margins
    if held is None:
        return TunedLaw(found.k, found.ki, found.kd, found.N or np.inf, reason="the loop is unstable")
    S, T = held.Ms.gain, held.Mt.gain
    width = (S.high - S.low) / S.value
    return TunedLaw(found.k, found.ki, found.kd, found.N or np.inf, S.value, T.value, width, absolute_error(found))


def absolute_error(design: wb.pid_design.PidDesign) -> float:
    """IAE of a design; NaN where the design says that it cannot be computed well."""
    try:
        return design.IAE
    except wb.linear.DesignError:
        return np.nan

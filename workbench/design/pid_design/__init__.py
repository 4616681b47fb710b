"""PID laws from a specification, each checked by margins that share no code with the design.

This package takes linear plants with a delay. Read `pi_optimum.py` first, then `integral_gain.py` and `gain_search.py`
(the global search) and `optimum_contacts.py` (Newton's method).

Examples
--------
>>> import control
>>> wb.pid_design.pi_optimum(control.tf([1], [2, 1]), Ms=1.6, delay=1.0).certificate.stable
True
"""

from workbench.design.pid_design.loop_filters import NotchDesign, PrefilterDesign, notch, prefilter
from workbench.design.pid_design.pi_optimum import pi_optimum
from workbench.design.pid_design.pid_designs import PeakContact, PidDesign
from workbench.design.pid_design.pid_optimum import pid_optimum
from workbench.design.pid_design.pid_rules import amigo, lambda_tuning, simc
from workbench.design.pid_design.step_model import StepModel, half_rule_model, step_model
from workbench.design.pid_design.tune_pid import tune_pid

__all__ = [
    "NotchDesign",
    "PeakContact",
    "PidDesign",
    "PrefilterDesign",
    "StepModel",
    "amigo",
    "half_rule_model",
    "lambda_tuning",
    "notch",
    "pi_optimum",
    "pid_optimum",
    "prefilter",
    "simc",
    "step_model",
    "tune_pid",
]

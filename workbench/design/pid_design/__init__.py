"""PID laws from a specification, each checked by margins that share no code with the design.

This package takes linear plants with a delay. Read `pi_optimum.py` first, then `integral_gain.py` and `gain_search.py`
(the global search) and `optimum_contacts.py` (Newton's method).

Examples
--------
>>> import control
>>> wb.pid_design.pi_optimum(control.tf([1], [2, 1]), Ms=1.6, delay=1.0).certificate.stable
True
"""

from workbench.design.pid_design.pi_optimum import pi_optimum
from workbench.design.pid_design.pid_designs import PeakContact, PidDesign
from workbench.design.pid_design.pid_optimum import pid_optimum
from workbench.design.pid_design.tune_pid import tune_pid

__all__ = ["PeakContact", "PidDesign", "pi_optimum", "pid_optimum", "tune_pid"]

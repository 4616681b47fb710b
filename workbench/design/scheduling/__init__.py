"""Gain scheduling: linear models over a family of operating points, and the check of a law that is scheduled over them.

This package takes equations and loops; it knows no law or plant by name. `operating_family` gives the models from which
a law is designed at each point, `wb.ScheduledLaw` interpolates these laws, and `check_schedule` checks the loop at the
points and between them.

Examples
--------
>>> family = wb.scheduling.operating_family(wb.open_loop(wb.StirredTank()), {"T": [335.0, 350.0]})
>>> [bool(model.poles().real.max() < 0) for model in family.models]
[True, False]
"""

from workbench.design.scheduling.operating_family import OperatingFamily, operating_family
from workbench.design.scheduling.schedule_check import ScheduleCheck, check_schedule

__all__ = ["OperatingFamily", "ScheduleCheck", "check_schedule", "operating_family"]

"""FMUs: a law, a plant or a loop as one file that other simulators run, after the FMI standard.

Read `archive` first, then `co_simulation`, `step_sources` and `description`. `instance.h`, `fmi2.c` and `fmi3.c` of
`handover/templates/fmi` are the same in each FMU.
"""

from workbench.handover.fmi.archive import Fmu, fmu

__all__ = ["Fmu", "fmu"]

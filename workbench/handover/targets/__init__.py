"""Machines that run a law on recorded inputs: compiled programs, microcontrollers, a browser, FMUs and NumPy.

A target takes the C of a law and a recording, and gives commands and memory, which are compared bit by bit. Read
`contract` first, then `harness`, the program around the C of a law, and `compilers`.
"""

from collections.abc import Mapping

from workbench.handover.targets.array_target import ArrayTarget
from workbench.handover.targets.browser import Browser
from workbench.handover.targets.compilers import ARM_64, HERE
from workbench.handover.targets.cortex_m import CORTEX_M4F, CORTEX_M4F_AS_IT_IS, CORTEX_M7
from workbench.handover.targets.fmu_importer import Importer
from workbench.handover.targets.target import AbstractTarget, CalledTarget, TargetCost

TARGETS: Mapping[str, AbstractTarget] = {
    **{target.name.replace(" ", ""): target for target in HERE},
    "arm64": ARM_64,
    "cortex-m4f": CORTEX_M4F,
    "cortex-m7": CORTEX_M7,
    "cortex-m4f-libgcc": CORTEX_M4F_AS_IT_IS,
    "browser": Browser("V8, Chrome's engine, in Node"),
    "fmi2": Importer("FMU of FMI 2.0, in FMPy", "2.0"),
    "fmi3": Importer("FMU of FMI 3.0, in FMPy", "3.0"),
    "numpy": ArrayTarget("NumPy"),
}

USUAL = tuple(key for key in TARGETS if key != "cortex-m4f-libgcc")  # without a library whose fault is known

__all__ = ["TARGETS", "USUAL", "AbstractTarget", "CalledTarget", "TargetCost"]

"""The room for editors and mypy: each of its names, and the file that it comes from."""

from workbench.handover.memory_digest import BASIS
from workbench.handover.replays import CLOCKS, PeriodShare, TargetResult, compare, fits
from workbench.handover.single.single_precision_loop import in_single_precision
from workbench.handover.targets import TARGETS
from workbench.handover.targets.cortex_m import CORTEX_M7

__all__ = [
    "BASIS",
    "CLOCKS",
    "CORTEX_M7",
    "PeriodShare",
    "TARGETS",
    "TargetResult",
    "compare",
    "fits",
    "in_single_precision",
]

"""Export of a law as a program for its machine, and the comparison that shows it to be the same law.

This package writes C, FMUs and programs in other languages. It records a run of the loop, replays it on a target, and
compares every bit. Read `law_export.py` first, then `recording.py` and `replays.py`.

Examples
--------
>>> sorted(wb.handover.TARGETS)[:2]
['arm64', 'browser']
"""

from workbench.core.lazy_names import lazy_names

_FILES = {
    "memory_digest": "BASIS",
    "replays": "CLOCKS PeriodShare TargetResult compare fits",
    "single.single_precision_loop": "in_single_precision",
    "targets": "TARGETS",
    "targets.cortex_m": "CORTEX_M7",
}
__all__, __getattr__, __dir__ = lazy_names(__name__, _FILES)

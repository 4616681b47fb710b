"""A law as the program that runs on its machine, and the proof that it is the same law.

The room knows steps, graphs and their machines: it writes C, FMUs and programs of other languages, records runs, and
replays them on a target to compare every bit. Read `law_export.py` first, then `recording.py` and `replays.py`.

Examples
--------
>>> sorted(wb.handover.TARGETS)[:2]
['arm64', 'browser']
"""

from workbench.core.lazy_names import lazy_names

_FILES = {
    "memory_digest": "BASIS",
    "replays": "CLOCKS Fit TargetResult compare fits",
    "single.single_precision_loop": "in_single_precision",
    "targets": "TARGETS",
}
__all__, __getattr__, __dir__ = lazy_names(__name__, _FILES)

"""The inner parts of the workbench whose share of the time is measured: a sweep's chunks, their pool, and the ledger.

No engineer needs them, and the other files of the study have them from here.
"""

from workbench.study.compiled_sweep import CompiledSweep, compile_sweep
from workbench.study.executors import on_threads
from workbench.study.ledger.store import complete, open_ledger
from workbench.study.sweep_runs import tasks_of

__all__ = ["CompiledSweep", "compile_sweep", "complete", "on_threads", "open_ledger", "tasks_of"]

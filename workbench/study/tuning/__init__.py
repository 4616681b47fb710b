"""Tuning: the same search for every law that is compared, by one objective and with one budget.

The room knows sweeps and samples, and nothing of files: who computes its runs is handed in.
Read `contract` first, then `search`; `optimum` says what was found and how far it may be trusted.

Examples
--------
>>> wb.tuning.Tuning.__name__
'Tuning'
"""

from workbench.study.tuning.search import tune
from workbench.study.tuning.tuning import Objective, Trial, Tuning, equal_budget
from workbench.study.tuning.tuning_result import TuningResult

__all__ = ["Objective", "Trial", "TuningResult", "Tuning", "equal_budget", "tune"]

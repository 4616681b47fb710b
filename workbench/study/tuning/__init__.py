"""Tuning: the same search for every law that is compared, by one objective and with one budget.

The room knows sweeps and samples, and nothing of files: who computes its runs is handed in.
Read `contract` first, then `search`; `optimum` says what was found and how far it may be trusted.

Examples
--------
>>> wb.tuning.Tuning.__name__
'Tuning'
"""

from workbench.study.tuning.contract import Objective, Trial, Tuning, equal_budget
from workbench.study.tuning.optimum import Tuned
from workbench.study.tuning.search import tune

__all__ = ["Objective", "Trial", "Tuned", "Tuning", "equal_budget", "tune"]

"""Tuning: the same search for every law that is compared, by one objective and with one budget.

This package neither reads nor writes files. The caller passes the function that computes the runs of a trial. Read
`tuning` first, then `search`; `tuning_result` says what was found, and how far it can be trusted.

Examples
--------
>>> wb.tuning.Tuning.__name__
'Tuning'
"""

from workbench.study.tuning.search import tune
from workbench.study.tuning.tuning import Objective, Trial, Tuning, equal_budget
from workbench.study.tuning.tuning_result import TuningResult

__all__ = ["Objective", "Trial", "TuningResult", "Tuning", "equal_budget", "tune"]

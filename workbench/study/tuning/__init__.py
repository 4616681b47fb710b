"""The same search for every law: one objective, one budget, trials to train on, and doubts that are said."""

from workbench.study.tuning.budget import equal_budget
from workbench.study.tuning.contract import Objective, Trial, Tuning
from workbench.study.tuning.search import tune
from workbench.study.tuning.tuned import Tuned

__all__ = ["Objective", "Trial", "Tuned", "Tuning", "equal_budget", "tune"]

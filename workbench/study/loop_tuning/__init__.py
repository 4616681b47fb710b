"""The knobs of any loop tuned for a specification: limits and goals in frequency and time, for several plants at once.

Read `loop_tuning.py` first, then `tuned_loop.py`, which has the answer.

Examples
--------
>>> wb.loop_tuning.RunGoal(wb.rmse(), until=5.0, h=1e-3, limit=0.1).words
'RMSE <= 0.1'
"""

from workbench.study.loop_tuning.loop_tuning import tune
from workbench.study.loop_tuning.run_goals import RunGoal
from workbench.study.loop_tuning.tuned_loop import TunedGoal, TunedLoop

__all__ = ["RunGoal", "TunedGoal", "TunedLoop", "tune"]

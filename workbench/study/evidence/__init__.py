"""Comparison of laws over the same draws of the uncertain numbers, with simultaneous intervals.

Beside them are searches for the largest value that meets a criterion. The room knows values by law and draw, estimands
such as a mean or a tail, and tables of them; of loops it knows the equations alone. Read `judgement.py` first, then
`pooling.py`, `estimands.py` and `threshold.py`.
"""

from workbench.study.evidence.bootstrap import Intervals
from workbench.study.evidence.common_draws import Paired, paired, same_draws
from workbench.study.evidence.comparison_tables import (
    ablation_table,
    change_without,
    comparison_table,
    level_of,
    statistics_table,
)
from workbench.study.evidence.estimands import Mean, Median, Quantile, Success, Tail, least_draws
from workbench.study.evidence.judgement import Judgement, Standings, judge
from workbench.study.evidence.largest_setting import LargestSetting, LoopLimits, LoopTrial, largest_setting
from workbench.study.evidence.pairwise_comparison import Comparison, Ranks, compare, ranks
from workbench.study.evidence.pooling import Pooled, leave_one_out, pool
from workbench.study.evidence.threshold import Threshold, bisect, find_largest

__all__ = [
    "Comparison",
    "Intervals",
    "Judgement",
    "LargestSetting",
    "LoopLimits",
    "LoopTrial",
    "Mean",
    "Median",
    "Paired",
    "Pooled",
    "Quantile",
    "Ranks",
    "Standings",
    "Success",
    "Tail",
    "Threshold",
    "ablation_table",
    "bisect",
    "change_without",
    "compare",
    "comparison_table",
    "find_largest",
    "judge",
    "largest_setting",
    "least_draws",
    "leave_one_out",
    "level_of",
    "paired",
    "pool",
    "ranks",
    "same_draws",
    "statistics_table",
]

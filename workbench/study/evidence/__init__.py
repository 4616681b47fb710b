"""Comparison of laws over the same draws of the uncertain numbers, with simultaneous intervals.

A draw is one random sample of all uncertain numbers. This package takes values by law and draw, and compares laws by
estimands such as a mean or a tail. It also searches for the largest setting that meets a criterion, and makes tables of
all these. It knows loops by their equations alone. Read `judgement.py` first, then `pooling.py`, `estimands.py` and
`threshold.py`.

Examples
--------
>>> wb.evidence.order((1.0, 0.1), (2.0, 0.1))  # two values with their errors
'below'
"""

from workbench.study.evidence.bold_cells import BOLD
from workbench.study.evidence.bootstrap import Intervals
from workbench.study.evidence.comparison_tables import (
    HALF,
    ablation_table,
    change_without,
    comparison_table,
    level_of,
    statistics_table,
)
from workbench.study.evidence.computer_margins import (
    KEEPS_RATIO,
    STANDS_RATIO,
    ComputerEffect,
    ComputerMargin,
    ComputerMargins,
    computer_effects,
    computer_margins,
    computer_sweep,
    computer_table,
    worst_ratio,
)
from workbench.study.evidence.divergence_causes import Causes, causes_in_sweep
from workbench.study.evidence.estimands import Mean, Median, Quantile, Success, Tail, least_draws
from workbench.study.evidence.judgement import LawJudgement, Standings, judge
from workbench.study.evidence.largest_setting import LargestSetting, LoopLimits, LoopTrial, largest_setting
from workbench.study.evidence.law_tables import (
    PublishedColumn,
    against_published,
    information_table,
    ranking,
    side_by_side,
)
from workbench.study.evidence.paired_samples import PairedSamples, pair_samples, same_draws
from workbench.study.evidence.pairwise_comparison import Comparison, Ranks, compare, ranks
from workbench.study.evidence.pooling import WAYS, PooledJudgement, Way, leave_one_out, pool
from workbench.study.evidence.threshold import Threshold, bisect, find_largest
from workbench.study.evidence.value_order import order

__all__ = [
    "BOLD",
    "Causes",
    "Comparison",
    "ComputerEffect",
    "ComputerMargin",
    "ComputerMargins",
    "HALF",
    "Intervals",
    "LawJudgement",
    "KEEPS_RATIO",
    "LargestSetting",
    "LoopLimits",
    "LoopTrial",
    "Mean",
    "Median",
    "PairedSamples",
    "PooledJudgement",
    "PublishedColumn",
    "Quantile",
    "Ranks",
    "STANDS_RATIO",
    "Standings",
    "Success",
    "Tail",
    "Threshold",
    "WAYS",
    "Way",
    "ablation_table",
    "against_published",
    "bisect",
    "causes_in_sweep",
    "change_without",
    "compare",
    "comparison_table",
    "computer_effects",
    "computer_margins",
    "computer_sweep",
    "computer_table",
    "find_largest",
    "information_table",
    "judge",
    "largest_setting",
    "least_draws",
    "leave_one_out",
    "level_of",
    "order",
    "pair_samples",
    "pool",
    "ranking",
    "ranks",
    "same_draws",
    "side_by_side",
    "statistics_table",
    "worst_ratio",
]

"""Comparison of laws over the same draws of the uncertain numbers, with simultaneous intervals.

The room knows values by law and draw, estimands such as a mean or a tail, and tables of them; it does not know loops,
metrics or how the runs were made. Read `judgement.py` first, then `estimands.py`.
"""

from workbench.study.evidence.bootstrap import Intervals
from workbench.study.evidence.common_draws import Paired, paired, same_draws
from workbench.study.evidence.comparison_tables import ablation_table, comparison_table, statistics_table
from workbench.study.evidence.estimands import Mean, Median, Quantile, Success, Tail
from workbench.study.evidence.judgement import Judgement, Standings, judge
from workbench.study.evidence.pairwise_comparison import Comparison, Ranks, compare, ranks
from workbench.study.evidence.sample_shapes import Predictor, Shape, shapes

__all__ = [
    "Comparison",
    "Intervals",
    "Judgement",
    "Mean",
    "Median",
    "Paired",
    "Predictor",
    "Quantile",
    "Ranks",
    "Shape",
    "Standings",
    "Success",
    "Tail",
    "ablation_table",
    "compare",
    "comparison_table",
    "judge",
    "paired",
    "ranks",
    "same_draws",
    "shapes",
    "statistics_table",
]

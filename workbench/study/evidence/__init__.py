"""What the runs of several laws over the same draws say of who is better, and how surely."""

from workbench.study.evidence.bootstrap import Intervals
from workbench.study.evidence.comparison import Comparison, compare
from workbench.study.evidence.estimands import Mean, Median, Quantile, Success, Tail
from workbench.study.evidence.judgement import Judgement, judge
from workbench.study.evidence.paired import Paired, paired, same_draws
from workbench.study.evidence.ranks import Ranks, ranks
from workbench.study.evidence.standings import Standings
from workbench.study.evidence.tables import (
    ablation_table,
    comparison_table,
    difference_table,
    rank_table,
    statistics_table,
)
from workbench.study.evidence.tails import Predictor, Shape, shapes

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
    "difference_table",
    "judge",
    "paired",
    "rank_table",
    "ranks",
    "same_draws",
    "shapes",
    "statistics_table",
]

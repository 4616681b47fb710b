"""What the runs of several laws over the same draws say of who is better, and how surely."""

from workbench.study.evidence.bootstrap import Intervals
from workbench.study.evidence.comparison import Comparison, compare
from workbench.study.evidence.paired import Paired, paired, same_draws
from workbench.study.evidence.ranks import Ranks, ranks
from workbench.study.evidence.tables import ablation_table, comparison_table, difference_table, rank_table

__all__ = [
    "Comparison",
    "Intervals",
    "Paired",
    "Ranks",
    "ablation_table",
    "compare",
    "comparison_table",
    "difference_table",
    "paired",
    "rank_table",
    "ranks",
    "same_draws",
]

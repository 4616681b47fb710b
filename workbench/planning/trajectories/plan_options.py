"""The accuracy of a plan and the search for it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypedDict

from workbench.core.validation.refusals import one_of, positive, whole
from workbench.core.validation.refusals import seed as check_seed
from workbench.core.validation.signatures import check_arguments

HOLDS = ("automatic", "zero", "linear")
METHODS = ("collocation", "shooting")
LEAST, MOST = 4, 20_000  # intervals


class OptionsByName(TypedDict, total=False):
    """The fields of `PlanOptions` as arguments of `plan`."""

    hold: str
    method: str
    intervals: int
    most_intervals: int
    starts: int
    seed: int
    tolerance: float
    objective_tolerance: float


@dataclass(frozen=True)
@check_arguments
class PlanOptions:
    """The options of `wb.plan`, which takes each by its name.

    Parameters
    ----------
    hold
        The inputs between nodes: constant ("zero"), straight lines ("linear"), or "automatic", by the lower objective.
    method
        Radau "collocation" of order 5, or "shooting" by Runge-Kutta steps.
    intervals, most_intervals
        The intervals of the first mesh of each phase, and the most of the last mesh.
    starts, seed
        The number of starts, of which the best is refined, and the key of the random ones; the first is a straight line
        or the guess.
    tolerance
        The largest miss of a node by the simulator, as a share of the range of each state.
    objective_tolerance
        The largest relative change of the objective by a cut of all intervals.

    Raises
    ------
    ValueError
        If a number or a word is none of those.

    Examples
    --------
    >>> wb.planning.PlanOptions(starts=5).hold
    'automatic'
    """

    hold: str = "automatic"
    method: str = "collocation"
    intervals: int = 30
    most_intervals: int = 1000
    starts: int = 3
    seed: int = 0
    tolerance: float = 1e-6
    objective_tolerance: float = 1e-4

    def __post_init__(self) -> None:
        one_of("plan(hold=...)", self.hold, HOLDS)
        one_of("plan(method=...)", self.method, METHODS)
        whole("plan(intervals=...)", self.intervals, LEAST, MOST)
        whole("plan(most_intervals=...)", self.most_intervals, LEAST, MOST)
        whole("plan(starts=...)", self.starts)
        check_seed("plan(seed=...)", self.seed)
        positive("plan(tolerance=...)", self.tolerance)
        positive("plan(objective_tolerance=...)", self.objective_tolerance)

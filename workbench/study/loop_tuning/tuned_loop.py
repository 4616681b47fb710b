"""The answer of a tuning: the knobs, the loop, and each goal with certified values at each plant."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from workbench.core import Ode, SampledSystem
from workbench.core.equations import Loop
from workbench.core.validation.notebook_display import show
from workbench.core.validation.signatures import check_arguments
from workbench.design.frequency import CertifiedValue
from workbench.design.linear_loop import LinearLoop
from workbench.design.structured_tuning import StartResult
from workbench.design.structured_tuning.multistart import spread_of
from workbench.study.document.phrases_and_tables import Cell, ReportTable, TableColumn
from workbench.study.specifications import SpecificationVerdicts

EDGE = 1e-6  # of a range, from its end


@dataclass(frozen=True, eq=False)
class TunedGoal:
    """A goal in words, its worst figure over all plants between certified bounds, and the number of that plant.

    Plant 0 is the nominal one. `value` is None if there is no certified figure, as for a run; its number is the
    `estimate`. `holds` is None for a soft goal.
    """

    words: str
    plant: int
    value: CertifiedValue | None
    estimate: float
    is_active: bool
    holds: bool | None


@dataclass(frozen=True, eq=False)
@show
class TunedLoop:
    """A loop whose knobs were tuned: their `values` by name, and the goals that they reach at each plant.

    `loop` is the loop with the values in its fields, or None if the path of a knob is no field. `equations` are its
    equations with the values as defaults. `linear` are the linear loops of the plants, the nominal one first, and
    `verdicts` has the verdicts of the specification for each. The `goals` have certified figures, but for runs; the
    active ones stop the search. `stationarity` is the norm of the smallest convex combination of the active gradients,
    and zero at a local optimum: they are derivatives of log(figure) by the places of the knobs in their ranges, from 0
    to 1. `starts` are the ends of the search from each start. `at_edge` names the knobs at an end of their range.
    `full_order_gamma` is the norm that was given to `tune`.
    """

    values: Mapping[str, float]
    loop: Loop | Ode | SampledSystem | None
    equations: Ode | SampledSystem
    linear: tuple[LinearLoop, ...]
    verdicts: tuple[SpecificationVerdicts, ...]
    goals: tuple[TunedGoal, ...]
    stationarity: float
    starts: tuple[StartResult, ...]
    at_edge: tuple[str, ...]
    full_order_gamma: float | None = None

    @property
    def holds(self) -> bool:
        """True if each limit is certainly kept at each plant."""
        return all(one.holds for one in self.verdicts) and all(one.holds is not False for one in self.goals)

    @property
    def active_goals(self) -> tuple[str, ...]:
        """The goals that stop the search where it is, in words."""
        return tuple(one.words for one in self.goals if one.is_active)

    @property
    def spread(self) -> float:
        """The range of the largest soft goal over the starts that keep all limits, as a logarithm; NaN if none does."""
        return spread_of(self.starts)

    @check_arguments
    def table(self, name: str = "tuning", caption: str = "") -> ReportTable:
        """The goals as a table, a block of a section of a report."""
        columns = tuple(TableColumn(title) for title in ("goal", "figure", "plant", "active", "holds"))
        rows = tuple(_row(one) for one in self.goals)
        return ReportTable(name, caption or "The goals of the tuned loop.", columns, rows)


def _row(one: TunedGoal) -> tuple[Cell, ...]:
    value = one.estimate if one.value is None else one.value.value
    shown = f"{value:.6g}" if math.isfinite(value) else "none"
    kept = "" if one.holds is None else "yes" if one.holds else "no"
    return one.words, shown, str(one.plant), "yes" if one.is_active else "", kept

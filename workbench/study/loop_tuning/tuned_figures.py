"""The certified figures of the goals of a tuned loop, the worst over its plants."""

from __future__ import annotations

import math
from collections.abc import Sequence

from workbench.design.frequency import CertifiedValue, h2_norm
from workbench.design.linear_loop import LinearLoop
from workbench.design.structured_tuning import LoopGoal
from workbench.design.structured_tuning.loop_goals import LoopAnswer
from workbench.design.structured_tuning.nonsmooth_search import PieceValues
from workbench.study.loop_tuning.tuned_loop import TunedGoal
from workbench.study.loop_tuning.tuning_problem import TuningGoal
from workbench.study.specifications.loop_systems import LoopSystems
from workbench.study.specifications.point_figures import largest_gain_figure, point_figure


def certified_goals(
    goals: Sequence[TuningGoal],
    linear: Sequence[LinearLoop],
    answers: Sequence[LoopAnswer],
    values: PieceValues,
    active: set[int],
) -> tuple[TunedGoal, ...]:
    """Each goal with the worst of its figures over all plants."""
    made = []
    for number, goal in enumerate(goals):
        pieces = [one for one in (*values.soft, *values.hard) if one.figure % len(goals) == number]
        worst = max(pieces, key=lambda one: one.value, default=None)
        plant = 0 if worst is None else worst.figure // len(goals)
        if not isinstance(goal.goal, LoopGoal):
            reference = goal.goal.scale if goal.goal.limit is None else goal.goal.limit
            excess = math.nan if worst is None else worst.value
            kept = excess <= 1e-6 if goal.is_hard else None
            made.append(TunedGoal(goal.words, plant, None, reference * math.exp(excess), number in active, kept))
            continue
        figures = [_figure(goal.goal, one, at) for one, at in zip(linear, answers, strict=True)]
        value = figures[plant]
        kept = None
        if goal.is_hard and value is not None:
            kept = all(one is not None and _kept(one, goal.ends) for one in figures)
        estimate = math.nan if value is None else value.value
        made.append(TunedGoal(goal.words, plant, value, estimate, number in active, kept))
    return tuple(made)


def _figure(goal: LoopGoal, linear: LinearLoop, at: LoopAnswer) -> CertifiedValue | None:
    if goal.figure == "gain":
        return largest_gain_figure(linear.system("closed", goal.inputs, goal.outputs), "").value
    if goal.figure == "h2":
        return h2_norm(linear.system("closed", goal.inputs, goal.outputs)).gain
    return point_figure(goal.figure, LoopSystems(linear, at.answer)).value


def _kept(value: CertifiedValue, ends: tuple[float, float]) -> bool:
    low, high = ends
    return value.low >= low and value.high <= high

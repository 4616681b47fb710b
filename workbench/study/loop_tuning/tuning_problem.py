"""The problem of a tuning: linear loops of all plants by shares of the knobs' ranges, and the pieces of the goals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from workbench.core import Layout, Ode, SampledSystem
from workbench.core.equations import Loop, equations_of
from workbench.core.validation.refusals import Array
from workbench.design.linear_loop import LinearLoop, linear_loop
from workbench.design.structured_tuning import LoopGoal
from workbench.design.structured_tuning.figure_pieces import FigurePiece
from workbench.design.structured_tuning.loop_goals import LoopAnswer, LoopFigureName, loop_pieces
from workbench.design.structured_tuning.loop_jets import LoopJet, LoopJets
from workbench.design.structured_tuning.nonsmooth_search import PieceValues
from workbench.design.structured_tuning.system_jets import SystemJet
from workbench.study.knob import Knob
from workbench.study.loop_tuning.knob_places import KnobPlaces
from workbench.study.loop_tuning.run_goals import RunGoal, RunRows
from workbench.study.specifications import Specification
from workbench.study.specifications.loop_systems import LoopSystems, noise_signals


@dataclass(frozen=True, eq=False)
class TuningGoal:
    """A goal with the range of its figure, which a specification may have given."""

    goal: LoopGoal | RunGoal
    ends: tuple[float, float]
    is_hard: bool
    words: str


def tuning_goals(specification: Specification | None, goals: Sequence[LoopGoal | RunGoal]) -> tuple[TuningGoal, ...]:
    """The limits of a specification and further goals, each with the range of its figure."""
    made = []
    for limit in specification.limits if specification else ():
        goal = LoopGoal(cast(LoopFigureName, limit.kind.name))  # each figure of a specification is one
        made.append(TuningGoal(goal, (limit.low, limit.high), True, limit.words))
    for one in goals:
        ends = one.range if isinstance(one, LoopGoal) else (-np.inf, np.inf)
        made.append(TuningGoal(one, ends, one.limit is not None, one.words))
    if not made:
        raise ValueError("`tune(...)` must have a specification or at least one goal; got neither.")
    return tuple(made)


@dataclass(frozen=True, eq=False)
class TuningProblem:
    """The linear loops of all plants by shares of the knobs' ranges, and the pieces of the goals there."""

    linear: tuple[LinearLoop, ...]
    jets: tuple[LoopJets, ...]
    knobs: KnobPlaces
    goals: tuple[TuningGoal, ...]
    answers: tuple[LoopAnswer, ...]
    rows: tuple[RunRows, ...]
    equations: Ode | SampledSystem

    @staticmethod
    def of(
        loop: Loop | Ode | SampledSystem,
        knobs: tuple[Knob, ...],
        goals: tuple[TuningGoal, ...],
        plants: Sequence[Mapping[str, float]],
        at: str | tuple[str, ...] | None,
        answer: tuple[str | None, str | None],
    ) -> TuningProblem:
        """The problem of a loop at its own plant and at further ones; a loop that has no such search is refused."""
        equations = equations_of(loop, "loop")
        linear = tuple(linear_loop(loop, at, _shaped(equations.parameters, values)) for values in ({}, *plants))
        for one in linear:
            _refuse_loop(one)
        places = [KnobPlaces.of("tune", one, knobs) for one in linear]
        jets = tuple(
            LoopJets(one, own.places, own.factors(one), own.low, own.high)
            for one, own in zip(linear, places, strict=True)
        )
        answers = tuple(_answer_of(one, *answer) for one in linear)
        rows = tuple(
            RunRows.of(places[0], equations, _shaped(equations.parameters, values)) for values in ({}, *plants)
        )
        return TuningProblem(linear, jets, places[0], goals, answers, rows, equations)

    @property
    def has_soft(self) -> bool:
        """True if a goal is soft."""
        return any(not one.is_hard for one in self.goals)

    @property
    def ends(self) -> tuple[Array, Array]:
        """The ends (d,) of the shares."""
        return np.zeros(len(self.knobs.knobs)), np.ones(len(self.knobs.knobs))

    @property
    def models(self) -> tuple[_PlantModel, ...]:
        """The closed loop of each plant, by shares of the ranges."""
        return tuple(_PlantModel(one, self.knobs) for one in self.jets)

    def pieces(self, jets: Sequence[SystemJet], width: float) -> PieceValues:
        """The pieces of all goals at all plants, by shares of the ranges."""
        soft, hard = list[FigurePiece](), list[FigurePiece]()
        for plant, jet in enumerate(jets):
            assert isinstance(jet.origin, _PlantPoint)
            for number, goal in enumerate(self.goals):
                figure = plant * len(self.goals) + number
                made = [replace(one, figure=figure) for one in self._of_goal(goal, plant, jet.origin, width)]
                (hard if goal.is_hard else soft).extend(made)
        return PieceValues(tuple(soft), tuple(hard)) if self.has_soft else PieceValues(tuple(hard))

    def _of_goal(self, goal: TuningGoal, plant: int, at: _PlantPoint, width: float) -> list[FigurePiece]:
        if isinstance(goal.goal, RunGoal):
            return [goal.goal.piece(self.equations, self.rows[plant], at.shares)]
        return loop_pieces(at.loop, goal.goal, goal.ends, self.answers[plant], width)


@dataclass(frozen=True, eq=False)
class _PlantPoint:
    """A loop at shares (d,) of the ranges."""

    loop: LoopJet
    shares: Array


@dataclass(frozen=True, eq=False)
class _PlantModel:
    jets: LoopJets
    knobs: KnobPlaces

    def __call__(self, shares: Array) -> SystemJet:
        numbers = self.knobs.numbers(shares)
        slopes = self.knobs.slopes(numbers)[:, np.newaxis, np.newaxis]
        found = self.jets(numbers)
        closed = replace(found.closed_loop, slopes=slopes * found.closed_loop.slopes)
        opened = None if found.cut_loop is None else replace(found.cut_loop, slopes=slopes * found.cut_loop.slopes)
        jet = replace(found, closed_loop=closed, cut_loop=opened)
        return replace(closed, origin=_PlantPoint(jet, shares))


def _shaped(layout: Layout, values: Mapping[str, float]) -> dict[str, Array]:
    """The values as arrays of the shapes of their parameters, each number of which is the same."""
    return {
        name: np.full(layout[name].shape, value) if name in layout else np.array(value)
        for name, value in values.items()
    }


def _refuse_loop(linear: LinearLoop) -> None:
    if linear.models.delays.any():
        raise ValueError("`tune(loop=...)` needs a loop without delays; replace each by a `PadeDelay`.")
    if linear.models.closed_model.count > 1:
        raise ValueError("`tune(loop=...)` needs a computer with one period; blocks at several periods are not tuned.")
    if linear.corner_signals:
        raise ValueError(
            f"`tune(loop=...)` needs a loop without corners at its rest; '{linear.corner_signals[0]}' has one there."
        )


def _answer_of(linear: LinearLoop, inputs: str | None, outputs: str | None) -> LoopAnswer:
    return LoopAnswer(LoopSystems.of("tune(loop=...)", linear, inputs, outputs).answer, *noise_signals(linear))

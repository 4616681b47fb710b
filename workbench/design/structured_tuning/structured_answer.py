"""The answer of a structured design: its goals with certified values, what stops it, and what is refused."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array
from workbench.design.control_system import System
from workbench.design.matrices import Complex, DesignError
from workbench.design.structured_tuning.design_goals import DesignGoal, GoalValue
from workbench.design.structured_tuning.figure_pieces import FigurePiece
from workbench.design.structured_tuning.multistart import StartResult, StructuredSearch, spread_of
from workbench.design.structured_tuning.nonsmooth_search import PieceValues
from workbench.design.structured_tuning.system_jets import SystemJet

NEAR = 1e-4  # below the largest value, at which a goal counts as active


@dataclass(frozen=True, eq=False)
@show
class StructuredDesign:
    """A design of given structure: its numbers, the closed loops, and the goals with certified values.

    `numbers` (d,) are those that were free. `controller` is the K of u = K y, or None if none was designed. `systems`
    are the closed loops from w to z, one for each plant, and `poles` their poles. `goals` has the worst value of each
    goal over all plants. The `active_goals` stop the search where it is. `stationarity` is the norm of the smallest
    convex combination of the active gradients of log(figure), zero at a local optimum. `starts` are the ends of the
    search from each start. `full_order_gamma` is the H-infinity norm that a controller of full order reaches, the
    largest over the plants. `full_order_note` says why there is none, or what had to be added to the plant.
    """

    numbers: Array
    controller: System | None
    systems: tuple[System, ...]
    goals: tuple[GoalValue, ...]
    active_goals: tuple[str, ...]
    stationarity: float
    starts: tuple[StartResult, ...]
    poles: tuple[Complex, ...]
    full_order_gamma: float | None = None
    full_order_note: str = ""

    @property
    def full_order_ratio(self) -> float:
        """The H-infinity norm over what a controller of full order reaches; NaN where that is not known.

        It may be a little below one, where noise or a weight was added for the full order.
        """
        return self.gamma / self.full_order_gamma if self.full_order_gamma else math.nan

    @property
    def gamma(self) -> float:
        """The upper bound of the largest H-infinity norm among the goals; NaN if there is none."""
        norms = [one.value.high for one in self.goals if one.goal.figure == "hinf"]
        return max(norms, default=math.nan)

    @property
    def spread(self) -> float:
        """The range of the largest soft goal over the starts that keep all limits, as a logarithm; NaN if none does."""
        return spread_of(self.starts)


def goal_pieces(goals: Sequence[DesignGoal], jets: Sequence[SystemJet], width: float) -> PieceValues:
    """The pieces of all goals at all plants; each pair of them is a figure of its own."""
    soft, hard = list[FigurePiece](), list[FigurePiece]()
    for plant, jet in enumerate(jets):
        for number, goal in enumerate(goals):
            made = [replace(one, figure=plant * len(goals) + number) for one in goal.pieces(jet, width)]
            (hard if goal.is_hard else soft).extend(made)
    return PieceValues(tuple(soft), tuple(hard))


def unstable_structure(call: str, result: StructuredSearch) -> DesignError:
    """The refusal of a structure that no start made stable."""
    least = min(one.abscissa for one in result.starts)
    return DesignError(
        f"`{call}(...)` found no stable loop of this structure: from {len(result.starts)} starts the least growth of "
        f"the slowest pole is {least:.4g} 1/s, and it must be negative. Free more numbers, raise the order, or take "
        "more starts."
    )


def limits_in_conflict(call: str, result: StructuredSearch, words: Sequence[str]) -> DesignError:
    """The refusal of limits that no start kept together, with those that stop each other."""
    active = active_figures(result.values.hard, result.least_violation, len(words))
    names = " and ".join(words[number] for number in active)
    excess = 100 * math.expm1(result.least_violation)
    verb, which = ("are", "one of them") if len(active) > 1 else ("is", "it")
    return DesignError(
        f"`{call}(...)` found no point that keeps all limits: {names} {verb} passed by "
        f"{excess:.3g} % at the best of {len(result.starts)} starts. Relax {which}, "
        "free more numbers, or take more starts."
    )


def active_figures(pieces: Sequence[FigurePiece], top: float, count: int) -> list[int]:
    """The numbers of the figures, out of `count` for each plant, that have a piece near the largest value."""
    return sorted({one.figure % count for one in pieces if one.value >= top - NEAR})


def active_words(values: PieceValues, words: Sequence[str]) -> tuple[str, ...]:
    """The goals that stop a search: the soft ones with the largest value, and the limits that are just kept."""
    result = {*active_figures(values.soft, values.objective, len(words)), *active_figures(values.hard, 0.0, len(words))}
    return tuple(words[number] for number in sorted(result))


def structured_answer(
    result: StructuredSearch,
    loops: Sequence[Callable[[Array], SystemJet]],
    goals: Sequence[DesignGoal],
    controller: System | None,
    full_order: tuple[float | None, str],
) -> StructuredDesign:
    """The answer at the end of a search, whose figures and poles are those of the closed loops, computed anew."""
    import control

    systems = []
    for loop in loops:
        jet = loop(result.x)
        systems.append(control.ss(jet.A, jet.B, jet.C, jet.D, jet.period or 0, remove_useless_states=False))
    values = tuple(max((goal.value_of(system) for system in systems), key=lambda one: one.excess) for goal in goals)
    poles = tuple(np.asarray(np.linalg.eigvals(system.A), dtype=complex) for system in systems)
    broken = [one for one in values if one.holds is False]
    if broken:
        raise DesignError(
            f"`structured_controller(...)`: the certified {broken[0].goal.words} fails at {broken[0].value.value:.6g}, "
            "though the search in doubles kept it; balance the plant or choose other units."
        )
    words = [goal.words for goal in goals]
    return StructuredDesign(
        result.x,
        controller,
        tuple(systems),
        values,
        active_words(result.values, words),
        result.stationarity,
        result.starts,
        poles,
        *full_order,
    )

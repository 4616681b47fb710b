"""The design of a controller of given structure by its goals, certified by what does not trust its search."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array, as_array, refusal, several, whole
from workbench.core.validation.refusals import seed as checked_seed
from workbench.core.validation.signatures import check_arguments
from workbench.design.control_system import System
from workbench.design.structured_tuning.controller_structure import ControllerStructure, LoopByController, free_numbers
from workbench.design.structured_tuning.design_goals import DesignGoal
from workbench.design.structured_tuning.multistart import KEPT, SearchProblem, StructuredSearch, random_starts, search
from workbench.design.structured_tuning.parametric_systems import ParametricSystem
from workbench.design.structured_tuning.structured_answer import (
    StructuredDesign,
    goal_pieces,
    limits_in_conflict,
    structured_answer,
    unstable_structure,
)
from workbench.design.structured_tuning.system_jets import SystemJet

if TYPE_CHECKING:
    import control

CALL = "structured_controller(plant, measurements, controls)"
MOST_STARTS = 1000


@check_arguments
def structured_controller(
    plant: control.StateSpace | tuple[control.StateSpace, ...],
    measurements: int,
    controls: int,
    structure: ControllerStructure | None = None,
    goals: tuple[DesignGoal, ...] = (DesignGoal("hinf"),),
    *,
    starts: int = 6,
    seed: int = 0,
    initial: Numbers | None = None,
    largest: float = math.inf,
    full_order_gamma: float | None = None,
) -> StructuredDesign:
    """The controller u = K y of given structure whose closed loop meets some goals best, by a nonsmooth local search.

    Parameters
    ----------
    plant
        A `StateSpace` from (w, u) to (z, y), or several, which one controller serves; the goals are for all of them.
    measurements, controls
        The number of the last outputs y, and of the last inputs u.
    structure
        The order and the fixed numbers of K; by default a static gain.
    goals
        Limits, and soft goals of which the largest over its scale is made small; by default the H-infinity norm.
    starts, seed, initial, largest
        The number of starts; the seed of those behind the first; the free numbers (d,) of the first one, row by row of
        [D C; B A], by default no gain; and the largest size of a free number.
    full_order_gamma
        The norm that a controller of full order reaches, for the answer.

    Raises
    ------
    ValueError, DesignError
        If a plant or a structure does not fit; or no start leads to a stable loop, or to one that keeps all limits.

    References
    ----------
    Apkarian and Noll (2006), IEEE Trans. Autom. Control 51. Burke, Henrion, Lewis and Overton (2006), HIFOO, IFAC
    Symposium on Robust Control Design.

    Examples
    --------
    >>> import control
    >>> plant = control.ss([[0.0, 1.0], [0.0, 0.0]], [[0.0, 0.0], [1.0, 1.0]], [[1.0, 0], [0, 0], [1, 0], [0, 1]],
    ...     [[0.0, 0.0], [0.0, 1.0], [0.0, 0.0], [0.0, 0.0]])
    >>> answer = wb.structured_tuning.structured_controller(plant, 2, 1, starts=1)
    >>> answer.gamma < 2.01
    True
    """
    plants = several(f"{CALL[:-1]}, plant=...)", plant if isinstance(plant, tuple) else (plant,), object, 1)
    structure = structure or ControllerStructure()
    loops = _loops(plants, measurements, controls, structure)
    pattern, free = structure.pattern(measurements, controls)
    first = structure.first(pattern, measurements, controls, initial)
    found = _searched("structured_controller", loops, goals, _bounds(free, largest), first, starts, seed)
    controller = _controller(plants[0], loops[0].controller(found.x), measurements, controls)
    return structured_answer(found, loops, goals, controller, full_order_gamma)


@check_arguments
def tune_systems(
    systems: ParametricSystem | tuple[ParametricSystem, ...],
    goals: tuple[DesignGoal, ...],
    low: Numbers,
    high: Numbers,
    *,
    initial: Numbers | None = None,
    starts: int = 6,
    seed: int = 0,
    full_order_gamma: float | None = None,
) -> StructuredDesign:
    """The numbers between `low` and `high` (d,) at which closed loops, expressions of them, meet some goals best.

    The search is that of `structured_controller`. `initial` (d,) is the first start, by default the middle.

    Raises
    ------
    ValueError
        If the systems have different numbers, or `low` is not below `high`.
    DesignError
        As for `structured_controller`.

    Examples
    --------
    >>> import casadi as ca
    >>> k = ca.SX.sym("k", 1)
    >>> loop = wb.structured_tuning.ParametricSystem(
    ...     k, ca.blockcat([[0, 1], [-1, -k]]), ca.SX([0, 1]), ca.SX([[1, 0]]), ca.SX(0)
    ... )
    >>> fast = wb.structured_tuning.tune_systems(loop, (wb.structured_tuning.DesignGoal("decay"),), [0.1], [10.0])
    >>> fast.numbers.round(3)
    array([2.])
    """
    given = several("tune_systems(systems=...)", systems if isinstance(systems, tuple) else (systems,), object, 1)
    loops = [one for one in given if isinstance(one, ParametricSystem)]
    d = loops[0].size if loops else 0
    if len(loops) < len(given) or any(one.size != d for one in loops):
        raise refusal("tune_systems(systems=...)", "`ParametricSystem`s with as many numbers as the first", systems)
    arrays = [as_array(end) for end in (low, high)]
    ends = [np.zeros(0) if one is None else np.ravel(one) for one in arrays]
    if any(end.shape != (d,) or not np.isfinite(end).all() for end in ends) or not (ends[0] < ends[1]).all():
        raise ValueError(f"`tune_systems(low=..., high=...)` must be {d} finite numbers each, low < high.")
    first = (ends[0] + ends[1]) / 2 if initial is None else free_numbers("tune_systems(initial=...)", initial, d)
    found = _searched("tune_systems", [one.jet for one in loops], goals, (ends[0], ends[1]), first, starts, seed)
    return structured_answer(found, [one.jet for one in loops], goals, None, full_order_gamma)


def _searched(
    call: str,
    loops: Sequence[Callable[[Array], SystemJet]],
    goals: Sequence[DesignGoal],
    bounds: tuple[Array, Array],
    first: Array,
    starts: int,
    seed: int,
) -> StructuredSearch:
    several(f"{call}(goals=...)", goals, DesignGoal, 1)
    problem = SearchProblem(tuple(loops), lambda jets, width: goal_pieces(goals, jets, width), *bounds)
    count = whole(f"{call}(starts=...)", starts, 1, MOST_STARTS, " of starts")
    numbers = random_starts(first, count, checked_seed(f"{call}(seed=...)", seed), *bounds)
    found = search(problem, numbers)
    if not found.stable:
        raise unstable_structure(call, found)
    if found.least_violation > KEPT:
        raise limits_in_conflict(call, found, [goal.words for goal in goals])
    return found


def _bounds(d: int, largest: float) -> tuple[Array, Array]:
    if not largest > 0:
        raise refusal("structured_controller(largest=...)", "above 0", largest)
    return np.full(d, -largest), np.full(d, largest)


def _loops(plants: Sequence[object], ny: int, nu: int, structure: ControllerStructure) -> list[LoopByController]:
    matrices = [_matrices(one, ny, nu) for one in plants]
    pattern, _ = structure.pattern(ny, nu)
    periods = {_period(one) for one in plants}
    if len(periods) > 1:
        raise ValueError("`structured_controller(plant=...)` must have plants of one period; these have several.")
    return [LoopByController.of(one, ny, nu, pattern, *periods) for one in matrices]


def _matrices(plant: object, measurements: int, controls: int) -> tuple[Array, Array, Array, Array]:
    import control

    if not isinstance(plant, control.StateSpace) or plant.dt is True:
        must = "a `StateSpace` of python-control, and its `dt` a number"
        raise refusal("structured_controller(plant=...)", must, plant)
    A, B, C, D = (np.array(M, dtype=float) for M in (plant.A, plant.B, plant.C, plant.D))
    if not all(np.isfinite(M).all() for M in (A, B, C, D)):
        raise ValueError(f"`structured_controller(plant=...)` must have finite numbers; '{plant.name}' has not.")
    for name, count, most in (("measurements", measurements, len(D)), ("controls", controls, D.shape[1])):
        whole(f"structured_controller({name}=...)", count, 1, most - 1, " of the last signals, and w and z need one")
    return A, B, C, D


def _period(plant: object) -> float | None:
    period = getattr(plant, "dt", None)
    return float(period) if period not in (0, None) else None


def _controller(plant: System, K: Array, ny: int, nu: int) -> System:
    import control

    return control.ss(
        K[nu:, ny:],
        K[nu:, :ny],
        K[:nu, ny:],
        K[:nu, :ny],
        plant.dt,
        name=f"controller of {plant.name}",
        inputs=list(plant.output_labels[-ny:]),
        outputs=list(plant.input_labels[-nu:]),
        remove_useless_states=False,
    )

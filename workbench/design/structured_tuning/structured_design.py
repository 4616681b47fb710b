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
from workbench.design.structured_tuning.full_order import full_order_norm
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
from workbench.design.synthesis import GeneralizedPlant
from workbench.design.synthesis.controller_systems import controller_system

if TYPE_CHECKING:
    import control

CALL = "structured_controller(plant, measurements, controls)"
MOST_STARTS = 1000


@check_arguments
def structured_controller(
    plant: control.StateSpace | GeneralizedPlant | tuple[control.StateSpace | GeneralizedPlant, ...],
    measurements: int | None = None,
    controls: int | None = None,
    structure: ControllerStructure | None = None,
    goals: tuple[DesignGoal, ...] = (DesignGoal("hinf"),),
    *,
    starts: int = 6,
    seed: int = 0,
    initial: Numbers | None = None,
    largest: float = math.inf,
    full_order: bool = True,
) -> StructuredDesign:
    """A controller u = K y of given structure for goals of its closed loop, by a nonsmooth local search.

    Parameters
    ----------
    plant
        A `GeneralizedPlant`, or a `StateSpace` from (w, u) to (z, y). Several in a tuple get one controller, and the
        goals are for all. The controller keeps the operating point of the first, if it has one.
    measurements, controls
        How many of the last outputs of a `StateSpace` are y, and how many of its last inputs are u.
    structure
        The order and the fixed numbers of K; by default a static gain.
    goals
        Limits and soft goals; by default a small H-infinity norm.
    starts, seed, initial, largest
        The number of starts; the seed of all but the first; the free numbers (d,) of the first, row by row of
        [D C; B A], by default no gain; and the largest absolute value of a free number.
    full_order
        False to leave out the norm that a controller of full order reaches, which takes up to seconds.

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
    general, structure = [_general(one, measurements, controls) for one in plants], structure or ControllerStructure()
    nu, ny = general[0].sizes[2], general[0].sizes[4]
    pattern, free = structure.pattern(ny, nu)
    loops, first = _loops(general, pattern), structure.first(pattern, ny, nu, initial)
    found = _searched("structured_controller", loops, goals, _bounds(free, largest), first, starts, seed)
    full = full_order_norm(general, goals) if full_order else (None, "it was not asked for")
    return structured_answer(found, loops, goals, _controller(general[0], loops[0].controller(found.x)), full)


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
    """Numbers between `low` and `high` (d,) for goals of closed loops whose matrices are expressions of these numbers.

    The search is that of `structured_controller`.

    Parameters
    ----------
    systems
        One or several closed loops, which depend on the same number d of numbers.
    goals, starts, seed
        As for `structured_controller`.
    low, high
        The ends (d,) of the range of each number.
    initial
        The first start (d,); by default the middle of the ranges.
    full_order_gamma
        An H-infinity norm that a controller of full order reaches, if you know it. It is kept beside the answer, for
        `full_order_ratio`, and has no effect on the search.

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
    full = (full_order_gamma, "" if full_order_gamma else "it was not given")
    return structured_answer(found, [one.jet for one in loops], goals, None, full)


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


def _loops(plants: Sequence[GeneralizedPlant], pattern: Array) -> list[LoopByController]:
    _, _, nu, _, ny = plants[0].sizes
    if any((one.dt, one.sizes[2], one.sizes[4]) != (plants[0].dt, nu, ny) for one in plants):
        raise ValueError(
            "`structured_controller(plant=...)` must have plants of one period, and of as many measurements and "
            "controls; these have several."
        )
    made = []
    for p in (one.parts for one in plants):
        direct = np.block([[p.D11, p.D12], [p.D21, p.D22]])
        matrices = p.A, np.hstack([p.B1, p.B2]), np.vstack([p.C1, p.C2]), direct
        made.append(LoopByController.of(matrices, ny, nu, pattern, plants[0].dt))
    return made


def _general(plant: object, measurements: int | None, controls: int | None) -> GeneralizedPlant:
    """The plant, with its last outputs measured and its last inputs controls if it is a `StateSpace`."""
    import control

    if isinstance(plant, GeneralizedPlant):
        given = {"measurements": (measurements, plant.sizes[4]), "controls": (controls, plant.sizes[2])}
        for name, (count, own) in given.items():
            if count not in (None, own):
                raise refusal(f"structured_controller({name}=...)", f"the {own} of the plant, or left out", count)
        return plant
    if not isinstance(plant, control.StateSpace) or plant.dt is True:
        must = "a `GeneralizedPlant`, or a `StateSpace` of python-control, and its `dt` a number"
        raise refusal("structured_controller(plant=...)", must, plant)
    if not all(np.isfinite(M).all() for M in (plant.A, plant.B, plant.C, plant.D)):
        raise ValueError(f"`structured_controller(plant=...)` must have finite numbers; '{plant.name}' has not.")
    sizes = []
    for name, count, most in (("measurements", measurements, plant.noutputs), ("controls", controls, plant.ninputs)):
        of = " of the last signals, and w and z need one"
        sizes.append(whole(f"structured_controller({name}=...)", count, 1, most - 1, of))
    return GeneralizedPlant.of(plant, *sizes)


def _controller(plant: GeneralizedPlant, K: Array) -> System:
    """The controller [D C; B A] with the names of the plant's signals, about the point of the plant."""
    _, _, nu, _, ny = plant.sizes
    matrices = K[nu:, ny:], K[nu:, :ny], K[:nu, ny:], K[:nu, :ny]
    return controller_system(plant, matrices, "structured controller")

"""`plan`: the trajectory of least cost of a plant or a loop within limits, by collocation or shooting."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Unpack

import numpy as np

from workbench.core import Ode, SampledSystem
from workbench.core.equations import Loop
from workbench.core.validation.refusals import Array, refusal
from workbench.core.validation.signatures import check_arguments
from workbench.planning.trajectories.phase import Cost, NamedNumbers, Phase
from workbench.planning.trajectories.plan_certificate import certify
from workbench.planning.trajectories.plan_names import fixed_values, guess_rows, places_of
from workbench.planning.trajectories.plan_options import OptionsByName, PlanOptions
from workbench.planning.trajectories.plan_problem import Ends, PlanProblem
from workbench.planning.trajectories.plan_search import search
from workbench.planning.trajectories.plan_values import Values
from workbench.planning.trajectories.problem_parts import PlanParts, equation_of
from workbench.planning.trajectories.trajectory_plan import Plan

OF = "states and inputs"


@check_arguments
def plan(
    system: Ode | SampledSystem | Loop,
    until: object = None,
    *,
    cost: Cost = "time",
    end_cost: Callable[..., object] | None = None,
    start: NamedNumbers | None = None,
    end: NamedNumbers | None = None,
    limits: NamedNumbers | None = None,
    rate_limits: NamedNumbers | None = None,
    signals: Mapping[str, Callable[..., object]] | None = None,
    periodic: tuple[str, ...] = (),
    phases: tuple[Phase, ...] = (),
    values: Mapping[str, float] | None = None,
    guess: Plan | Mapping[str, object] | None = None,
    **options: Unpack[OptionsByName],
) -> Plan:
    """The trajectory of least cost of a system within limits, and the inputs that make it; a local optimum.

    Parameters
    ----------
    system, until, cost, end, limits, rate_limits, values
        An `Ode` with inputs, as `wb.open_loop(plant)` is. The others are those of a `Phase`, for all phases.
    end_cost, signals
        A function (t, x) of the end; and, by name, functions (t, x, u) that may have limits or a value at the end.
    start
        States and inputs at the start; by default the system's own initial states. What is not named is free.
    periodic, phases
        States and inputs that end as they start; and parts that follow each other, in the place of `until`.
    guess, options
        An earlier plan, or values at even times by name; and accuracy and search, the fields of `PlanOptions`.

    Raises
    ------
    PlanConflictError
        If nothing meets all limits and values. It is a ValueError, as is that of an argument that does not fit.

    Examples
    --------
    >>> car = wb.OdePlant.of(lambda t, x, u: [x[1], u[0]], states=("x:m", "v:m/s"), inputs=("a:m/s^2",))
    >>> fastest = wb.plan(wb.open_loop(car), (1.0, 100.0), end={"x": 300.0, "v": 0.0}, limits={"a": (-2.0, 1.0)})
    >>> round(fastest.until, 3), fastest.hold
    (30.0, 'zero')
    """
    parts = PlanParts(equation_of(system), cost, limits or {}, rate_limits or {}, signals or {}, values or {})
    chosen = PlanOptions(**options)
    problem = _problem(parts, _phases(until, phases, end or {}), end_cost, start, periodic, chosen)
    return _plan_of(parts, problem, guess, chosen)


def _plan_of(
    parts: PlanParts, problem: PlanProblem, guess: Plan | Mapping[str, object] | None, options: PlanOptions
) -> Plan:
    """The plan of a problem."""
    first, rows = _guess(guess, parts, problem)
    answer = search(problem, options, rows, first)
    return Plan(parts.inputs, answer, certify(answer, options.tolerance, options.objective_tolerance))


def _phases(until: object, phases: tuple[Phase, ...], end: NamedNumbers) -> tuple[Phase, ...]:
    """The phases, the last of which ends as the call says."""
    if phases and until is not None:
        raise ValueError("`plan(until=...)` must be left out where `phases` have durations of their own.")
    if not phases and until is None:
        raise refusal("plan(until=...)", "a duration in s, or the least and the greatest one", until)
    *others, last = phases or (Phase(until),)
    return (*others, replace(last, end={**last.end, **end}))


def _problem(
    parts: PlanParts,
    phases: tuple[Phase, ...],
    end_cost: Callable[..., object] | None,
    start: NamedNumbers | None,
    periodic: tuple[str, ...],
    options: PlanOptions,
) -> PlanProblem:
    ode, layout = parts.ode, parts.moves
    initial = ode.states.unpack(ode.states.default) if start is None else start
    begin = fixed_values("plan(start", initial, layout, OF)
    each = tuple(parts.phase(phase, i) for i, phase in enumerate(phases))
    ode.refuse_beyond("plan(until=...)", sum(phase.duration[1] for phase in each))
    places = tuple(place for name in periodic for place in places_of(name, layout, OF))
    if start is None and places:
        begin = _without(begin, places)
    hold, ends = options.hold, parts.end_cost(end_cost)
    problem = PlanProblem(ode, parts.inputs.labels, each, begin, places, ends, hold, options.method, parts.input_places)
    is_smooth = {"rate_limits": problem.has_slopes, "periodic": any(place >= problem.nx for place in places)}
    for name in (name for name, needed in is_smooth.items() if needed):
        if hold == "zero":
            raise ValueError(f"`plan({name}=...)` needs inputs without jumps; take `hold='linear'` or leave it out.")
        problem = replace(problem, hold="linear")
    return problem


def _without(ends: Ends, places: tuple[int, ...]) -> Ends:
    """Ends without values at some places: what is periodic has no start of its own unless it is named."""
    low, high = ends.low.copy(), ends.high.copy()
    low[list(places)], high[list(places)] = -np.inf, np.inf
    return Ends(low, high)


def _guess(
    guess: Plan | Mapping[str, object] | None, parts: PlanParts, problem: PlanProblem
) -> tuple[Values | None, dict[int, Array]]:
    if isinstance(guess, Plan):
        sizes = [(arc.x.shape[1], arc.u.shape[1]) for arc in guess.values]
        if sizes != [(problem.nx, problem.nu)] * len(problem.phases):
            raise ValueError("`plan(guess=...)` must be a plan with the same states, inputs and number of phases.")
        return guess.values, {}
    return None, guess_rows("plan(guess", guess or {}, parts.moves)

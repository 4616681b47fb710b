"""`plan`: the trajectory of least cost of a plant or a loop within limits, by collocation or shooting."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from workbench.core import Ode, SampledSystem
from workbench.core.equations import Loop
from workbench.core.validation.refusals import Array, one_of, positive, refusal, seed, whole
from workbench.core.validation.signatures import check_arguments
from workbench.planning.trajectories.phase import Cost, NamedNumbers, Phase
from workbench.planning.trajectories.plan_certificate import certify
from workbench.planning.trajectories.plan_names import fixed_values, guess_rows, places_of
from workbench.planning.trajectories.plan_problem import Ends, PlanProblem
from workbench.planning.trajectories.plan_search import SearchOptions, search
from workbench.planning.trajectories.plan_values import Values
from workbench.planning.trajectories.problem_parts import PlanParts, equation_of
from workbench.planning.trajectories.trajectory_plan import Plan

HOLDS = ("automatic", "zero", "linear")
METHODS = ("collocation", "shooting")
LEAST, MOST = 4, 20_000  # intervals


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
    hold: str = "automatic",
    method: str = "collocation",
    intervals: int = 30,
    most_intervals: int = 1000,
    starts: int = 1,
    seed: int = 0,
    tolerance: float = 1e-6,
    objective_tolerance: float = 1e-4,
) -> Plan:
    """The trajectory of least cost of a system within limits, and the inputs that make it:

        minimise  end_cost(T, x(T)) + integral of cost(t, x, u) over [0, T],     x' = f(t, x, u).

    Each interval of a mesh is solved by Radau collocation (order 5) or by Runge-Kutta shooting with IPOPT. Then the
    simulator marches it, and the mesh is cut until it agrees. Every answer is a local optimum.

    Parameters
    ----------
    system
        An `Ode` with inputs, as `wb.open_loop(plant)` and `loop.ode(inputs=True)`.
    until
        The duration in s, or its least and greatest (None for no greatest). With `phases` each has its own.
    cost
        "time", "energy" (the sum of the squares of the inputs), a function (t, x, u) that returns an expression, or an
        expression in the symbols of the `Ode`. x and u are `Signals`, as in a plant's `rate`.
    end_cost
        A function (t, x) of the end.
    start, end
        States and inputs by name at the start and at the end; what is not named is free. Without `start` all states
        start at the system's own initial state.
    limits
        By the name of a state, input, output or signal the least and the greatest value, each a number, an array or
        None.
    rate_limits
        The same for the rates of inputs, per second; the inputs are then straight lines between nodes.
    signals
        Further expressions (t, x, u) by name, to be limited: a distance to an obstacle, say.
    periodic
        States and inputs that end as they start.
    phases
        Parts that follow each other, see `Phase`. The last one ends at `end`, too.
    values
        Parameters of the system at other values.
    guess
        An earlier plan, or values at two or more even times by the names of states and inputs.
    hold
        The inputs between nodes: constant ("zero"), straight lines ("linear"), or "automatic", by the lower objective.
    method
        "collocation" or "shooting".
    intervals, most_intervals
        The intervals of the first mesh of each phase, and the most of the last one.
    starts, seed
        The number of starts of which the best is refined; all but the first are random.
    tolerance
        The largest miss of a node by the march, as a share of the range of each state.
    objective_tolerance
        The largest relative change of the objective by a cut of all intervals.

    Raises
    ------
    PlanConflictError
        If nothing meets all limits and values; it names those that conflict. It is a ValueError.
    ValueError
        If no search ends, or an argument does not fit.
    LookupError
        If a name is unknown.

    References
    ----------
    Betts (2010), Practical Methods for Optimal Control and Estimation Using Nonlinear Programming, chapter 4.
    Kelly (2017), An introduction to trajectory optimization, SIAM Review 59(4), 849-904. Wächter and Biegler (2006), On
    the implementation of an interior-point filter line-search algorithm, Mathematical Programming 106, 25-57.

    Examples
    --------
    >>> car = wb.OdePlant.of(lambda t, x, u: [x[1], u[0]], states=("x:m", "v:m/s"), inputs=("a:m/s^2",))
    >>> fastest = wb.plan(wb.open_loop(car), (1.0, 100.0), end={"x": 300.0, "v": 0.0}, limits={"a": (-2.0, 1.0)})
    >>> round(fastest.until, 3), fastest.hold
    (30.0, 'zero')
    """
    ode = equation_of(system)
    parts = PlanParts(ode, cost, limits or {}, rate_limits or {}, signals or {}, values or {})
    refined = SearchOptions(
        positive("plan(tolerance=...)", tolerance),
        positive("plan(objective_tolerance=...)", objective_tolerance),
        whole("plan(intervals=...)", intervals, LEAST, MOST),
        whole("plan(most_intervals=...)", most_intervals, LEAST, MOST),
        whole("plan(starts=...)", starts),
        _seed(seed),
    )
    problem = _problem(parts, _phases(until, phases), end_cost, start, end or {}, periodic, hold, method)
    first, rows = _guess(guess, parts, problem)
    found = search(problem, refined, rows, first)
    certificate = certify(found, refined.tolerance, refined.objective_tolerance)
    return Plan(parts.inputs, found, certificate)


def _seed(value: int) -> int:
    return seed("plan(seed=...)", value)


def _phases(until: object, phases: tuple[Phase, ...]) -> tuple[Phase, ...]:
    if phases and until is not None:
        raise ValueError("`plan(until=...)` must be left out where `phases` have durations of their own.")
    if not phases and until is None:
        raise refusal("plan(until=...)", "a duration in s, or the least and the greatest one", until)
    return phases or (Phase(until),)


def _problem(
    parts: PlanParts,
    phases: tuple[Phase, ...],
    end_cost: Callable[..., object] | None,
    start: NamedNumbers | None,
    end: NamedNumbers,
    periodic: tuple[str, ...],
    hold: str,
    method: str,
) -> PlanProblem:
    ode, layout = parts.ode, parts.moves
    initial = ode.states.unpack(ode.states.default) if start is None else start
    begin = fixed_values("plan(start", initial, layout, "states and inputs")
    each = [parts.phase(phase, i) for i, phase in enumerate(phases)]
    last = fixed_values("plan(end", end, layout, "states and inputs")
    own = each[-1].end
    for low, high in ((last.low, last.high),):
        named = np.isfinite(low)
        own.low[named], own.high[named] = low[named], high[named]
    places = tuple(place for name in periodic for place in places_of(name, layout, "states and inputs"))
    if start is None and places:
        begin = _without(begin, places)
    problem = PlanProblem(
        ode,
        parts.inputs.labels,
        tuple(each),
        begin,
        places,
        parts.end_cost(end_cost),
        one_of("plan(hold=...)", hold, HOLDS),
        one_of("plan(method=...)", method, METHODS),
        parts.input_places,
    )
    if problem.has_slopes and hold == "zero":
        raise ValueError("`plan(rate_limits=...)` needs inputs without jumps; take `hold='linear'` or leave it out.")
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

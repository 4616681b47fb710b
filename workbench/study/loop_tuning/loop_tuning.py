"""The call that tunes the knobs of a loop for a specification and goals."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from workbench.core import Layout, Ode, SampledSystem
from workbench.core.equations import Loop
from workbench.core.validation.refusals import Array, several, whole
from workbench.core.validation.refusals import seed as checked_seed
from workbench.core.validation.signatures import check_arguments
from workbench.design.linear_loop import LinearLoop
from workbench.design.linear_loop.loop_linearization import linear_loop_about, rest_point
from workbench.design.structured_tuning import LoopGoal
from workbench.design.structured_tuning.loop_jets import LoopJets
from workbench.design.structured_tuning.multistart import KEPT, SearchProblem, StructuredSearch, random_starts, search
from workbench.design.structured_tuning.nonsmooth_search import PieceValues
from workbench.design.structured_tuning.structured_answer import (
    active_figures,
    limits_in_conflict,
    unstable_structure,
)
from workbench.study.knob import Knob
from workbench.study.loop_tuning.knob_places import KnobPlaces, turned_loop
from workbench.study.loop_tuning.run_goals import RunGoal
from workbench.study.loop_tuning.tuned_figures import certified_goals
from workbench.study.loop_tuning.tuned_loop import EDGE, TunedLoop
from workbench.study.loop_tuning.tuning_problem import TuningProblem, tuning_goals
from workbench.study.specifications import Specification, SpecificationVerdicts

MOST_STARTS = 1000


@check_arguments
def tune(
    loop: Loop | Ode | SampledSystem,
    knobs: tuple[Knob, ...],
    specification: Specification | None = None,
    goals: tuple[LoopGoal | RunGoal, ...] = (),
    *,
    plants: tuple[Mapping[str, float], ...] = (),
    at: str | tuple[str, ...] | None = None,
    inputs: str | None = None,
    outputs: str | None = None,
    starts: int = 4,
    seed: int = 0,
    full_order_gamma: float | None = None,
) -> TunedLoop:
    """The knobs of a loop tuned for limits and goals, for several plants at once, by a nonsmooth local search.

    The limits of the specification and of the goals are hard. Goals without a limit are soft: each is divided by its
    scale, and the largest quotient is made small. Without a soft goal the limits are kept with as much room as
    possible. Gradients are exact in continuous time; those of a `DigitalLoop`, of steps and of runs are differences.

    Parameters
    ----------
    loop
        A `ClosedLoop` or a `DigitalLoop` of one period, without delays.
    knobs
        The numbers to tune, each within its range; `log` searches the logarithm.
    specification, goals
        Limits of the linear loop, and further limits and soft goals of the linear loop or of runs of the nonlinear one.
    plants
        Values of parameters by name, one mapping for each plant beside the nominal one: corners, or draws of a sweep.
    at, inputs, outputs
        The cut, as for `linear_loop`, and the signals of bandwidth and step, as for `Specification.check`.
    starts, seed
        The number of starts, the first of which is the loop as it was given, and the seed of the others.
    full_order_gamma
        An H-infinity norm that a controller of full order reaches, if you know it. It is kept beside the answer and has
        no effect on the search.

    Raises
    ------
    ValueError, LookupError
        If there is no knob or no goal, a knob moves nothing, or a name is wrong.
    DesignError
        If no start leads to a stable loop, or to one that keeps all limits: those in conflict are named.

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0)
    >>> loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    >>> knobs = (wb.Knob("Kp", "controller.Kp", 1.0, 1e3, log=True), wb.Knob("Ki", "controller.Ki", 1.0, 1e4, log=True))
    >>> goal = wb.structured_tuning.LoopGoal("gain", inputs=("v_load",), outputs=("omega",))
    >>> tuned = wb.tune(loop, knobs, wb.Specification(Ms=1.4), (goal,), starts=1)
    >>> tuned.holds, tuned.active_goals[0]
    (True, 'Ms <= 1.4')
    """
    several("tune(knobs=...)", knobs, Knob, 1)
    problem = TuningProblem.of(loop, knobs, tuning_goals(specification, goals), plants, at, (inputs, outputs))
    result = _searched(problem, starts, seed)
    return _tuned(loop, problem, specification, result, full_order_gamma)


def _searched(problem: TuningProblem, starts: int, seed: int) -> StructuredSearch:
    """The end of the search, if it is stable and keeps all limits."""
    count, ends = whole("tune(starts=...)", starts, 1, MOST_STARTS, " of starts"), problem.ends
    shares = problem.knobs.shares(problem.knobs.first)
    first = random_starts(shares, count, checked_seed("tune(seed=...)", seed), *ends)
    result = search(SearchProblem(problem.models, problem.pieces, *ends), first)
    words = [one.words for one in problem.goals]
    if not result.stable:
        raise unstable_structure("tune", result)
    if result.least_violation > KEPT and problem.has_soft:
        raise limits_in_conflict("tune", result, words)
    if result.values.objective > KEPT and not problem.has_soft:
        raise limits_in_conflict("tune", _as_limits(result), words)
    return result


def _as_limits(result: StructuredSearch) -> StructuredSearch:
    """The result of a search over limits alone, whose pieces were those of the objective."""
    values = PieceValues((), result.values.soft)
    return replace(result, values=values, least_violation=values.violation)


def _tuned(
    loop: Loop | Ode | SampledSystem,
    problem: TuningProblem,
    specification: Specification | None,
    result: StructuredSearch,
    full_order_gamma: float | None,
) -> TunedLoop:
    numbers = problem.knobs.numbers(result.x)
    linear = tuple(
        _linear_at(one, problem.knobs, jets, numbers) for one, jets in zip(problem.linear, problem.jets, strict=True)
    )
    verdicts: tuple[SpecificationVerdicts, ...] = ()
    if specification is not None:
        pairs = [one.answer or (None, None) for one in problem.answers]
        verdicts = tuple(
            specification.check(one, inputs=pair[0], outputs=pair[1]) for one, pair in zip(linear, pairs, strict=True)
        )
    values, count = result.values, len(problem.goals)
    active = {*active_figures(values.soft, values.objective, count), *active_figures(values.hard, 0.0, count)}
    goals = certified_goals(problem.goals, linear, problem.answers, values, active)
    equations = _with_defaults(problem.equations, problem.rows[0].parameters(result.x[np.newaxis])[0])
    layout = equations.parameters
    fields = {
        name: layout[name].default
        for places in problem.rows[0].places
        for name in {entry.name for entry in layout.entries if set(layout.indices(entry.name)) & set(places)}
    }
    edge = tuple(
        knob.name for knob, share in zip(problem.knobs.knobs, result.x, strict=True) if not EDGE < share < 1 - EDGE
    )
    new = turned_loop(loop, fields)
    ends = (result.stationarity, result.starts, edge, full_order_gamma)
    return TunedLoop(problem.knobs.values(numbers), new, equations, linear, verdicts, goals, *ends)


def _linear_at(linear: LinearLoop, knobs: KnobPlaces, jets: LoopJets, numbers: Array) -> LinearLoop:
    """The linear loop at the numbers, made anew by the call that everything else is held against."""
    point, layout = linear.point, linear.parameters
    p = jets.parameters(numbers)
    values = {name: value[0] for name, value in layout.unpack(p[np.newaxis]).items()}
    return linear_loop_about(
        rest_point(point.equations, point.instant, values, point.at_rest, point.side, point.substeps)
    )


def _with_defaults(equations: Ode | SampledSystem, p: Array) -> Ode | SampledSystem:
    """The equations with other parameters as defaults."""
    flow = equations.flow if isinstance(equations, SampledSystem) else equations
    values = flow.parameters.unpack(p)
    entries = tuple(replace(entry, default=values[entry.name]) for entry in flow.parameters.entries)
    flow = replace(flow, parameters=Layout(entries))
    return replace(equations, flow=flow) if isinstance(equations, SampledSystem) else flow

"""One run by variable steps, every switching instant located, with its own error estimate."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from workbench.core import Layout, Ode
from workbench.core.validation.permission import refuse_in_pages
from workbench.core.validation.refusals import Array, as_array, error_text, one_of, refusal, vector, whole
from workbench.core.validation.signatures import check_arguments
from workbench.engine.reference.continuation import Modes
from workbench.engine.reference.smooth_pieces import Numeric
from workbench.engine.reference.surfaces import SwitchedRate
from workbench.engine.reference.switched_run import Event, SwitchedRun, follow
from workbench.engine.reference.variable_step import Effort, Flow, IntegrationError, SolverOptions, travel

METHODS = ("auto", "explicit", "implicit")
TIGHTEST = 3e-13  # what double precision resolves, with room for a tighter run
TIGHTER = 0.01
ROUNDING = 3e-14  # the smallest relative tolerance of any run
MOST_STEPS = 200_000
ESCAPE_RATIO = 1e6  # a state this many times larger than it began, where no step is short enough, escapes


@dataclass(frozen=True, eq=False)
@check_arguments
class ReferenceSolution:
    """One solution at N times, and its certificate.

    `x` is from a run at a hundredth of the tolerances, and `error` how far the run at the tolerances is from it: above
    the error of x itself, as long as errors fall with the tolerance.
    """

    t: Array  # (N,) in s
    x: Array  # (N, nx)
    error: Array  # (N, nx)
    events: tuple[Event, ...]
    event_error: float  # s, the largest change of an event's time between the runs; NaN if they met different events
    sliding_spans: tuple[
        tuple[float, float, tuple[str, ...]], ...
    ]  # begin, end and surfaces of sliding, as Filippov defines it
    steps: int  # of the tighter run
    evaluations: int
    method: str  # "explicit" (Dormand and Prince, order 8) or "implicit" (Radau IIA, order 5)


@check_arguments
def reference_run(
    ode: Ode,
    p: Array | None = None,
    x0: Array | None = None,
    *,
    times: Array | Sequence[float],
    rtol: float = 1e-10,
    atol: float | Array = 1e-12,
    method: str = "auto",
    max_steps: int = MOST_STEPS,
) -> ReferenceSolution:
    """An accurate solution of x' = f(t, x, p) from time 0, to compare simulations with.

    The solution is smooth piece by piece. The arguments of sign, fabs, fmin, fmax, floor, ceil, comparisons and if_else
    are switching functions. No step crosses a zero of a switching function: the zero is located to rounding, and the
    solution continues from there, across the surface or along it (Filippov; Utkin's equivalent control). Two motions
    are refused: twisting whose switchings accumulate, and x' = -sqrt|x| sign x from the time on at which x is zero.

    Parameters
    ----------
    p, x0
        Parameters (np,) and initial state (nx,); by default those of the `Ode`.
    times
        The times (N,) in s at which the solution is returned, increasing, from 0 on.
    rtol, atol
        Relative and absolute tolerances of a first run. The returned run has tolerances a hundred times smaller, and
        the difference of both runs is the error of the first.
    method
        "explicit", "implicit" with the exact Jacobian, or "auto". "auto" turns to implicit if stability, not
        accuracy, limits the steps and thousands more would be needed.
    max_steps
        The largest number of steps.

    Raises
    ------
    ValueError
        If an argument is not as above; if the rate switches by an operation that has no surface, or is not finite; if
        the solution escapes, is not unique, cannot continue from a surface, switches infinitely often with no sliding
        motion after it, or needs too many steps. The message names the time reached.

    References
    ----------
    Filippov (1988), Differential Equations with Discontinuous Righthand Sides, section 4; Utkin (1992), Sliding Modes
    in Control and Optimization, chapter 2; Hairer, Norsett and Wanner (1993), section II.10.

    Examples
    --------
    >>> drop = wb.open_loop(wb.StirredTank())
    >>> wb.reference_run(drop, times=[1.0]).x.shape
    (1, 2)
    """
    start, when = _values("x0", x0, ode.states), _times("reference", times)
    ode.refuse_beyond("reference(times=...)", float(when[-1]))
    rule = _rule("reference", rtol, atol, method, max_steps, ode.states.size)
    run = _switched_run(ode, _values("p", p, ode.parameters), start, when)
    return _certified_solution("reference(ode=...)", ode.states.labels, when, start, rule, run)


def _switched_run(ode: Ode, p: Array, start: Array, when: Array) -> Callable[[SolverOptions], SwitchedRun]:
    """The run of an `Ode` by a rule; its pieces are made once for all rules."""
    modes = Modes(SwitchedRate.of(ode, p))
    rate = Numeric(ca.Function("rate", [ode.t, ode.x], [ca.substitute(ode.rate, ode.p, p)], {"cse": True}))

    def valid(t: float, x: Array) -> bool:
        return bool(np.isfinite(rate(t, x)).all())

    def run(rule: SolverOptions) -> SwitchedRun:
        if not valid(0.0, start):
            raise IntegrationError(0.0, start, "rate")
        return follow(modes, valid, start, when, rule)

    return run


@check_arguments
def reference_of_function(
    f: Callable[[float, Array], object],
    x0: Array | Sequence[float],
    *,
    times: Array | Sequence[float],
    rtol: float = 1e-10,
    atol: float | Array = 1e-12,
    method: str = "auto",
    max_steps: int = MOST_STEPS,
) -> ReferenceSolution:
    """The solution of x' = f(t, x) from time 0 for a smooth Python function f that is only evaluated.

    As `reference`, without surfaces; "auto" is explicit, and the Jacobian of "implicit" a difference.

    Raises
    ------
    ValueError
        If an argument is not as it must be, f raises, or the solution escapes, is not finite, or needs too many steps.

    Examples
    --------
    >>> from workbench.engine.reference import reference_of_function
    >>> reference_of_function(lambda t, x: -x, [1.0, 2.0], times=[0.0, 1.0]).x[-1].round(6)
    array([0.367879, 0.735759])
    """
    name, call = "reference_of_function", "reference_of_function(f=...)"
    start = vector(f"{name}(x0=...)", x0, max(np.size(x0), 1), "states")
    when, rule = _times(name, times), _rule(name, rtol, atol, method, max_steps, len(start))

    def field(t: float, x: Array) -> Array:
        try:
            given = f(t, x)
            rate = given if type(given) is np.ndarray and given.dtype == np.float64 else as_array(given)
        except Exception as error:  # whatever a foreign function raises
            raise IntegrationError(t, x, f"the function raised {error_text(error)}") from error
        if rate is None or rate.size != len(start):
            raise refusal(call, f"a function that gives a rate for each of the {len(start)} states", given)
        return rate.ravel()

    flow = Flow(len(start), field, None, lambda t, x: True)

    def run(rule: SolverOptions) -> SwitchedRun:
        effort = Effort()
        begun = [start] if when[0] == 0 else []
        ahead = when[len(begun) :]
        if len(ahead) == 0:
            return SwitchedRun(np.array(begun), (), (), effort)
        leg = travel(flow, 0.0, start, when[-1], ahead, rule, effort)
        if leg.is_stalled:
            raise IntegrationError(leg.t, leg.x, "step")
        return SwitchedRun(np.array([*begun, *leg.states]), (), (), effort)

    return _certified_solution(call, [f"x[{i}]" for i in range(len(start))], when, start, rule, run)


def _certified_solution(
    call: str,
    labels: Sequence[str],
    times: Array,
    start: Array,
    rule: SolverOptions,
    run: Callable[[SolverOptions], SwitchedRun],
) -> ReferenceSolution:
    """The run at a hundredth of the tolerances, and how far it is from the one at the tolerances."""
    refuse_in_pages(call)
    finer = replace(rule, rtol=max(TIGHTER * rule.rtol, ROUNDING), atol=TIGHTER * rule.atol)
    with np.errstate(all="ignore"):
        try:
            coarse, fine = run(rule), run(finer)
        except IntegrationError as stopped:
            raise ValueError(f"`{call}` {_explanation(stopped, labels, start, rule)}") from stopped.__cause__
    same = [(e.what, e.surface) for e in coarse.events] == [(e.what, e.surface) for e in fine.events]
    moved = [abs(a.t - b.t) for a, b in zip(coarse.events, fine.events, strict=False)]
    return ReferenceSolution(
        times,
        fine.states,
        np.abs(fine.states - coarse.states),
        fine.events,
        max(moved, default=0.0) if same else np.nan,
        fine.sliding_spans,
        fine.effort.steps,
        fine.effort.evaluations,
        "implicit" if fine.effort.implicit else "explicit",
    )


def _explanation(error: IntegrationError, labels: Sequence[str], start: Array, rule: SolverOptions) -> str:
    at = f"stops at t = {error.t:.12g} s"
    worst = int(np.argmax(np.abs(error.x)))
    size = f"'{labels[worst]}' = {error.x[worst]:g}"
    if error.why == "steps":
        return f"{at}, after {rule.most} steps: allow more with `max_steps`, or looser tolerances."
    if error.why not in ("rate", "state", "step"):
        return f"{at}, where {error.why}."
    if np.abs(error.x).max() > ESCAPE_RATIO * (1 + np.abs(start).max()):
        return f"{at}, where the solution grows without bound ({size}): a finite escape. Ask for earlier times."
    if error.why == "rate":
        return f"{at}, where the rate is not finite, at a state with {size}."
    return f"{at}, where no step is short enough, at a state with {size}: the rate is singular there, or jumps unseen."


def _values(name: str, values: Array | None, layout: Layout) -> Array:
    what = "parameters" if name == "p" else "states"
    value = layout.default if values is None else vector(f"reference({name}=...)", values, layout.size, what)
    layout.check(value[np.newaxis])
    return value


def _times(call: str, times: Array | Sequence[float]) -> Array:
    when = np.atleast_1d(np.array(times))
    if when.ndim != 1 or len(when) == 0 or not np.isfinite(when).all() or when[0] < 0 or (when[1:] <= when[:-1]).any():
        raise refusal(f"{call}(times=...)", "finite numbers of seconds that increase, from 0 on", when.tolist())
    return when


def _rule(call: str, rtol: float, atol: float | Array, method: str, most: int, states: int) -> SolverOptions:
    if not TIGHTEST <= rtol < 1:
        must = f"a number from {TIGHTEST:g}, which double precision resolves, to below 1"
        raise refusal(f"{call}(rtol=...)", must, rtol)
    floor = vector(f"{call}(atol=...)", np.full(states, atol) if np.ndim(atol) == 0 else atol, states, "states")
    if not (np.isfinite(floor) & (floor > 0)).all():
        raise refusal(f"{call}(atol=...)", "positive and finite", atol)
    return SolverOptions(
        rtol, floor, one_of(f"{call}(method=...)", method, METHODS), whole(f"{call}(max_steps=...)", most)
    )

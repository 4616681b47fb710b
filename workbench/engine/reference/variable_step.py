"""Variable steps along one smooth piece, up to the instant at which one of its guards ends it: event location."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import DOP853, OdeSolver, Radau

from workbench.core.methods import runge_kutta
from workbench.core.validation.refusals import Array
from workbench.engine.reference.smooth_pieces import SAMPLES, Guard, SmoothPiece

STIFF = 3.0  # h |lambda| beyond which stability, not accuracy, bounds an explicit step; it ends at about 6
WORTH = 5_000  # explicit steps still to take, from which on the implicit method is worth its price
COMPANION_TOLERANCE = 1e-3  # how closely a step follows the companions
LOOK = 25  # steps between two looks at stiffness
SHORTEST = 16 * float(np.finfo(float).eps)  # a step of this share of the horizon is an instant

Flags = NDArray[np.bool_]
Solver: TypeAlias = "OdeSolver[np.float64]"
# with a tolerance for each number, of which the stubs do not know
EXPLICIT: Callable[..., Solver] = DOP853
RADAU: Callable[..., Solver] = Radau


@dataclass(frozen=True, eq=False)
class SolverOptions:
    """The tolerances, the method ("auto", "explicit", "implicit"), and the largest number of steps."""

    rtol: float
    atol: Array
    method: str
    most: int


class Effort:
    """The cost of a run so far."""

    def __init__(self) -> None:
        self.steps = 0
        self.evaluations = 0
        self.implicit = False


@dataclass(frozen=True, eq=False)
class Flow:
    """A smooth differential equation as numbers: y' = field(t, y), where y begins with the nx states.

    `valid` is true where the equation as written has a finite rate at (t, x); `companions` gives the values and
    rates (nz, 2) of what is integrated beside the state; `piece` holds the guards.
    """

    nx: int
    field: Callable[[float, Array], Array]
    jacobian: Callable[[float, Array], Array] | None
    valid: Callable[[float, Array], bool]
    companions: Callable[[float, Array], Array] = lambda t, x: np.zeros((0, 2))
    piece: SmoothPiece | None = None

    @staticmethod
    def of(piece: SmoothPiece, valid: Callable[[float, Array], bool]) -> Flow:
        """The flow of a piece, its companions beside the state."""
        field, nx = piece.field, piece.x.numel()
        return Flow(nx, lambda t, y: field(t, y).ravel(), piece.jacobian, valid, piece.companions, piece)


@dataclass(frozen=True, eq=False)
class Leg:
    """The solution along one piece: its end, the guard that ended it, and the states (k, nx) at the times on it.

    It is `is_stalled` where no step is short enough to go on.
    """

    t: float
    x: Array
    guard: Guard | None
    slope: float
    states: Array
    is_stalled: bool = False


class IntegrationError(Exception):
    """The error of a solution that does not continue numerically beyond (t, x)."""

    def __init__(self, t: float, x: Array, why: str) -> None:
        self.t, self.x, self.why = t, x, why


def travel(flow: Flow, t: float, x: Array, end: float, times: Array, rule: SolverOptions, effort: Effort) -> Leg:
    """Follow the flow from (t, x) to `end` or to the first guard, and keep the states at `times` within (t, end]."""
    solver = _solver(flow, t, x, end, rule, effort)
    armed, kept = armed_at(flow.piece, t, x), list[Array]()
    while solver.status == "running":
        begin, y = solver.t, solver.y
        if not _step(flow, solver, rule, effort):
            return Leg(float(begin), _project(flow, begin, y[: flow.nx]), None, 0.0, _rows(kept, flow.nx), True)
        met = find_guard_hit(flow, solver, begin, armed)
        if met.again:
            solver = _solver(flow, begin, y[: flow.nx], end, rule, effort, (solver.t - begin) / SAMPLES)
            continue
        armed, here = met.armed_guards, (solver.t, solver.y[: flow.nx])
        if met.crossing and flow.piece:
            at, place = met.crossing
            here = polish_crossing(flow.piece, *_within(flow, begin, y, at, rule, effort), place)
        x = _project(flow, *here)
        while len(kept) < len(times) and times[len(kept)] <= here[0]:
            at = times[len(kept)]
            kept.append(x if at == here[0] else _project(flow, *_within(flow, begin, y, at, rule, effort)))
        if met.crossing and flow.piece:
            slope = float(flow.piece.watch(here[0], x)[place, 2])
            return Leg(float(here[0]), x, flow.piece.guards[place], slope, _rows(kept, flow.nx))
        solver = _kept_up(flow, solver, x, end, rule, effort)
    return Leg(float(solver.t), _project(flow, solver.t, solver.y[: flow.nx]), None, 0.0, _rows(kept, flow.nx))


def _rows(states: list[Array], nx: int) -> Array:
    return np.array(states).reshape(len(states), nx)


def _solver(
    flow: Flow, t: float, x: Array, end: float, rule: SolverOptions, effort: Effort, first: float | None = None
) -> Solver:
    def field(t: float, y: Array) -> Array:
        effort.evaluations += 1
        return flow.field(t, y)

    beside = flow.companions(t, x)
    y = np.concatenate([x, beside[:, 0]])
    if not (np.isfinite(y).all() and np.isfinite(field(t, y)).all()):
        raise IntegrationError(t, x, "rate")
    floor = COMPANION_TOLERANCE * np.maximum(
        np.abs(beside[:, 0]), COMPANION_TOLERANCE * (end - t) * np.abs(beside[:, 1])
    )
    atol = np.concatenate([rule.atol, np.maximum(floor, rule.atol.min())])
    first = None if first is None else min(first, end - t)
    if effort.implicit or rule.method == "implicit":
        effort.implicit = True
        return RADAU(field, t, y, end, jac=flow.jacobian, rtol=rule.rtol, atol=atol, first_step=first)
    rtol = np.concatenate([np.full(flow.nx, rule.rtol), np.full(len(beside), COMPANION_TOLERANCE)])
    return EXPLICIT(field, t, y, end, rtol=rtol, atol=atol, first_step=first)


def _step(flow: Flow, solver: Solver, rule: SolverOptions, effort: Effort) -> bool:
    """One accepted step, or none (False) if it would be shorter than rounding."""
    begin, y = solver.t, solver.y[: flow.nx]
    try:
        solver.step()
    except (ValueError, np.linalg.LinAlgError):  # a Jacobian that is not finite
        return False
    effort.steps += 1
    if solver.status == "failed":
        return False
    if not np.isfinite(solver.y).all():
        raise IntegrationError(begin, y, "state")
    if effort.steps > rule.most:
        raise IntegrationError(begin, y, "steps")
    return True


def _within(flow: Flow, t: float, y: Array, to: float, rule: SolverOptions, effort: Effort) -> tuple[float, Array]:
    """The state at an instant within an accepted step that began at (t, y): integrated, not interpolated."""
    if to <= t:
        return t, y[: flow.nx]
    solver = _solver(flow, t, y[: flow.nx], to, rule, effort, to - t)
    while solver.status == "running":
        if not _step(flow, solver, rule, effort):
            raise IntegrationError(solver.t, solver.y[: flow.nx], "step")
    return solver.t, solver.y[: flow.nx]


def _kept_up(flow: Flow, solver: Solver, x: Array, end: float, rule: SolverOptions, effort: Effort) -> Solver:
    """The solver for the next step: projected to its surfaces, with the cheaper method, from a valid state."""
    t, h = solver.t, solver.step_size
    assert h is not None  # after a step
    if not flow.valid(t, x):
        raise IntegrationError(t, x, "rate")
    if rule.method == "auto" and not effort.implicit and effort.steps % LOOK == 0 and flow.jacobian is not None:
        A = flow.jacobian(t, solver.y)
        fastest = -np.linalg.eigvals(A).real.min() if np.isfinite(A).all() else 0.0
        effort.implicit = bool(h * fastest > STIFF and (end - t) / h > WORTH)
        if effort.implicit and t < end:
            return _solver(flow, t, x, end, rule, effort)
    drift = np.abs(x - solver.y[: flow.nx])
    if t < end and (drift > 0.1 * (rule.atol + rule.rtol * np.abs(x))).any():
        return _solver(flow, t, x, end, rule, effort, h)
    return solver


def _project(flow: Flow, t: float, x: Array) -> Array:
    """The nearest state on the surfaces in sliding."""
    if flow.piece is None or not flow.piece.mode.sliding_surfaces:
        return x
    for _ in range(2):
        held = flow.piece.hold(t, x)
        x = x - np.linalg.pinv(held[:, 1:-1]) @ held[:, 0]
    return x


class GuardHit(NamedTuple):
    """The guard that a step has met, and when; `again` if the step must be shortened; and the guards armed now.

    The instant has the accuracy of the step's interpolant. A guard that is within rounding of its end has just been
    passed, and is armed once it is clear of it.
    """

    crossing: tuple[float, int] | None
    again: bool
    armed_guards: Flags


def armed_at(piece: SmoothPiece | None, t: float, x: Array) -> Flags:
    """True for each guard that is above its rounding, and so can be crossed."""
    if piece is None or not piece.guards:
        return np.zeros(0, dtype=bool)
    g = piece.watch(t, x)
    return np.asarray(g[:, 0] > np.nan_to_num(g[:, 1], posinf=0.0))


def find_guard_hit(flow: Flow, solver: Solver, begin: float, armed_guards: Flags) -> GuardHit:
    """The first guard that the solver's last step, from `begin` on, has met."""
    piece, end = flow.piece, solver.t
    if piece is None or len(armed_guards) == 0:
        return GuardHit(None, False, armed_guards)
    interpolant = solver.dense_output()

    def between(at: float | Array) -> Array:
        return np.asarray(interpolant(at)[: flow.nx])

    at = np.linspace(begin, end, SAMPLES + 1)
    states = between(at)
    rows = piece.samples(at[1:], states[:, 1:]).reshape(len(armed_guards), SAMPLES, 4)
    rows = np.concatenate([piece.watch(begin, states[:, 0])[:, np.newaxis], rows], axis=1)
    found, after = [], armed_guards.copy()
    for j in range(len(armed_guards)):
        g, noise, slope = rows[j, :, 0], np.nan_to_num(rows[j, :, 1], posinf=0.0), rows[j, :, 2]
        first = 1
        while not after[j] and first <= SAMPLES:
            if g[first] < -noise[first]:  # it left its end and came back within the step, or went the wrong way
                if end - begin > SHORTEST * solver.t_bound:
                    return GuardHit(None, True, armed_guards)
                return GuardHit((begin, j), False, armed_guards)
            after[j] = g[first] > noise[first]
            first += 1
        if after[j] and (t := _first_zero(piece, j, at, g, slope, noise, first, between)) is not None:
            found.append((t, j))
    return GuardHit(min(found, default=None), False, after)


def _first_zero(
    piece: SmoothPiece,
    j: int,
    at: Array,
    g: Array,
    slope: Array,
    noise: Array,
    first: int,
    between: Callable[[float | Array], Array],
) -> float | None:
    """The first zero of a guard behind sample `first` - 1, also one of two that lie between two samples."""
    from scipy.optimize import brentq  # here, as it takes long to import

    def value(t: float, column: int = 0) -> float:
        return float(piece.watch(t, between(t))[j, column])

    for i in range(first, len(at)):
        low, last = g[i], at[i]
        dips = slope[i - 1] < 0 < slope[i] and value(at[i - 1], 2) < 0 < value(at[i], 2)  # one by one as side by side
        if g[i - 1] > 0 and g[i] > 0 and dips:
            last = brentq(value, at[i - 1], at[i], args=(2,))  # the lowest point of a dip
            low = value(last)
            if low >= -noise[i]:
                continue
        if low <= 0:
            inside = value(at[i - 1]) > 0 > value(last)
            return float(brentq(value, at[i - 1], last, xtol=1e-300)) if inside else float(at[i - 1])
    return None


def polish_crossing(piece: SmoothPiece, t: float, x: Array, index: int) -> tuple[float, Array]:
    """The instant and state moved onto the end of a guard, to rounding: Newton in time, each move one step of RK4."""
    reach = np.inf
    for _ in range(10):
        g, noise, slope, _ = piece.watch(t, x)[index]
        if abs(g) <= noise / 8 or slope == 0 or not np.isfinite(slope):
            break
        h = float(-g / slope)
        if not abs(h) < reach or t + h == t:
            break
        reach = abs(h)
        y = piece.with_companions(t, x)
        t, x = t + h, runge_kutta(lambda t, y, _: piece.field(t, y).ravel(), t, y, None, h)[: len(x)]
    return t, x

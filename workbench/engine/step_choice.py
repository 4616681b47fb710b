"""The choice of a step for a tolerance: pilot runs at a few steps, an error model between them, and a last check."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import lru_cache
from math import ceil, inf, isfinite, isnan, log, nan
from typing import NamedTuple

import numpy as np

from workbench.core import Ode, SampledSystem, StepMap
from workbench.core.methods import METHODS, RESTARTED_METHOD, RK4, STABILISED_METHOD, Method
from workbench.core.state_corners import corners_of
from workbench.core.switches import DENSEST
from workbench.core.validation.refusals import Array, one_of
from workbench.core.validation.signatures import check_arguments
from workbench.engine.batch import run_step
from workbench.engine.stability import longest_steps, modes_at
from workbench.engine.trajectories import Trajectories

COUNT = 100  # of the longest steps that are tried, in a horizon, or about that many
LOOKS = 20  # common times of all pilot runs in a horizon, or more
DOUBLINGS, SUBSTEPS = 12, 7  # of the number of steps; of substeps of a period, all of which are written out
AIM = 0.7  # of the tolerance, at which the error model aims
MARGIN = 0.9  # of the longest stable step that was found, as a run is looked at in a few states only
STATES = 6  # of a run at which its modes are looked at
GAIN = 1.1  # in the length of the step, that stability alone takes
LEAST_FALL = 0.4  # of the error to a quarter of the step, where restarts restore the order of the method
GROWTH = 1.25  # of the number of steps, where a trial fails
FAST = 16  # times the largest number of steps, which a mode may need that decays too fast for all steps before

# (h, method) -> the step of length h [s], or that of a sampling period with substeps of length h.
Make = Callable[[float, str], StepMap]
# (fine, coarse) -> the largest relative error of the coarse runs, and of what, in words; NaN where none stays finite.
Errors = Callable[[Trajectories, Trajectories], tuple[float, str]]


@dataclass(frozen=True)
@check_arguments
class StepChoice:
    """A step that pilot runs chose for a tolerance: every number of every pilot run keeps the tolerance there.

    The error of a metric is 2 |v(h) - v(h / 2)| relative to |v(h)|. If no metric is asked for, it is the change
    |x(h) - x(h / 2)| of a state, relative to its largest value in the run.
    """

    h: float  # s; of a sampled loop the substep
    method: str  # "rk4", "stabilised" or "restarted", as `runge_kutta_step` takes it
    tolerance: float
    error: float  # the largest in the pilot runs at h
    of: str  # what has it: a metric, or a state
    order: float  # with which the error fell near h; NaN where it was kept at once
    limit: float  # s, the longest stable step at some states of the pilot runs; infinite where nothing decays
    pilots: int  # number of the pilot runs

    def __post_init__(self) -> None:
        one_of("StepChoice(method=...)", self.method, METHODS)

    def __str__(self) -> str:
        chosen = f"chosen by {self.pilots} pilot runs for a tolerance of {self.tolerance:g}"
        return f"step of {self.h:.3g} s{self.by}, {chosen}: {self.of} has an error of {self.error:.1e}"

    @property
    def by(self) -> str:
        """The words that name the method after a step; empty for the classical method."""
        return "" if self.method == RK4.name else f" by {METHODS[self.method].about}"

    @property
    def record(self) -> str:
        """The choice as one line of text, from which `read` restores it bit by bit."""
        return json.dumps(asdict(self))

    @staticmethod
    def from_record(record: str) -> StepChoice:
        """The choice of a record."""
        return StepChoice(**json.loads(record))


@dataclass(frozen=True, eq=False)
class Pilots:
    """Pilot runs of an equation with rows p (R, np) and x0 (R, nx), and the error that the tolerance limits.

    For an `Ode`, `unit` [s] is a whole number of steps, and the time between common times divides it. For a sampled
    loop, the period is a whole number of substeps.
    """

    equation: Ode | SampledSystem
    make: Make
    errors: Errors
    p: Array
    x0: Array
    until: float
    unit: float
    seed: int = 0
    arithmetic: str | None = None
    methods: tuple[str, ...] = tuple(METHODS)

    @property
    def parts(self) -> int:
        """The number of common times in a unit, of which the number of steps is a multiple."""
        return 1 if isinstance(self.equation, SampledSystem) else ceil(LOOKS * self.unit / self.until)

    @property
    def first(self) -> int:
        """The number of the longest steps in a unit; none has more switches of a kind than `simulate` allows."""
        if isinstance(self.equation, SampledSystem):
            return 1
        count = self.round_count(ceil(COUNT * self.unit / self.until))
        while self.equation.switches.densest(self.p) * DENSEST < self.unit / count:
            count *= 2
        return count

    @property
    def doublings(self) -> int:
        """The largest number of times that the number of steps is doubled."""
        return SUBSTEPS if isinstance(self.equation, SampledSystem) else DOUBLINGS

    def round_count(self, count: float) -> int:
        """The next number of steps in a unit that is allowed."""
        return self.parts * ceil(count / self.parts * (1 - 1e-12))

    def run(self, count: int, method: str) -> Trajectories:
        """The pilot runs with `count` steps in a unit."""
        step = self.make(self.unit / count, method)
        every = self.unit / self.parts
        return run_step(
            step, self.p, self.x0, until=self.until, every=every, seed=self.seed, arithmetic=self.arithmetic
        )


class PilotComparison(NamedTuple):
    """Pilot runs at a step and at half of it."""

    steps: int  # in a unit
    method: Method
    error: float
    of: str
    fine: Trajectories


def search_step(pilots: Pilots, tolerance: float) -> StepChoice:
    """The longest step that was found at which every pilot run keeps the tolerance and is stable.

    The number of steps is doubled until the tolerance is kept. Between the last two numbers, an error model (a power of
    the step) predicts the longest step, and runs at that step confirm it. If stability alone requires short steps, the
    stabilised method is tried. If the error requires them and the rate has corners, the restarted method is tried.

    Raises
    ------
    ValueError
        If no pilot run stays finite, or no step keeps the tolerance.
    """
    run = lru_cache(maxsize=6)(pilots.run)

    def look(steps: int, method: Method) -> PilotComparison:
        fine, coarse = run(2 * steps, method.name), run(steps, method.name)
        return PilotComparison(steps, method, *pilots.errors(fine, coarse), fine)

    search = _Search(pilots, look, tolerance)
    most, (found, order) = search.by_classical_method()
    stable = _stable_counts(pilots, modes := _modes(found.fine))
    if found.error <= tolerance and found.steps < stable[RK4.name]:
        found, order = search.by(RK4, stable[RK4.name], most)
    cornered = corners_of(found.fine.step.flow) is not None
    for method in METHODS.values():
        bound = found.steps <= GAIN * stable[RK4.name]  # by stability
        if method.name in pilots.methods and (
            method is STABILISED_METHOD if bound else method is RESTARTED_METHOD and cornered
        ):
            most = found.steps if found.error <= tolerance else most
            other = search.by(method, stable[method.name], int(most / method.gain))
            if other[0].error <= tolerance and other[0].steps * method.gain <= most:
                found, order = other
    if not found.error <= tolerance:
        raise ValueError(_refusal(pilots, found, tolerance))
    return StepChoice(
        h=pilots.unit / found.steps,
        method=found.method.name,
        tolerance=tolerance,
        error=found.error,
        of=found.of,
        order=order,
        limit=_longest(modes, found.method.name),
        pilots=len(pilots.p),
    )


class _Search(NamedTuple):
    """The search of the longest step of a method that keeps a tolerance."""

    pilots: Pilots
    look: Callable[[int, Method], PilotComparison]
    tolerance: float

    def by(self, method: Method, first: int, most: int) -> tuple[PilotComparison, float]:
        """The look at the smallest number of steps, from `first` on, that keeps the tolerance, and the order there.

        If no number up to `most` keeps it, or restarts do not restore the order, it is the last look.
        """
        before, found, order = None, self.look(first, method), nan
        errors = [inf, inf, found.error]
        while not found.error <= self.tolerance:
            lost = method is RESTARTED_METHOD and errors[-1] > LEAST_FALL * errors[-3]
            if 2 * found.steps > most or lost:
                return found, order
            before, found = found, self.look(2 * found.steps, method)
            errors.append(found.error)
            order = _order(before.error, found.error)
        if before is None:
            return found, order
        power = order if isfinite(order) else method.order
        steps = found.steps * (found.error / (AIM * self.tolerance)) ** (1 / power)
        steps = self.pilots.round_count(max(steps, before.steps + 1))
        while steps < found.steps:
            if (trial := self.look(steps, method)).error <= self.tolerance:
                return trial, order
            steps = self.pilots.round_count(GROWTH * steps)
        return found, order

    def by_classical_method(self) -> tuple[int, tuple[PilotComparison, float]]:
        """The largest number of steps that is tried, and the look of the classical method; more for a fast mode."""
        first, pilots = self.pilots.first, self.pilots
        most = first * 2 ** (pilots.doublings - 1)
        answer = self.by(RK4, first, most)
        if isfinite(answer[0].error) or isinstance(pilots.equation, SampledSystem):
            return most, answer
        needed = _stable_counts(pilots, _modes(answer[0].fine))[RK4.name]
        if most < needed <= FAST * most:
            return 2 * needed, self.by(RK4, needed, 2 * needed)
        return most, answer


def _order(rough: float, fine: float) -> float:
    """The power of the step with which an error falls as it is halved; NaN where no number says it."""
    return max(log(rough / fine, 2), 0.5) if isfinite(rough) and isfinite(fine) and fine > 0 else nan


def _refusal(pilots: Pilots, comparison: PilotComparison, tolerance: float) -> str:
    h = pilots.unit / comparison.steps
    if isnan(comparison.error):
        limit = _longest(_modes(comparison.fine), RK4.name)
        fast = f"its fastest mode needs steps below {limit:.2g} s" if limit < h else "one of its modes is too fast"
        return (
            f"No step `h` can be chosen: none of the {len(pilots.p)} pilot runs stays finite up to {pilots.until:g} s "
            f"at steps down to {h / 2:.2g} s. The loop runs away, or {fast}: name a shorter `h`."
        )
    return (
        f"No step `h` keeps the tolerance of {tolerance:g}: that of {h:.2g} s still changes {comparison.of} so much "
        f"that its error is {comparison.error:.1e}. Where a law switches, smaller steps help little: ask for less, or "
        "name the step."
    )


def _stable_counts(pilots: Pilots, modes: Array) -> dict[str, int]:
    """The number of steps in a unit from which on each method is stable, by its name."""
    longest = {name: MARGIN * _longest(modes, name) for name in METHODS}
    return {name: pilots.round_count(max(pilots.first, pilots.unit / h)) for name, h in longest.items()}


def _modes(runs: Trajectories) -> Array:
    """The eigenvalues (n, m) at the start of every run, and at some states of those that last."""
    step, some = runs.step, np.unique(np.linspace(0, len(runs.t) - 1, STATES).round().astype(int))
    lasts = np.flatnonzero(~runs.has_diverged)
    run = np.concatenate([np.arange(len(runs.p)), np.repeat(lasts, len(some))])
    at = np.concatenate([np.zeros(len(runs.p), dtype=int), np.tile(some, len(lasts))])
    modes = modes_at(step.flow, runs.t[at], runs.x[run, at, : step.flow.states.size], runs.p[run])
    return np.asarray(modes[np.isfinite(modes).all(axis=1)])


def _longest(modes: Array, method: str) -> float:
    """The longest step in s at which every decaying mode is stable."""
    return float(np.min(longest_steps(modes, METHODS[method].amplification), initial=inf))

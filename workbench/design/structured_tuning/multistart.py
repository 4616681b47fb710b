"""The search from several starts: each is first made stable, then goes down, and the best are polished."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array
from workbench.design.matrices import one_thread
from workbench.design.structured_tuning.figure_pieces import FigurePiece, pole_pieces, spectral_abscissa
from workbench.design.structured_tuning.nonsmooth_search import Descent, PieceValues, descend, stationarity
from workbench.design.structured_tuning.quasi_newton import quasi_newton
from workbench.design.structured_tuning.system_jets import SystemJet

Model = Callable[[Array], SystemJet]
WIDTH, NARROW = 0.3, 0.1  # shares below the largest peak, in which pieces count: of a search, and of its polish
STABILISE, DESCEND, LONG, POLISH = 200, 400, 3000, 600  # iterations
ATTEMPTS = 3  # to make a start stable
PROMISING, POLISHED = 3, 2  # of the starts
FEW, FEW_BOUNDED = 5, 12  # numbers, without bounds and with them, for which the bundle alone is the shorter way
STABLE = 1e-3  # of the size of the poles, by which a start should be stable
AT_LEAST, AT_LEAST_SAMPLED = 1e-11, 1e-8  # of the size of the poles, by which it must; and |z| below one
KEPT = 1e-7  # by which the logarithm of a limit may be passed in doubles
NARROW_RANGE = 10.0  # of a number, over which starts are spread evenly
NEARLY_KEPT = 1e-4  # by which that of a start may be, before it is polished
PENALTY, STRONGEST = 10.0, 1e5


@dataclass(frozen=True)
@show
class StartResult:
    """The end of the search from one start: the largest soft goal and the largest excess of a hard one, as logarithms.

    `number` counts the starts from 0, and `evaluations` the points that were tried. `stable` is False if no stabilising
    point was reached; `abscissa` is then the least growth rate of the slowest pole, in 1/s.
    """

    number: int
    stable: bool
    objective: float
    violation: float
    abscissa: float
    evaluations: int


def spread_of(starts: Sequence[StartResult]) -> float:
    """The range of the soft goals over the starts that keep all limits, as a logarithm; NaN if none does."""
    ends = [one.objective for one in starts if one.stable and one.violation <= NEARLY_KEPT]
    return max(ends) - min(ends) if ends else math.nan


@dataclass(frozen=True, eq=False)
class StructuredSearch:
    """The best point (nd,), its pieces, how near it is to being stationary, and the end of each start."""

    x: Array
    values: PieceValues
    stationarity: float
    starts: tuple[StartResult, ...]
    least_violation: float

    @property
    def stable(self) -> bool:
        """True if a start led to a stable loop."""
        return any(one.stable for one in self.starts)


@dataclass(frozen=True, eq=False)
class SearchProblem:
    """Models of the closed loop by the parameters (nd,), the pieces of its goals, and the bounds of the parameters."""

    models: tuple[Model, ...]
    pieces: Callable[[Sequence[SystemJet], float], PieceValues]
    low: Array
    high: Array

    def jets(self, x: Array) -> list[SystemJet] | None:
        """The systems at a point, or None if one of them does not exist."""
        try:
            made = [model(x) for model in self.models]
        except np.linalg.LinAlgError:
            return None
        return made if all(one.finite for one in made) else None

    @property
    def is_small(self) -> bool:
        """True for few numbers."""
        bounded = bool(np.isfinite(self.low).all() and np.isfinite(self.high).all())
        return len(self.low) <= (FEW_BOUNDED if bounded else FEW)

    def growth(self, x: Array) -> PieceValues:
        """The growth of the poles, over their size, of all models."""
        jets = self.jets(x)
        if jets is None:
            return PieceValues(exists=False)
        found: list[FigurePiece] = []
        for number, jet in enumerate(jets):
            found += [replace(one, figure=number) for one in pole_pieces(jet)]
        return PieceValues(tuple(found))

    def values(self, x: Array, width: float) -> PieceValues:
        """The pieces of the goals; they do not exist where a model is not stable."""
        jets = self.jets(x)
        if jets is None or not all(_is_stable(jet) for jet in jets):
            return PieceValues(exists=False)
        try:
            values = self.pieces(jets, width)
        except np.linalg.LinAlgError:
            return PieceValues(exists=False)
        sound = all(
            math.isfinite(one.value) and np.isfinite(one.gradient).all() for one in (*values.soft, *values.hard)
        )
        return values if sound else PieceValues(exists=False)


def abscissa_of(jet: SystemJet) -> float:
    """The growth of the slowest pole in 1/s."""
    return spectral_abscissa(jet.A, jet.period)


def search(problem: SearchProblem, starts: Sequence[Array]) -> StructuredSearch:
    """The best local solution from all starts; a start that cannot be made stable is counted and left."""
    with one_thread(), np.errstate(all="ignore"):
        ends, results = list[Descent](), list[StartResult]()
        for number, start in enumerate(starts):
            end, abscissa, spent = _from_start(problem, start)
            if end is None:
                results.append(StartResult(number, False, math.inf, math.inf, abscissa, spent))
                continue
            ends.append(end)
            v = end.values
            results.append(StartResult(number, True, v.objective, v.violation, abscissa, spent + end.evaluations))
        if not ends:
            return StructuredSearch(starts[0], PieceValues(exists=False), math.inf, tuple(results), math.inf)
        ends.sort(key=_order)
        if not problem.is_small:
            ends = sorted((_quick(problem, end.x, LONG) for end in ends[:PROMISING]), key=_order)
        best = min((_polish(problem, end) for end in ends[:POLISHED]), key=_order)
        near = stationarity(best.values, best.x, problem.low, problem.high, PENALTY)
    violation = best.values.violation
    return StructuredSearch(best.x, best.values, near, tuple(results), violation)


def _order(end: Descent) -> tuple[float, float]:
    return max(KEPT, end.values.violation), end.values.objective


def _from_start(problem: SearchProblem, start: Array) -> tuple[Descent | None, float, int]:
    """The end of the descent from a start, or None, the growth of the slowest pole, and the points tried before."""
    start, least, spent = np.clip(start, problem.low, problem.high), math.inf, 0
    for attempt in range(ATTEMPTS):  # a start where poles meet has no gradient, but points nearby have one
        calm, tried = _stabilised(problem, _shaken(problem, start, attempt))
        spent += tried
        jets = problem.jets(calm)
        least = min(least, max(abscissa_of(jet) for jet in jets) if jets else math.inf)
        if problem.values(calm, WIDTH).exists:
            if problem.is_small:
                return _down(problem, calm, WIDTH, DESCEND, PENALTY), least, spent
            return _quick(problem, calm, DESCEND), least, spent
    return None, least, spent


def _shaken(problem: SearchProblem, start: Array, attempt: int) -> Array:
    """The start at the first attempt, and points farther and farther from it at the others."""
    if not attempt:
        return start
    size = np.where(np.isfinite(problem.high - problem.low), np.minimum(problem.high - problem.low, 1.0), 1.0)
    shift = np.random.default_rng(attempt).standard_normal(len(start))
    return np.clip(start + 0.1 * 3.0**attempt * size * shift, problem.low, problem.high)


def _stabilised(problem: SearchProblem, start: Array) -> tuple[Array, int]:
    """A point at which the growth of the slowest pole is small, from a start, and the points tried."""
    jets = problem.jets(start)
    if jets is None or problem.values(start, WIDTH).exists:
        return start, 1
    size = max(_size(jet) for jet in jets)
    calm = descend(
        problem.growth,
        start,
        problem.low,
        problem.high,
        iterations=STABILISE,
        radius=0.3 * (1 + float(np.abs(start).max(initial=0.0))),
        enough=lambda values: values.objective < -STABLE * size,
    )
    return calm.x, calm.evaluations


def _quick(problem: SearchProblem, x: Array, iterations: int) -> Descent:
    return quasi_newton(
        lambda y: problem.values(y, 0.0), x, problem.low, problem.high, iterations=iterations, penalty=PENALTY
    )


def _down(problem: SearchProblem, x: Array, width: float, iterations: int, penalty: float) -> Descent:
    radius = 0.3 * (1 + float(np.abs(x).max(initial=0.0)))
    return descend(
        lambda y: problem.values(y, width),
        x,
        problem.low,
        problem.high,
        iterations=iterations,
        penalty=penalty,
        radius=radius,
    )


def _polish(problem: SearchProblem, end: Descent) -> Descent:
    """The end of a search refined; where a limit is broken the penalty grows, and at last the limits count alone."""
    penalty = PENALTY
    best = _down(problem, end.x, NARROW, POLISH, penalty)
    if not problem.is_small:
        again = _quick(problem, best.x, LONG)
        best = min(best, again, _down(problem, again.x, NARROW, POLISH, penalty), key=_order)
    while best.values.violation > KEPT and penalty < STRONGEST:
        penalty *= 30
        best = min(best, _down(problem, best.x, NARROW, POLISH, penalty), key=_order)
    if best.values.violation > KEPT:
        alone = replace(problem, pieces=lambda jets, width: replace(problem.pieces(jets, width), soft=()))
        only = _down(alone, best.x, NARROW, POLISH, 1.0)
        if only.values.violation < best.values.violation:
            best = replace(only, values=problem.values(only.x, NARROW))
    return best


def _is_stable(jet: SystemJet) -> bool:
    poles = np.linalg.eigvals(jet.A) if jet.n else np.zeros(0)
    if jet.period is None:
        return bool((poles.real < -AT_LEAST * np.abs(poles).max(initial=0.0)).all())
    return bool((np.abs(poles) < 1 - AT_LEAST_SAMPLED).all())


def _size(jet: SystemJet) -> float:
    return float(np.abs(np.linalg.eigvals(jet.A)).max(initial=1e-12)) if jet.period is None else 1 / jet.period


def random_starts(first: Array, count: int, seed: int, low: Array, high: Array) -> list[Array]:
    """The first start, and random ones of sizes in three decades; between near bounds they are spread evenly."""
    generator, made = np.random.default_rng(seed), [first]
    bounded = np.isfinite(low) & np.isfinite(high)
    span, floor = np.where(bounded, high, 1.0) - np.where(bounded, low, 0.0), np.where(bounded, low, 0.0)
    for k in range(1, count):
        wide = first + 10.0 ** ((k % 3) - 0.5) * generator.standard_normal(len(first))
        even = floor + span * generator.random(len(first))
        made.append(np.where(bounded & (span <= NARROW_RANGE), even, np.clip(wide, low, high)))
    return made

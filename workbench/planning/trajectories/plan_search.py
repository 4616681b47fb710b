"""The search for a plan: starts, the hold of the inputs, and meshes that the march refines."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.planning.trajectories.conflict_search import find_conflict
from workbench.planning.trajectories.initial_guess import guess
from workbench.planning.trajectories.ipopt_solver import ProgramEnd, call_ipopt
from workbench.planning.trajectories.marching import MarchedArc, defects, march, objective, roughness
from workbench.planning.trajectories.plan_options import PlanOptions
from workbench.planning.trajectories.plan_problem import PlanProblem, Scales
from workbench.planning.trajectories.plan_values import Values
from workbench.planning.trajectories.transcription import Transcription

COARSE, FINE = 150, 120  # iterations of IPOPT, from afar and from a trajectory on a coarser mesh
PATIENT = 300  # the same, where the others did not do
JUMP = 0.2  # of its range, in one interval of the first mesh, below which no input jumps
ROUGH = 0.05  # distance of an input from its neighbours' line or value, as a share of its range, that is cut
ROUNDS = 16
SPARE_STARTS = 5  # random ones, where the others do not end
STRETCHES = (1.0, 1.0, 4.0, 2.0)  # of the duration, in the starts of a search for conflicts; all but the first random
SPARE_STRETCHES = (3.0, 8.0, 4.0, 2.0, 6.0, 3.0, 4.0, 5.0)  # in those by which its answer is checked
CONFLICT_INTERVALS = 24


@dataclass(frozen=True, eq=False)
class PlanSearchEnd:
    """The end of a search: the problem with its hold, the last program and its march, and what came before."""

    problem: PlanProblem
    program: ProgramEnd
    runs: tuple[MarchedArc, ...]
    objective_error: float  # relative, by the last cut of all intervals; infinite where there was none
    objectives: tuple[float, ...]  # of the march, from mesh to mesh
    starts: tuple[float, ...] = ()  # objectives on the first mesh of all starts that ended


def search(
    problem: PlanProblem, options: PlanOptions, rows: Mapping[int, Array], first: Values | None
) -> PlanSearchEnd:
    """The best plan from some starts, on a mesh that the march accepts.

    Raises
    ------
    PlanConflictError
        If no trajectory meets all that was asked.
    ValueError
        If no search ends.
    """
    scales = Scales.of_problem(problem)
    coarse = replace(problem, hold="linear" if problem.hold == "automatic" else problem.hold)
    box = Transcription(coarse, (np.ones(2),) * len(problem.phases), scales).bounds()
    crosses = bool((box[0] > box[1]).any())
    ends = [] if crosses else _first_ends(coarse, options, scales, rows, first)
    if not ends:
        ends = [_from_feasible(coarse, options, scales, rows)]
    best = min(ends, key=lambda end: end.objective)
    problem, best = _with_better_hold(problem, best)
    return replace(refine(problem, best, options), starts=tuple(sorted(end.objective for end in ends)))


def _first_ends(
    problem: PlanProblem, options: PlanOptions, scales: Scales, rows: Mapping[int, Array], first: Values | None
) -> list[ProgramEnd]:
    """The ends of the starts on the first mesh that end in an optimum.

    Where the first two do not, the straight line is tried once more in the units of the problem, as scales may mislead.
    """
    counts, rng = (options.intervals,) * len(problem.phases), np.random.default_rng(options.seed)
    sizes, ends = np.concatenate([scales.x, scales.u]), list[ProgramEnd]()
    for attempt in range(max(options.starts, 2)):
        start = guess(problem, counts, sizes, rows, rng if attempt else None)
        if first is not None and attempt == 0:
            start = tuple(arc.on_mesh(np.full(options.intervals, 1.0), problem.hold) for arc in first)
        transcription = Transcription(problem, tuple(arc.mesh for arc in start), scales)
        end = call_ipopt(transcription, start, 1.0, warm=False, most=COARSE)
        if end.is_solved:
            ends.append(end)
        if (attempt + 1 >= options.starts and ends) or (attempt == 1 and not ends):
            break
    if not ends:
        ones = Scales(np.ones_like(scales.x), np.ones_like(scales.u), scales.T)
        start = guess(problem, counts, sizes, rows)
        transcription = Transcription(problem, tuple(arc.mesh for arc in start), ones)
        end = call_ipopt(transcription, start, 1.0, warm=False, most=COARSE)
        ends += [end] if end.is_solved else []
    return ends


def _from_feasible(problem: PlanProblem, options: PlanOptions, scales: Scales, rows: Mapping[int, Array]) -> ProgramEnd:
    """The end from a trajectory that violates nothing, or the conflict where there is none."""
    few = min(options.intervals, CONFLICT_INTERVALS)
    counts, rng = (few,) * len(problem.phases), np.random.default_rng(options.seed)
    sizes = np.concatenate([scales.x, scales.u])
    guesses = []
    for i, stretch in enumerate(STRETCHES + SPARE_STRETCHES):
        one = guess(problem, counts, sizes, rows, rng if i else None)
        guesses.append(tuple(replace(arc, T=stretch * arc.T) for arc in one))
    transcription = Transcription(problem, tuple(arc.mesh for arc in guesses[0]), scales)
    answer = find_conflict(transcription, guesses[: len(STRETCHES)], guesses[len(STRETCHES) :])
    if isinstance(answer, Exception):
        raise answer
    mesh = np.full(options.intervals, 1.0)
    starts = [tuple(arc.on_mesh(mesh, problem.hold) for arc in answer)]
    counts = (options.intervals,) * len(problem.phases)
    starts += [guess(problem, counts, sizes, rows, rng) for _ in range(SPARE_STARTS)]
    transcription = Transcription(problem, (mesh,) * len(problem.phases), scales)
    for start in starts:
        end = call_ipopt(transcription, start, 1.0, warm=False, most=3 * COARSE)
        if end.is_solved:
            return end
    raise ValueError(
        f"`plan(...)` found a trajectory within all limits and no optimum from {len(starts) + 2} starts; IPOPT ended "
        f"with '{end.status}': give a `guess`, limits for what may run away, or more `starts`."
    )


def _with_better_hold(problem: PlanProblem, end: ProgramEnd) -> tuple[PlanProblem, ProgramEnd]:
    """The problem with the hold of its inputs that reaches the lower objective on the first mesh.

    Both holds restrict the inputs and nothing else, so that the lower objective is nearer to the optimum.
    """
    if problem.hold != "automatic":
        return problem, end
    linear = replace(problem, hold="linear")
    u = np.concatenate([arc.u for arc in end.values])
    span = _spans(u)
    largest = max(float((np.abs(np.diff(arc.u, axis=0)) / span).max()) for arc in end.values)
    if problem.has_slopes or largest < JUMP:
        return linear, end
    zero = replace(problem, hold="zero")
    other = _solve_again(zero, tuple(arc.on_mesh(arc.mesh, "zero") for arc in end.values), end)
    return (zero, other) if other.is_solved and other.objective < end.objective else (linear, end)


def refine(problem: PlanProblem, end: ProgramEnd, options: PlanOptions) -> PlanSearchEnd:
    """Solve on finer meshes until the march misses no node by more than the tolerance, and the objective is steady.

    Where the march misses or an input is rough an interval is cut; once that changes little, all are. The change of the
    objective by a cut of all is its error.
    """
    objectives, error, everywhere = list[float](), np.inf, False
    meshes: tuple[Array, ...] = ()
    best: tuple[ProgramEnd, tuple[MarchedArc, ...]] | None = None
    for _ in range(ROUNDS):
        if best is not None:
            values = tuple(arc.on_mesh(mesh, problem.hold) for arc, mesh in zip(end.values, meshes, strict=True))
            finer = _solve_again(problem, values, end)
            if not finer.is_solved:
                break
            end = finer
        runs = march(problem, end.values)
        best = end, runs
        objectives.append(objective(problem, end.values, runs))
        change = _change(objectives, problem.hold)
        error = change if everywhere else error
        misses = defects(end.values, runs)
        good = max(float(miss.max()) for miss in misses) <= options.tolerance
        if good and everywhere and change <= options.objective_tolerance:
            break
        meshes, everywhere = _finer(end.values, misses, options.tolerance, change <= options.objective_tolerance / 2)
        if sum(map(len, meshes)) > options.most_intervals:
            break
    assert best is not None
    return PlanSearchEnd(problem, *best, error, tuple(objectives))


def _solve_again(problem: PlanProblem, values: Values, before: ProgramEnd) -> ProgramEnd:
    """The end from a trajectory near the optimum; from farther inside the limits where that does not end."""
    x = np.concatenate([arc.x for arc in values])
    u = np.concatenate([arc.u for arc in values])
    scales = Scales.of_values(x, u, np.array([arc.T for arc in values]), before.transcription.scales)
    transcription = Transcription(problem, tuple(arc.mesh for arc in values), scales)
    end = call_ipopt(transcription, values, before.objective, warm=True, most=FINE)
    return end if end.is_solved else call_ipopt(transcription, values, before.objective, warm=False, most=PATIENT)


def _change(objectives: Sequence[float], hold: str) -> float:
    """The relative change of the objective by the last mesh, of held inputs a third of it; infinite on the first."""
    if len(objectives) < 2:
        return np.inf
    size = max(abs(objectives[-1]), max(map(abs, objectives)) * 1e-6, 1e-12)
    return abs(objectives[-1] - objectives[-2]) / size / (3.0 if hold == "zero" else 1.0)


def _spans(u: Array) -> Array:
    """The range (nu,) of each input, and nearly its size where it does not move."""
    return np.asarray(np.maximum(np.ptp(u, axis=0), 1e-9 * np.maximum(np.abs(u).max(axis=0), 1e-9)))


def _finer(values: Values, misses: list[Array], tolerance: float, steady: bool) -> tuple[tuple[Array, ...], bool]:
    """Meshes with intervals cut where the march misses or an input is rough, or all; and whether all are cut."""
    span = _spans(np.concatenate([arc.u for arc in values]))
    cuts = [miss > tolerance for miss in misses]
    if not steady:
        rough = [(roughness(arc) / span).max(axis=1) > ROUGH for arc in values]
        cuts = [cut | one for cut, one in zip(cuts, rough, strict=True)]
    every = not any(cut.any() for cut in cuts)
    parts = [np.where(cut | every, 2, 1) for cut in cuts]
    meshes = tuple(np.repeat(arc.mesh / part, part) for arc, part in zip(values, parts, strict=True))
    return meshes, every

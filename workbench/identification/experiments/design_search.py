"""The search of a design: random inputs, the best of them improved, and limits that hold between the steps, too."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.identification.estimation.experiment_check import identifiability
from workbench.identification.estimation.identifiability import Identifiability
from workbench.identification.experiments.constrained_search import CLOSE, TOLERANCE, ConstrainedSearch, largest_within
from workbench.identification.experiments.design_problem import CALL, DesignProblem, dataset_of
from workbench.identification.experiments.plain_excitations import chirp_signals, random_step_signals

DRAWS = 6  # random inputs for each search
HALVINGS = 8  # of the step, at most
STEP_CHANGE = 1e-4  # relative change of a standard error by half the step that a search may have
SPARE = 2e-4  # margin that a search leaves, as a share of a range, for its own tolerance
DOUBTFUL = 1e-3  # ratio of singular values below which a small one may be an error of the step
CORRECTIONS = 6


class DesignEnd(NamedTuple):
    """The end of a search: the problem at the step that was needed, the coefficients and the goals of all starts."""

    problem: DesignProblem
    c: Array
    goals: tuple[float, ...]
    by_half_step: float


def search(
    problem: DesignProblem, starts: int, rounds: int, generator: np.random.Generator, inputs: tuple[str, ...]
) -> DesignEnd:
    """The best input of several searches, all of whose limits hold on steps half as long."""
    problem, candidates = _candidates(problem, starts, generator)
    _refuse_ambiguity(problem, candidates[0], inputs)
    reserve = np.full((len(problem.response.limits.all_names), 2), SPARE)
    first = _searcher(problem, reserve, 2)
    ends = [first.improve(c, _unit(problem, c)) for c in candidates[:starts]]
    ends.sort(key=lambda end: end[1])
    c = ends[0][0]
    c, goal = _searcher(problem, reserve, rounds).improve(c, _unit(problem, c))
    goals = (min(goal, ends[0][1]), *(end[1] for end in ends[1:]))
    c = _between_steps(problem, c, reserve)
    return DesignEnd(problem, c, goals, _step_error(problem, c))


def _searcher(problem: DesignProblem, reserve: Array, rounds: int) -> ConstrainedSearch:
    return ConstrainedSearch(problem.response, problem.criterion, problem.rest, reserve, problem.shape.is_free, rounds)


def _candidates(
    problem: DesignProblem, starts: int, generator: np.random.Generator
) -> tuple[DesignProblem, list[Array]]:
    """Random inputs as large as the limits allow, the best first, at a step that is short enough for it."""
    random = problem.shape.draw(DRAWS * starts, len(problem.rest), generator)
    plain = (*random_step_signals(problem, generator), *chirp_signals(problem))
    draws = problem.rest + np.concatenate([random, [problem.shape.nearest(signals) for signals in plain]])
    reserve = np.full((len(problem.response.limits.all_names), 2), 2 * SPARE)
    for _ in range(HALVINGS):
        scaled = [largest_within(problem.response, reserve, problem.rest, c) for c in draws]
        within = [c for c in scaled if c is not None]
        goals = [problem.criterion.value(problem.response.derivatives(c)) for c in within]
        candidates = [within[i] for i in np.argsort(goals, kind="stable")]
        if candidates and _step_error(problem, candidates[0]) <= STEP_CHANGE:
            return problem, candidates
        if (
            candidates
            and not np.isfinite(min(goals))
            and np.isfinite(problem.response.derivatives(candidates[0])).all()
        ):
            return problem, candidates
        problem = problem.at_half_step()
    if candidates:
        return problem, candidates
    raise ValueError(
        f"`{CALL}(limits=...)` must leave room for a motion; none of {len(draws)} random inputs of any size keeps all "
        "limits: an unstable system needs a controller, so design for its loop, or widen the limits."
    )


def _step_error(problem: DesignProblem, c: Array) -> float:
    """The largest relative change of a standard error by half the step."""
    Js = [one.derivatives(c) for one in (problem.response, problem.response.at_half_step())]
    if not all(np.isfinite(problem.criterion.value(J)) for J in Js):
        return np.inf
    errors = [np.sqrt(np.diag(problem.criterion.covariance(J))) for J in Js]
    return float(np.max(np.abs(errors[1] / errors[0] - 1)))


def _refuse_ambiguity(problem: DesignProblem, c: Array, inputs: tuple[str, ...]) -> None:
    """Refuse numbers that even the best random input cannot tell."""
    model, sigma = problem.response.model, problem.response.sigma
    names = [number.name for number in model.numbers]
    J = problem.response.derivatives(c).reshape(-1, len(names))
    answer = Identifiability.of(tuple(names), model.starts, J)
    if answer.is_complete and answer.singular_values[-1] < DOUBTFUL * answer.singular_values[0]:
        t, u = model.dataset.experiments[0].t, problem.response.basis @ c.T
        values = dict(zip(model.ode.parameters.labels, model.p.tolist(), strict=True))
        values |= dict(zip(model.ode.states.labels, model.x0[0].tolist(), strict=True))
        outputs = [label for _, label in model.outputs]
        answer = identifiability(
            model.ode,
            dataset_of(model.ode, inputs, t, u),
            names,
            outputs,
            noise=dict(zip(outputs, sigma.tolist(), strict=True)),
            hold=model.inputs[0].hold,
            start={name: value for name, value in values.items() if name not in problem.response.limits.inputs},
        )
    if not answer.is_complete:
        raise ValueError(
            f"`{CALL}(free=...)` must be numbers that the outputs can tell apart; no input of this shape tells "
            f"{', '.join(answer.ambiguous_names)}. {' '.join(answer.sentences)} Leave out one number for each such "
            "direction, or measure more."
        )


def _unit(problem: DesignProblem, c: Array) -> Array:
    """The size (nu, 1) of the coefficients of each input."""
    size = np.abs(c - problem.rest).max(axis=1, keepdims=True)
    return np.asarray(np.where(size > 0, size, max(float(size.max()), 1e-12)))


def _between_steps(problem: DesignProblem, c: Array, reserve: Array) -> Array:
    """Coefficients near to c with which all limits hold on steps half as long, too."""
    finer = problem.response.at_half_step()
    for _ in range(CORRECTIONS):
        left = np.min(finer.margins(c), axis=0)
        if (left >= 0).all():
            return c
        reserve = reserve + np.where(left < 0, 1.5 * np.minimum(-left, 0.1) + TOLERANCE, 0.0)
        inside = largest_within(problem.response, reserve, problem.rest, c)
        if inside is None:
            break
        c = _searcher(problem, reserve, 2).improve(inside, _unit(problem, inside))[0]
    inside = largest_within(finer, np.zeros_like(reserve), problem.rest, c, CLOSE)
    if inside is None:
        raise ValueError(
            f"`{CALL}(...)` found no input that keeps its limits between the steps: widen them, or sample faster."
        )
    return inside

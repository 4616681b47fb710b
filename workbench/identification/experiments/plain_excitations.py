"""Plain excitations within the limits of a design, to compare: random steps and a chirp."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.identification.experiments.constrained_search import largest_within
from workbench.identification.experiments.design_problem import DesignProblem
from workbench.identification.experiments.input_shapes import chirp, random_steps

STEPS = (5, 10, 20, 40)  # in an experiment
DRAWS = 3  # of each


class PlainExcitation(NamedTuple):
    """The best of several plain excitations of a kind: its inputs (N, nu), the criterion, and standard errors (nz,)."""

    inputs: Array
    value: float
    errors: Array


def plain_excitations(problem: DesignProblem, generator: np.random.Generator) -> dict[str, PlainExcitation]:
    """By kind, the best of several plain excitations, each as large as the limits allow."""
    kinds = {"random steps": random_step_signals(problem, generator), "chirp": chirp_signals(problem)}
    best = {kind: min((_largest(problem, one) for one in signals), key=_value) for kind, signals in kinds.items()}
    return {kind: plain for kind, plain in best.items() if np.isfinite(plain.value)}


def _value(plain: PlainExcitation) -> float:
    return plain.value


def _times(problem: DesignProblem) -> Array:
    return problem.response.model.dataset.experiments[0].t


def random_step_signals(problem: DesignProblem, generator: np.random.Generator) -> Iterator[Array]:
    """Signals (N, nu) of random steps."""
    t, inputs = _times(problem), problem.response.limits.inputs
    for count in STEPS:
        for _ in range(DRAWS):
            yield np.column_stack([random_steps(t, problem.until, count, generator) for _ in inputs])


def chirp_signals(problem: DesignProblem) -> Iterator[Array]:
    """Signals (N, nu) of chirps up to the highest frequency of the design, and up to a tenth of it."""
    t, count = _times(problem), len(problem.response.limits.inputs)
    first = 1 / problem.until
    for last in (problem.highest, np.sqrt(first * problem.highest)):
        for begin in (0.0, np.pi / 2):
            phases = begin + np.arange(count) * np.pi / count
            yield np.column_stack([chirp(t, problem.until, first, max(last, 1.01 * first), p) for p in phases])


def _largest(problem: DesignProblem, signal: Array) -> PlainExcitation:
    """A signal (N, nu) of amplitude 1, made as large as the limits allow; of infinite value if it tells nothing."""
    count = signal.shape[1]
    basis = np.column_stack([np.ones(len(signal)), _ramped(problem, signal)])
    response = problem.response.with_basis(basis)
    rest = np.zeros((count, count + 1))
    rest[:, 0] = (problem.shape.basis @ problem.rest.T)[0]
    unit = rest + np.column_stack([np.zeros(count), np.eye(count)])
    c = largest_within(response, np.zeros((len(response.limits.all_names), 2)), rest, unit)
    if c is None:
        return PlainExcitation(signal, np.inf, np.zeros(0))
    J = response.derivatives(c)
    value = problem.criterion.value(J)
    errors = np.sqrt(np.diag(problem.criterion.covariance(J))) if np.isfinite(value) else np.zeros(0)
    return PlainExcitation(basis @ c.T, value, errors)


def _ramped(problem: DesignProblem, signal: Array) -> Array:
    """The signal with ramps in the place of jumps, for each input whose rate is limited."""
    limits, t = problem.response.limits, _times(problem)
    out = signal.copy()
    for i, low, high in limits.slopes:
        label = limits.inputs[i]
        if label not in limits.names:
            continue
        span = float(np.diff(limits.all_ends[limits.names.index(label)])[0]) / min(abs(low), abs(high))
        width = int(np.ceil(span / (t[1] - t[0])))
        if np.isfinite(span) and 1 < width < len(t):
            padded = np.concatenate([np.zeros(width - 1), out[:, i]])  # it begins at rest
            out[:, i] = np.convolve(padded, np.full(width, 1 / width), mode="valid")
    return out

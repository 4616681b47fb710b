"""The step of a fit: so short that half of it would move neither outputs nor estimates."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.identification.estimation.fit_search import SearchEnd, follow, has_noise, is_poor, spread, with_noise
from workbench.identification.estimation.least_squares import MOST_ROUNDS
from workbench.identification.estimation.output_model import OutputModel
from workbench.identification.estimation.weighed_data import WeighedData

SUBSTEPS = 256  # of the median interval between samples, at most
STABLE = 1.3  # |lambda| h at the start: Runge-Kutta steps of order 4 are stable up to 2.78
MOST_STEPS = 2**22  # of a run whose step is halved because it diverges
OF_NOISE, OF_SPREAD = 0.03, 1e-4  # change of an output at half the step that a search may have
OF_ERROR, OF_ESTIMATE = 1e-3, 1e-8  # change of an estimate at half the step, in standard errors, or relative
PASSED, PASSED_EXACTLY = 1e-2, 1e-6  # of both figures, in standard errors, or relative


class NewtonStep(NamedTuple):
    """Newton's step from z to the minimum, at the step of a model."""

    move: Array  # (nz,)
    errors: Array  # (nz,), standard errors for the given sigma
    derivatives: Array  # (M, nz)


def newton_step(data: WeighedData, z: Array, sigma: Array) -> NewtonStep:
    """The step to the minimum of the linearised residuals; infinite where they cannot tell the numbers apart."""
    r, J = data.linearize(z, sigma)
    norms = np.linalg.norm(J, axis=0)
    norms = np.where(norms > 0, norms, 1.0)
    left, sizes, right = np.linalg.svd(J / norms, full_matrices=False)
    with np.errstate(all="ignore"):
        move = -(right.T @ ((left.T @ r) / sizes)) / norms
        errors = np.sqrt(np.sum((right.T / sizes) ** 2, axis=1)) / norms
    return NewtonStep(move, errors, J)


def halve(data: WeighedData) -> WeighedData:
    """The same data with a model of half the step."""
    return replace(data, model=data.model.at_half_step())


def coarse_enough(data: WeighedData, sigma: Array | None) -> WeighedData:
    """A model whose outputs at the start keep still at half its step, as far as a search needs it.

    The step is short enough for the fastest mode at the start, too, so that a search may make it faster. If no run
    lasts at any step, the step stays as it was: the run diverges by itself.
    """
    first, fastest, rows = data, fastest_rate(data.model), sum(map(len, data.model.dataset))
    limit = OF_NOISE * sigma if sigma is not None else OF_SPREAD * spread(data)
    z, part = data.model.starts, 1
    errors = data.errors(z)
    while part < SUBSTEPS:
        finer, part = halve(data), 2 * part
        later, changes = finer.errors(z), []
        for now, new, mask in zip(errors, later, data.weighs, strict=True):
            with np.errstate(all="ignore"):
                changes.append(np.max(np.where(mask, np.abs(new - now) / limit, 0.0), initial=0.0))
        worst = float(np.max(changes))
        if worst <= 1.0 and fastest * max(data.model.h) <= STABLE:
            return data
        if part > 8 and not np.isfinite(worst) and rows * part > MOST_STEPS:
            return first
        data, errors = finer, later
    return data if np.isfinite(worst) else first


def fastest_rate(model: OutputModel) -> float:
    """The largest |lambda| in 1/s of the modes at the start of the first experiment; 0 if there is none."""
    A = np.array(model.ode.A(model.begins[0], model.x0[0], model.p))
    return float(np.abs(np.linalg.eigvals(A)).max(initial=0.0)) if np.isfinite(A).all() else 0.0


@dataclass(frozen=True, eq=False)
class RefinedEnd:
    """The end of a search, at a step that does not matter any more."""

    data: WeighedData
    end: SearchEnd
    by_half_step: float  # largest change of an estimate, in standard errors, or relative for a log without noise
    to_minimum: float  # in the same unit
    limit: float  # of both
    last: NewtonStep


def refine(data: WeighedData, end: SearchEnd, is_noise_known: bool) -> RefinedEnd:
    """Halve the step and search again until half of it moves no estimate; not after a poor search without an end."""
    part = 1
    while True:
        finer, part = halve(data), 2 * part
        last, later = newton_step(data, end.z, end.sigma), newton_step(finer, end.z, end.sigma)
        is_noisy = is_noise_known or has_noise(data, end.sigma)
        unit = last.errors if is_noisy else np.maximum(np.abs(end.z), np.finfo(float).tiny)
        shift, move = (float(np.max(np.abs(step) / unit)) for step in (later.move - last.move, last.move))
        limit = PASSED if is_noisy else PASSED_EXACTLY
        is_lost = end.minimum.rounds >= MOST_ROUNDS and is_poor(data, end.z, end.sigma if is_noise_known else None)
        if shift <= (OF_ERROR if is_noisy else OF_ESTIMATE) or part > SUBSTEPS or not np.isfinite(shift) or is_lost:
            return RefinedEnd(data, end, shift, move, limit, last)
        data = finer
        minimum = follow(data, end.sigma, end.z)
        if minimum is None:
            return RefinedEnd(data, end, np.inf, np.inf, limit, later)
        end = replace(end, z=minimum.z, minimum=minimum)
        end = end if is_noise_known else with_noise(data, end)

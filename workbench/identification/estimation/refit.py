"""Fits that are repeated from a near start: with a number frozen, or with other noise."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from workbench.core.validation.refusals import Array, Integers
from workbench.identification.estimation.fit_search import LEAST_NOISE, spread
from workbench.identification.estimation.step_refinement import halve
from workbench.identification.estimation.weighed_data import LARGEST, WeighedData

CONVERGED = 1e-3  # length of the last Gauss-Newton step in standard errors: the deviance is right to its square
MOST_ROUNDS, MOST_HALVINGS = 40, 10


class LinearErrors(NamedTuple):
    """Model minus sample (M,) of the samples that count, and the derivatives (M, nz)."""

    errors: Array
    derivatives: Array


class Refit(NamedTuple):
    """The end of a repeated fit: the numbers z (nz,), the deviance, and the next step in standard errors."""

    z: Array
    deviance: float
    to_minimum: float

    @property
    def is_converged(self) -> bool:
        """True if the next step is so short that neither the numbers nor the deviance change."""
        return self.to_minimum <= CONVERGED


@dataclass(frozen=True, eq=False)
class Deviance:
    """Minus twice the log-likelihood of numbers z, but for a constant.

    It is sum |e_j|^2 / sigma_j^2 over the sensors j if their `sigma` (ny,) is known, and sum n_j log(|e_j|^2 / n_j) at
    the most likely noise if `sigma` is None.
    """

    data: WeighedData
    sigma: Array | None

    @cached_property
    def sensors(self) -> Integers:
        """(M,), the sensor of each sample that counts."""
        each = [np.broadcast_to(np.arange(mask.shape[1]), mask.shape)[mask] for mask in self.data.weighs]
        return np.concatenate(each)

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """The bounds (nz,) of the numbers."""
        numbers = self.data.model.numbers
        return np.array([one.low for one in numbers]), np.array([one.high for one in numbers])

    def linearize(self, z: Array) -> LinearErrors:
        """The errors and their derivatives at z (nz,)."""
        with np.errstate(all="ignore"):
            return LinearErrors(*self.data.linearize(z, np.ones(len(self.data.counts))))

    def errors(self, z: Array) -> Array:
        """The errors (M,) alone."""
        with np.errstate(all="ignore"):
            return self.data.residuals(z, np.ones(len(self.data.counts)))

    def shift_by_half_step(self, z: Array) -> float:
        """The change of the estimates z (nz,) by half the integration step, in standard errors."""
        now, finer = self.linearize(z), replace(self, data=halve(self.data))
        weights = self.weights(now.errors)
        moved, J = weights * (finer.errors(z) - now.errors), weights[:, np.newaxis] * now.derivatives
        norms = np.linalg.norm(J, axis=0)
        scaled = J / np.where(norms > 0, norms, 1.0)
        if not (np.isfinite(moved).all() and np.isfinite(scaled).all()):
            return np.inf
        return float(np.linalg.norm(scaled @ np.linalg.lstsq(scaled, moved, rcond=None)[0]))

    def _squares(self, errors: Array) -> Array:
        """(ny,), the sum of squares of each sensor, at least that of rounding."""
        squares = np.bincount(self.sensors, errors**2, len(self.data.counts))
        return np.asarray(np.maximum(squares, self.data.counts * self._least_noise**2))

    @cached_property
    def _least_noise(self) -> Array:
        return LEAST_NOISE * spread(self.data)

    def value(self, errors: Array) -> float:
        """The deviance of errors (M,); infinite where a run diverges."""
        if not (np.abs(errors) < LARGEST).all():
            return np.inf
        squares = self._squares(errors)
        if self.sigma is not None:
            return float(np.sum(squares / self.sigma**2))
        return float(np.sum(self.data.counts * np.log(squares / self.data.counts)))

    def weights(self, errors: Array) -> Array:
        """(M,), one over the noise of each sample, as known or as most likely for these errors."""
        if self.sigma is not None:
            return np.asarray(1 / self.sigma[self.sensors])
        return np.asarray(np.sqrt(self.data.counts / self._squares(errors))[self.sensors])


def refit(
    deviance: Deviance, start: Array, free: Integers, shift: Array | float = 0.0, first: LinearErrors | None = None
) -> Refit:
    """The least deviance near a start (nz,) over the numbers at the places `free`, within their bounds.

    The steps are those of Gauss and Newton, halved until the deviance falls. A fit that does not converge says so by
    its `to_minimum`.

    Parameters
    ----------
    shift
        (M,), added to the errors: minus the noise of other samples.
    first
        The errors and derivatives at the start, before the shift, if they are known.
    """
    low, high = deviance.bounds
    z = start.copy()
    now = first or deviance.linearize(z)
    errors = now.errors + shift
    value, left = deviance.value(errors), np.inf
    for _ in range(MOST_ROUNDS):
        if not np.isfinite(value) or not np.isfinite(now.derivatives).all():
            return Refit(z, np.inf, np.inf)
        step, left = _step(deviance, z, free, errors, now.derivatives)
        part = 1.0
        for _ in range(MOST_HALVINGS):
            tried = np.clip(z + part * step, low, high)
            if left <= CONVERGED:  # the deviance of so short a step is known beforehand
                return Refit(tried, value - left**2, left)
            later = deviance.linearize(tried)
            new = deviance.value(later.errors + shift)
            if new < value:
                break
            part /= 2
        else:
            return Refit(z, value, left)
        z, now, errors, value = tried, later, later.errors + shift, new
    return Refit(z, value, left)


def _step(deviance: Deviance, z: Array, free: Integers, errors: Array, derivatives: Array) -> tuple[Array, float]:
    """The step (nz,) to the minimum of the linearised errors, and its length in standard errors.

    A number at a bound, beyond which the deviance would fall, stays there.
    """
    low, high = deviance.bounds
    weights = deviance.weights(errors)
    r, J = weights * errors, weights[:, np.newaxis] * derivatives
    slope = J.T @ r
    stays = ((z <= low) & (slope > 0)) | ((z >= high) & (slope < 0))
    moving = free[~stays[free]]
    step = np.zeros_like(z)
    if not moving.size:
        return step, 0.0
    norms = np.linalg.norm(J[:, moving], axis=0)
    norms = np.where(norms > 0, norms, 1.0)
    scaled = np.linalg.lstsq(J[:, moving] / norms, -r, rcond=None)[0]
    step[moving] = scaled / norms
    return step, float(np.linalg.norm(J @ step))

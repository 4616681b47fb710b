"""Generalised least squares of torques on base parameters, with a covariance that allows for correlated residuals.

References
----------
Swevers, Verdonck and De Schutter (2007), Dynamic model identification for industrial robots, IEEE Control Systems
Magazine 27(5), 58-71 (weights by joint). Newey and West (1987), Econometrica 55(3), 703-708 (the covariance).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from workbench.arms.log_regression.prepared_motion import PreparedMotion
from workbench.arms.log_regression.regressed_joints import JointTerms
from workbench.arms.mechanics.parameter_reduction import BaseParameters
from workbench.core.validation.refusals import Array
from workbench.identification.datasets.experiment import Marks

ROUNDS = 2  # of weights behind the first fit
UNCORRELATED = 0.1  # the autocorrelation of residuals below which they count as apart
SMALL_SHARE = 1e-3  # of the torque
LEAST = 1e-9  # of the largest singular value: what is below is rounding


class Equations(NamedTuple):
    """The N equations of each joint in one experiment, each weighed with the time that it stands for."""

    Y: Array  # (N, n, b)
    tau: Array  # (N, n)
    weights: Array  # (N, n), the roots of the weights


class Regression(NamedTuple):
    """An estimate with its covariance, and what the data say of it."""

    theta: Array  # (b,)
    covariance: Array  # (b, b)
    sigma: Array  # (n,), root mean square of the residuals by joint
    singular_values: Array  # of the weighed columns, each of length one
    directions: Array  # (b, b), in rows
    least_errors: Array  # (b,), of numbers whose torque is a thousandth of all: filters err by as much


def equations_of(base: BaseParameters, motion: PreparedMotion, terms: JointTerms) -> Equations:
    """The equations of one experiment."""
    Y = base.at(motion.q, motion.qd, motion.qdd).reshape(len(motion.t), base.regressor.dof, -1)
    return Equations(Y, motion.filtered_tau, np.sqrt(motion.period) * moving_samples(motion, terms))


def moving_samples(motion: PreparedMotion, terms: JointTerms) -> Marks:
    """(N, n), true where an equation counts: the filter has settled, and the joint moves fast enough."""
    return np.asarray(motion.weighs[:, np.newaxis] & (np.abs(motion.qd) >= terms.least_speed))


def columns_apart(values: Array) -> bool:
    """True if the singular values of unit columns (b,) are all above rounding."""
    return bool(values[-1] > LEAST * values[0])


def solve(parts: Sequence[Equations]) -> Regression:
    """The estimate by least squares with weights 1 / sigma of each joint, which two more rounds renew."""
    n = parts[0].tau.shape[1]
    sigma = np.array([_root_mean_square([(p.tau[:, j], p.weights[:, j]) for p in parts]) for j in range(n)])
    sigma = np.where(sigma > 0, sigma, 1.0)
    for _ in range(ROUNDS + 1):
        A = np.vstack([(p.Y * (p.weights / sigma)[..., np.newaxis]).reshape(-1, p.Y.shape[2]) for p in parts])
        b = np.concatenate([(p.tau * p.weights / sigma).ravel() for p in parts])
        length = np.linalg.norm(A, axis=0)
        unit = np.where(length > 0, length, 1.0)
        _, values, directions = np.linalg.svd(A / unit, full_matrices=False)
        theta = np.linalg.lstsq(A / unit, b, rcond=LEAST)[0] / unit
        left = [p.Y @ theta - p.tau for p in parts]
        fresh = [
            _root_mean_square([(e[:, j], p.weights[:, j]) for e, p in zip(left, parts, strict=True)]) for j in range(n)
        ]
        sigma, used = np.maximum(fresh, 1e-12 * sigma), sigma
    least = SMALL_SHARE * float(np.linalg.norm(b)) / unit
    if not columns_apart(values):
        return Regression(theta, np.full((len(theta), len(theta)), np.inf), sigma, values, directions, least)
    inverse = np.linalg.inv((A / unit).T @ (A / unit)) / np.outer(unit, unit)
    scores = sum((_scores(p, e, used) for p, e in zip(parts, left, strict=True)), np.zeros_like(inverse))
    return Regression(theta, inverse @ scores @ inverse, sigma, values, directions, least)


def _root_mean_square(columns: Sequence[tuple[Array, Array]]) -> float:
    total = sum(float(np.sum((column * weight) ** 2)) for column, weight in columns)
    weight = sum(float(np.sum(weight**2)) for _, weight in columns)
    return float(np.sqrt(total / weight)) if weight else 0.0


def _scores(part: Equations, residuals: Array, sigma: Array) -> Array:
    """The covariance of A' e of one experiment by a Bartlett window as long as its residuals are correlated."""
    weighed = residuals * part.weights / sigma
    scores = np.einsum("tjb,tj->tb", part.Y * (part.weights / sigma)[..., np.newaxis], weighed)
    window = min(2 * max(correlation_length(column) for column in weighed.T), len(scores) // 4)
    padded = np.vstack([np.zeros((window, scores.shape[1])), scores, np.zeros((window, scores.shape[1]))])
    total = np.cumsum(padded, axis=0)
    sums = total[window:] - total[:-window]
    return np.asarray(sums.T @ sums / window)


def correlation_length(residuals: Array) -> int:
    """The number of samples after which residuals (N,) are uncorrelated, at least one."""
    size = 1 << (2 * len(residuals) - 1).bit_length()
    power = np.fft.irfft(np.abs(np.fft.rfft(residuals, size)) ** 2)[: len(residuals) // 2]
    below = np.flatnonzero(power < UNCORRELATED * power[0]) if power[0] > 0 else np.array([1])
    return int(below[0]) if below.size else len(residuals) // 2

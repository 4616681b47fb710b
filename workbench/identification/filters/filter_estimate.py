"""The answer of a filter: states, covariances and innovations over the samples, with names and units."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from workbench.core import Layout
from workbench.core.validation.refusals import Array, finite, matrix, whole
from workbench.core.validation.signatures import check_arguments
from workbench.identification.datasets import Dataset
from workbench.identification.filters.array_steps import EPS, definiteness, square_root
from workbench.identification.filters.consistency_test import Consistency, chi_square_bands
from workbench.identification.filters.forward_pass import AbstractPass, Moves, PassRecord
from workbench.identification.filters.smoothing import (
    SmoothedEstimate,
    dataset_of,
    refuse_shape,
    smooth_by_lag,
    smooth_over_all,
)

DIVERGENCE = 1e6  # standard deviations of an innovation


@dataclass(frozen=True, eq=False, repr=False)
@check_arguments
class FilterEstimate:
    """The states that a filter has estimated from N samples, before and after each of them.

    Covariances are held as square roots, P = S S'. So no P has a negative eigenvalue, and `least_correlation` says how
    near to singular the nearest of them is.

    Parameters
    ----------
    t
        (N,), the times of the samples in s, or their numbers.
    states, outputs
        Names, shapes and units of the n states and the q outputs.
    y
        (N, q), the samples that the filter has read; NaN where a sensor had none.
    x_predicted, S_predicted
        (N, n) and (N, n, n), the state before each sample and the square root of its covariance.
    x, S
        The same after each sample.
    innovations
        (N, q), the sample minus the reading that the filter expected; NaN where there is no sample.
    normalised_innovations
        (N, q), the innovations of a sample over the root of their covariance: independent, of variance 1, if the model
        is right. NaN behind the last one where sensors have no sample.
    log_likelihood
        The logarithm of the probability density of all samples, with 2 pi.
    moves
        The moves from sample to sample, for smoothers.
    remarks
        Sentences on what a reader must know, such as that the filter diverged.
    discretisation_error
        The largest change of x, in standard deviations, if the steps between samples are twice as long; None for a
        model in discrete time, or if the caller chose the steps.
    """

    t: Array
    states: Layout
    outputs: Layout
    y: Array
    x_predicted: Array
    S_predicted: Array
    x: Array
    S: Array
    innovations: Array
    normalised_innovations: Array
    log_likelihood: float
    moves: Moves
    remarks: tuple[str, ...] = ()
    discretisation_error: float | None = None

    def __post_init__(self) -> None:
        N, n, q = self.t.size, self.states.size, self.outputs.size
        sizes = {"t": (N,), **dict.fromkeys(("y", "innovations", "normalised_innovations"), (N, q))}
        sizes |= dict.fromkeys(("x_predicted", "x"), (N, n)) | dict.fromkeys(("S_predicted", "S"), (N, n, n))
        for name, shape in sizes.items():
            refuse_shape("FilterEstimate", name, getattr(self, name), shape)

    @cached_property
    def P_predicted(self) -> Array:
        """(N, n, n), the covariance of the state before each sample."""
        return self.S_predicted @ np.swapaxes(self.S_predicted, 1, 2)

    @cached_property
    def P(self) -> Array:
        """(N, n, n), the covariance of the state after each sample."""
        return self.S @ np.swapaxes(self.S, 1, 2)

    @property
    def deviations(self) -> Array:
        """(N, n), the standard deviations of the state after each sample."""
        return np.asarray(np.linalg.norm(self.S, axis=2))

    @cached_property
    def nis(self) -> Array:
        """(N,), the normalised innovations squared, e' cov(e)^-1 e; NaN where no sensor has a sample."""
        squares: Array = np.nansum(self.normalised_innovations**2, axis=1)
        squares[self.sensor_counts == 0] = np.nan
        return squares

    @cached_property
    def sensor_counts(self) -> Array:
        """(N,), the number of sensors that have a sample: the degrees of freedom of `nis`."""
        counts: Array = np.isfinite(self.normalised_innovations).sum(axis=1).astype(float)
        return counts

    @cached_property
    def least_correlation(self) -> float:
        """The least eigenvalue of all covariances, each with variances scaled to 1: the certificate of definiteness.

        It is the square of a singular value of S, and never negative; 0 if a variance is 0.
        """
        return min(definiteness(roots[np.isfinite(roots[:, 0, 0])]) for roots in (self.S_predicted, self.S))

    @check_arguments
    def nees(self, truth: Array) -> Array:
        """(N,), the normalised estimation error squared, (x - truth)' P^-1 (x - truth), for true states (N, n).

        Raises
        ------
        ValueError
            If the shape does not fit, or a covariance is singular.
        """
        truth = matrix("FilterEstimate.nees(truth=...)", truth, *self.x.shape)
        if self.least_correlation < EPS**2:
            raise ValueError(
                "`FilterEstimate.nees(truth=...)` needs covariances with an inverse; a state of this filter has "
                "variance 0: give `P0` or `Q` a variance for it, or leave it out of the model."
            )
        return np.asarray((np.linalg.solve(self.S, (self.x - truth)[:, :, None]) ** 2).sum(axis=(1, 2)))

    @check_arguments
    def consistency(self, truth: Array | None = None, level: float = 0.999) -> Consistency:
        """The tests by chi-square of this run alone: NIS of all samples, and NEES if the true states are known.

        Parameters
        ----------
        truth
            (N, n), the true states, as a simulation has them.
        level
            The probability of each band.
        """
        return consistency([self], None if truth is None else [truth], level)

    @check_arguments
    def smooth(self, lag: int | None = None) -> SmoothedEstimate:
        """The states by all samples (Rauch, Tung and Striebel), or by those up to `lag` samples later."""
        if lag is not None:
            lag = whole("FilterEstimate.smooth(lag=...)", lag, most=max(1, len(self.t) - 1))
        last = int(np.isfinite(self.S[:, 0, 0]).sum())
        if last < len(self.t):
            raise ValueError(
                f"`FilterEstimate.smooth()` needs a filter that stayed finite; this one left the finite numbers at "
                f"sample {last}: see its `remarks`."
            )
        shared = (self.t, self.states, self.x, self.S, self.x_predicted, self.moves)
        return smooth_over_all(*shared) if lag is None else smooth_by_lag(*shared, lag)

    @check_arguments
    def to_dataset(self, name: str = "estimate") -> Dataset:
        """A `Dataset` of the states after each sample, and of their standard deviations as `NAME_deviation`."""
        return dataset_of(name, self.t, self.states, self.x, self.deviations)

    def __repr__(self) -> str:
        remarks = f"; {len(self.remarks)} remark{'s' if len(self.remarks) > 1 else ''}" if self.remarks else ""
        return (
            f"<FilterEstimate of {', '.join(self.states.names)}: {len(self.t)} samples, log-likelihood "
            f"{self.log_likelihood:.4f}{remarks}>"
        )


def estimate_by(model: AbstractPass, x0: Array, P0: Array, R: Array) -> FilterEstimate:
    """The estimate of a pass of a model over its samples."""
    with np.errstate(over="ignore", invalid="ignore"):  # a state that diverges is a remark
        record = model.run(x0, square_root(P0), R)
        log_likelihood = _log_likelihood(record)
    shared = (
        record.x_predicted,
        record.S_predicted,
        record.x,
        record.S,
        record.innovations,
        record.normalised_innovations,
    )
    remarks = _remarks(model, record)
    return FilterEstimate(
        *(model.t, model.states, model.outputs, model.y), *shared, log_likelihood, model.moves(), remarks
    )


def _log_likelihood(record: PassRecord) -> float:
    diagonal = np.abs(np.diagonal(record.roots, axis1=1, axis2=2))
    seen = np.isfinite(diagonal)
    squares = record.normalised_innovations[np.isfinite(record.normalised_innovations)] ** 2
    if not np.isfinite(record.x[-1]).all():
        return -np.inf
    return float(-0.5 * (seen.sum() * np.log(2 * np.pi) + 2 * np.log(diagonal[seen]).sum() + squares.sum()))


def _remarks(model: AbstractPass, record: PassRecord) -> tuple[str, ...]:
    remarks, finite_rows = [], np.isfinite(record.x).all(axis=1)
    if not finite_rows.all():
        k = int(np.argmin(finite_rows))
        remarks.append(
            f"The filter left the finite numbers at sample {k} (t = {model.t[k]:g}); all later values are NaN."
        )
    with np.errstate(invalid="ignore"):
        far = (
            np.abs(record.normalised_innovations).max(
                axis=1, initial=0.0, where=np.isfinite(record.normalised_innovations)
            )
            > DIVERGENCE
        )
    if far.any():
        k = int(np.argmax(far))
        remarks.append(
            f"The filter diverged: from sample {k} (t = {model.t[k]:g}) on, {int(far.sum())} innovations lie more than "
            f"{DIVERGENCE:g} standard deviations from 0, so model, Q or R is wrong."
        )
    return tuple(remarks)


@check_arguments
def consistency(
    estimates: Sequence[FilterEstimate], truths: Sequence[Array] | None = None, level: float = 0.999
) -> Consistency:
    """The tests of filters on M independent runs, as a sweep gives them, by chi-square.

    Parameters
    ----------
    estimates
        The estimates of M runs of the same N samples.
    truths
        The true states (N, n) of each run; without them the innovations alone are tested.
    level
        The probability of each band.

    Raises
    ------
    ValueError
        If there is no run, the runs differ in size, or the level is not between 0 and 1.

    References
    ----------
    Bar-Shalom, Li and Kirubarajan (2001), Estimation with Applications to Tracking and Navigation, section 5.4.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> runs, truths = [], []
    >>> for _ in range(50):
    ...     x = np.cumsum(rng.normal(0.0, [1.0] + 99 * [0.1]))[:, None]
    ...     y = x + rng.normal(0.0, 0.2, (100, 1))
    ...     runs.append(wb.filters.kalman_filter(y, [[1]], [[1]], [[0.01]], [[0.04]], x0=[0], P0=[[1]]))
    ...     truths.append(x)
    >>> wb.filters.consistency(runs, truths).is_consistent
    True
    """
    level = finite("consistency(level=...)", level)
    if not 0 < level < 1:
        raise ValueError(f"`consistency(level=...)` must lie between 0 and 1; got {level:g}.")
    shapes = {estimate.x.shape for estimate in estimates}
    if len(shapes) != 1 or (truths is not None and len(truths) != len(estimates)):
        raise ValueError(
            "`consistency(estimates=..., truths=...)` must be runs of one size, and the true states of each run if "
            f"any; got {len(estimates)} runs of sizes {sorted(shapes)}"
            f"{'' if truths is None else f' and {len(truths)} arrays of true states'}."
        )
    pairs = [] if truths is None else [one.nees(truth) for one, truth in zip(estimates, truths, strict=True)]
    nis, counts = (np.array([getattr(one, key) for one in estimates]) for key in ("nis", "sensor_counts"))
    if not counts.any():
        raise ValueError("`consistency(estimates=...)` must be runs with samples; no sensor of these has one.")
    return chi_square_bands(estimates[0].t, nis, counts, np.array(pairs) if pairs else None, shapes.pop()[1], level)

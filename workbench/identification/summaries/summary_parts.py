"""The parts of a summary of a fit, each as plain data: a number, a sensor, an experiment, a plan."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.identification.datasets.experiment import Marks
from workbench.identification.estimation.fit import Fit
from workbench.identification.experiments import ExperimentDesign

LEVEL = 0.95  # of all intervals of a summary


@dataclass(frozen=True)
class NumberSummary:
    """A number of a fit: its start, estimate, standard error, and interval of 95 % from `low` to `high`, in `unit`.

    `repeated_error` is the standard error to be expected if the same experiments are run once more, and fitted together
    with those of the log.
    """

    name: str
    unit: str
    start: float
    estimate: float
    error: float
    low: float
    high: float
    repeated_error: float


@dataclass(frozen=True)
class SensorSummary:
    """A sensor of a fit: the root mean square of its residuals in `unit`, also as the parts that `Fit` has.

    `misfit` is in units of its noise that was stated, or else of its spread; `hold_out` is the ratio of the residuals
    held out to those of the fit, NaN without a hold-out; `count` and `hold_out_count` are the samples of both.
    """

    name: str
    unit: str
    root_mean_square: float
    noise: float
    misfit: float
    hold_out: float
    count: int
    hold_out_count: int


@dataclass(frozen=True, eq=False)
class ExperimentSummary:
    """An experiment of a fit: times t (N,) in s from its first sample, samples and outputs of the model (N, ny).

    `weighs` and `held_out` (N, ny) are True for samples that the fit saw, and for those that were held out.
    """

    name: str
    t: Array
    samples: Array
    outputs: Array
    weighs: Marks
    held_out: Marks


@dataclass(frozen=True, eq=False)
class PlanSummary:
    """A designed experiment: its duration in s, the standard errors that it promises by name, and what to widen."""

    duration: float
    criterion: str
    errors: dict[str, float]
    active_limits: tuple[str, ...]
    warnings: tuple[str, ...]

    @staticmethod
    def of(design: ExperimentDesign) -> PlanSummary:
        """The summary of a design."""
        until = float(np.ptp(design.dataset.experiments[0].t))
        errors = dict(design.standard_errors)
        return PlanSummary(until, design.criterion, errors, design.active_limits, design.warnings)


def number_summaries(fit: Fit) -> tuple[NumberSummary, ...]:
    """The numbers of a fit in their order."""
    intervals, repeated = fit.intervals(LEVEL), repeated_errors(fit)
    return tuple(
        NumberSummary(one.name, one.unit, one.start, value, error, *intervals[one.name], later)
        for one, value, error, later in zip(
            fit.model.numbers, fit.theta.tolist(), fit.standard_errors.values(), repeated.tolist(), strict=True
        )
    )


def repeated_errors(fit: Fit) -> Array:
    """(nz,), the standard errors if all experiments of a fit are run once more with initial states of their own.

    The covariance of the shared numbers s is halved. Of an initial state x0 the part that comes from s is halved:
    P_xx - P_xs P_ss^-1 P_sx / 2.
    """
    P = fit.covariance
    own = fit.model.places["initial state"]
    shared = np.setdiff1d(np.arange(len(P)), own)
    variances = np.diag(P) / 2
    if own.size:
        cross = P[np.ix_(own, shared)]
        part = np.sum(cross.T * np.linalg.solve(P[np.ix_(shared, shared)], cross.T), axis=0) if shared.size else 0.0
        variances[own] = np.diag(P)[own] - part / 2
    return np.sqrt(variances)


def sensor_summaries(fit: Fit) -> tuple[SensorSummary, ...]:
    """The sensors of a fit in their order."""
    signals = fit.model.dataset.signals
    units = dict(zip(signals.labels, (unit for entry in signals.entries for unit in entry.units), strict=True))
    kept = sum(mask.sum(axis=0) for mask in fit.held_out)
    parts = []
    for j, (name, _) in enumerate(fit.model.outputs):
        sizes = fit.root_mean_squares[name], fit.noise[name], fit.misfit[name], fit.hold_out[name]
        parts.append(SensorSummary(name, units[name], *sizes, int(fit.data.counts[j]), int(np.asarray(kept)[j])))
    return tuple(parts)


def experiment_summaries(fit: Fit) -> tuple[ExperimentSummary, ...]:
    """The experiments of a fit in their order."""
    parts = zip(fit.model.dataset, fit.data.samples, fit.errors, fit.data.weighs, fit.held_out, strict=True)
    return tuple(
        ExperimentSummary(one.name, one.t - one.t[0], samples, samples + error, weighs, kept)
        for one, samples, error, weighs, kept in parts
    )

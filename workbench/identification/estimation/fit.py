"""Fit: the numbers that a log tells, with their uncertainty, and all that speaks against them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy import stats

from workbench.core.validation.notebook_display import table_to_html
from workbench.core.validation.refusals import Array, finite
from workbench.core.validation.signatures import check_arguments
from workbench.identification.datasets.experiment import Marks
from workbench.identification.estimation.fit_search import LEAST_NOISE, SearchEnd, has_noise, spread
from workbench.identification.estimation.identifiability import Identifiability
from workbench.identification.estimation.output_model import OutputModel
from workbench.identification.estimation.residual_tests import ResidualTest, dependence, whiteness
from workbench.identification.estimation.weighed_data import WeighedData

if TYPE_CHECKING:
    import pandas as pd

MISFIT = 1.5  # root mean square of the residuals in standard deviations of a known noise that a model does not explain
WORSE = 1.5  # ratio of the hold-out's residuals to those of the fit
CLOSE = 1e-6  # relative distance to a bound that is none


@dataclass(frozen=True)
class FitCertificate:
    """The accuracy of the computation: the largest figure of all estimates.

    Parameters
    ----------
    to_minimum
        The next step of Newton's method, in standard errors; relative to the estimate for a log without noise.
    by_half_step
        The change of an estimate by half the integration step, in the same unit.
    limit
        The largest figure of both that is passed.
    condition
        The ratio of the largest to the least singular value of the derivatives, each column of length one.
    reason
        Why the search ended, in a clause.
    """

    to_minimum: float
    by_half_step: float
    limit: float
    condition: float
    reason: str

    def __repr__(self) -> str:
        return f"<FitCertificate: {self.to_minimum:.1e} to the minimum, {self.by_half_step:.1e} by half the step>"

    @property
    def is_passed(self) -> bool:
        """True if the estimates are the minimum to 1 % of a standard error, or to 1e-6 for a log without noise."""
        return self.to_minimum <= self.limit and self.by_half_step <= self.limit


@dataclass(frozen=True, eq=False)
class Fit:
    """Estimates of unknown numbers from a dataset, by output errors of least weighted squares.

    `wb.fit` makes one. With `noise` that is known, or normal and estimated, it is the estimate of maximum likelihood.

    Parameters
    ----------
    data
        The model, the samples, and the samples that count.
    held_out
        For each experiment the samples (N, ny) that the fit did not see.
    end
        The end of the search.
    is_noise_known
        True if the standard deviations of the sensors were given.
    certificate
        The accuracy of the computation.
    identifiability
        The directions of the numbers that the experiment can tell.

    References
    ----------
    Ljung (1999), System Identification, sections 7.4 (maximum likelihood), 9.2 (covariance) and 16.6 (residuals).
    """

    data: WeighedData
    held_out: tuple[Marks, ...]
    end: SearchEnd
    is_noise_known: bool
    covariance: Array  # (nz, nz)
    certificate: FitCertificate
    identifiability: Identifiability
    remarks: tuple[str, ...] = ()  # of the data, and of what was left out

    @property
    def model(self) -> OutputModel:
        """The model whose outputs were compared with the samples."""
        return self.data.model

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the estimated numbers."""
        return tuple(number.name for number in self.model.numbers)

    @property
    def theta(self) -> Array:
        """(nz,), the estimates."""
        return self.end.z

    @property
    def values(self) -> dict[str, float]:
        """The estimates by name."""
        return dict(zip(self.names, self.theta.tolist(), strict=True))

    @property
    def standard_errors(self) -> dict[str, float]:
        """The standard errors by name."""
        return dict(zip(self.names, np.sqrt(np.diag(self.covariance)).tolist(), strict=True))

    @property
    def correlation(self) -> Array:
        """(nz, nz), the correlations of the estimates."""
        errors = np.sqrt(np.diag(self.covariance))
        return np.asarray(self.covariance / np.outer(errors, errors))

    @property
    def degrees(self) -> float:
        """Samples that count less the numbers that were estimated."""
        return float(self.data.counts.sum() - len(self.theta))

    @check_arguments
    def intervals(self, level: float = 0.95) -> dict[str, tuple[float, float]]:
        """Intervals by name that hold the true number with the probability `level`, if model and noise are right.

        Each is the estimate plus and minus a quantile times the standard error: the quantile of the normal
        distribution, or that of Student's distribution if the noise is estimated. Both rest on linear outputs.
        """
        level = finite("Fit.intervals(level=...)", level)
        if not 0 < level < 1:
            raise ValueError(f"`Fit.intervals(level=...)` must lie between 0 and 1; got {level:g}.")
        half = (1 + level) / 2
        quantile = float(stats.norm.ppf(half) if self.is_noise_known else stats.t.ppf(half, max(self.degrees, 1.0)))
        errors = self.standard_errors
        return {name: (v - quantile * errors[name], v + quantile * errors[name]) for name, v in self.values.items()}

    @property
    def noise(self) -> dict[str, float]:
        """The standard deviation of the noise of each sensor: given, or estimated from the residuals."""
        return dict(zip([signal for signal, _ in self.model.outputs], self.end.sigma.tolist(), strict=True))

    @cached_property
    def errors(self) -> tuple[Array, ...]:
        """Model minus sample (N, ny) in each experiment."""
        return tuple(self.data.errors(self.theta))

    @property
    def root_mean_squares(self) -> dict[str, float]:
        """The root mean square of the errors by sensor, of the samples that count."""
        return self._root_mean_squares(self.data.weighs)

    def _root_mean_squares(self, masks: tuple[Marks, ...]) -> dict[str, float]:
        names = [signal for signal, _ in self.model.outputs]
        result = {}
        for j, name in enumerate(names):
            parts = [error[mask[:, j], j] for error, mask in zip(self.errors, masks, strict=True)]
            column = np.concatenate(parts)
            result[name] = float(np.sqrt(np.mean(column**2))) if column.size else np.nan
        return result

    @property
    def misfit(self) -> dict[str, float]:
        """By sensor, the root mean square of the errors over the noise that is known, or over the signal's spread."""
        unit = self.end.sigma if self.is_noise_known else spread(self.data)
        return {name: float(value / size) for (name, value), size in zip(self.root_mean_squares.items(), unit, strict=True)}

    @property
    def hold_out(self) -> dict[str, float]:
        """By sensor, the root mean square of the errors on the hold-out over that on the fit; NaN if none was made."""
        inside, outside = self.root_mean_squares, self._root_mean_squares(self.held_out)
        floors = LEAST_NOISE * spread(self.data)
        return {name: float(outside[name] / max(inside[name], floor)) for name, floor in zip(inside, floors, strict=True)}

    @cached_property
    def residual_tests(self) -> tuple[ResidualTest, ...]:
        """Tests of each sensor's residuals in each experiment, for samples without a gap between them."""
        tests = []
        labels = self.model.dataset.signals.labels
        several = len(self.errors) > 1
        for experiment, error, mask in zip(self.model.dataset, self.errors, self.data.weighs, strict=True):
            for j, (signal, _) in enumerate(self.model.outputs):
                if mask[:, j].sum() < 2 * len(self.theta) + 8:
                    continue
                about = f"{signal} of {experiment.name}" if several else signal
                residuals = error[mask[:, j], j]
                tests.append(whiteness(about, residuals))
                for one in self.model.inputs:
                    column = experiment.values[mask[:, j], labels.index(one.signal)]
                    tests.append(dependence(f"{about} on {one.signal}", residuals, column))
        return tuple(tests)

    @property
    def numbers_at_bounds(self) -> tuple[str, ...]:
        """The numbers whose estimate lies on a bound of theirs."""
        near = []
        for number, value in zip(self.model.numbers, self.theta, strict=True):
            size = max(abs(value), abs(number.start), 1e-300)
            if min(abs(value - number.low), abs(number.high - value)) <= CLOSE * size:
                near.append(number.name)
        return tuple(near)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Sentences that speak against the fit, the misfit first."""
        said = []
        for name, size in self.misfit.items():
            if self.is_noise_known and size > MISFIT:
                said.append(
                    f"The model does not explain '{name}': its residuals are {size:.3g} times the noise that was given."
                )
            elif not self.is_noise_known and size > 0.5:
                said.append(f"The model explains little of '{name}': {100 * size:.2g} % of its spread is left.")
        ratios = self.hold_out
        if all(np.isnan(ratio) for ratio in ratios.values()):
            said.append("No sample was held out: the fit was not tried on data that it did not see.")
        said += [
            f"The residuals of '{name}' are {ratio:.3g} times as large on the hold-out as on the fit."
            for name, ratio in ratios.items()
            if ratio > WORSE
        ]
        failed = [f"{test.about} ({test.kind})" for test in self.residual_tests if not test.is_passed]
        if failed and not self.is_exact:
            said.append(
                f"The residuals are no white noise: {', '.join(failed[:4])}{' and others' if len(failed) > 4 else ''}. "
                "The intervals are too narrow for such noise."
            )
        if at := self.numbers_at_bounds:
            said.append(f"An estimate lies on its bound, where its interval does not hold: {', '.join(at)}.")
        if not self.certificate.is_passed:
            said.append(
                f"The estimates are not computed to {self.certificate.limit:g} of their unit: they are "
                f"{self.certificate.to_minimum:.2g} from the minimum, and half the step moves them by "
                f"{self.certificate.by_half_step:.2g}."
            )
        if self.end.agreeing < self.end.starts:
            said.append(f"{self.end.agreeing} of {self.end.starts} searches ended in the best minimum.")
        return (*said, *self.remarks)

    @property
    def is_exact(self) -> bool:
        """True if the log has no noise beyond rounding, as that of a simulation; no standard error means anything."""
        return not self.is_noise_known and not has_noise(self.data, self.end.sigma)

    def to_frame(self) -> pd.DataFrame:
        """A table of the estimates with their units, standard errors and 95 % intervals."""
        import pandas as pd

        intervals = self.intervals()
        rows = [
            (number.unit, number.start, value, error, *intervals[number.name])
            for number, value, error in zip(self.model.numbers, self.theta, self.standard_errors.values(), strict=True)
        ]
        columns = ["unit", "start", "estimate", "standard error", "from", "to"]
        return pd.DataFrame(rows, index=pd.Index(self.names, name="number"), columns=columns)

    def __repr__(self) -> str:
        values = ", ".join(
            f"{name} = {value:.4g} +- {error:.1g}"
            for (name, value), error in zip(self.values.items(), self.standard_errors.values(), strict=True)
        )
        return f"<Fit: {values}{'; ' if self.warnings else ''}{' '.join(self.warnings)}>"

    def _repr_html_(self) -> str:
        frame = self.to_frame().reset_index()
        return table_to_html(f"Fit; {' '.join(self.warnings)}", tuple(frame.columns), frame.to_numpy().tolist())

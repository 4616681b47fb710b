"""Fit: the numbers that a log tells, with their uncertainty, and all that speaks against them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from scipy import stats

from workbench.core.plot_registry import draw
from workbench.core.validation.notebook_display import table_to_html
from workbench.core.validation.refusals import Array, finite
from workbench.core.validation.signatures import check_arguments
from workbench.design.matrices import one_thread
from workbench.engine.factors import Factor
from workbench.identification.datasets.experiment import Marks
from workbench.identification.estimation.fit_bootstrap import Bootstrap, draw_bootstrap
from workbench.identification.estimation.fit_certificate import FitCertificate
from workbench.identification.estimation.fit_factors import apply_initial_states, apply_values, estimates_of
from workbench.identification.estimation.fit_search import LEAST_NOISE, SearchEnd, has_noise, spread
from workbench.identification.estimation.fit_warnings import hold_out_sentences, misfit_sentences
from workbench.identification.estimation.fitted_parameters import FittedParameters, fitted_parameters
from workbench.identification.estimation.identifiability import Identifiability
from workbench.identification.estimation.output_model import OutputModel
from workbench.identification.estimation.profile_likelihood import Limits, ProfileLikelihood, profile_of
from workbench.identification.estimation.refit import Deviance
from workbench.identification.estimation.residual_tests import ResidualTest, residual_tests_of
from workbench.identification.estimation.weighed_data import WeighedData

if TYPE_CHECKING:
    import pandas as pd

T = TypeVar("T")
SHORT = 4  # numbers in one line


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

    @check_arguments
    def profile(self, name: str, level: float = 0.95, *, limits: Limits = None) -> ProfileLikelihood:
        """The profile likelihood of one number, and the interval where it is below its quantile.

        The search ends at `limits`, or at 10 half widths of `intervals` from the estimate, and at the number's bounds.
        A ValueError is raised if the log has no noise, or the level or the limits do not fit.
        """
        self._refuse_exact("profile")
        with one_thread():
            return profile_of(self._deviance, self.theta, self.covariance, name, level, limits)

    @check_arguments
    def bootstrap(self, count: int, seed: int = 0, kind: str = "parametric") -> Bootstrap:
        """The fit repeated on `count` logs with noise drawn anew: "parametric", normal, or "residual", its residuals.

        A ValueError is raised if the log has no noise, or the kind is no other.
        """
        self._refuse_exact("bootstrap")
        unbiased = 1.0 if self.is_noise_known else np.sqrt(self.data.counts.sum() / self.degrees)
        with one_thread():
            return draw_bootstrap(self._deviance, self.theta, unbiased * self.end.sigma, count, seed, kind)

    @check_arguments
    def factors(self, names: Sequence[str] | None = None, *, path: str = "", cut: float = 4.0) -> tuple[Factor, ...]:
        """Factors of a sweep that draw estimated numbers together, with their covariance: by default all parameters.

        `names` may have initial states, too, such as "omega(0)", from which the runs then begin. Delays, offsets and
        scales are numbers of the log and are refused. Each factor is a standard normal number, cut off at `cut`, along
        a principal axis of the correlation: indices of a sweep are those of these directions. `path` is that of the
        fitted system in the loop, such as "plant.". A ValueError is raised if more than 0.1 % of the normal
        distribution lie beyond the bounds of a number.
        """
        if names is None:
            return self.parameters.factors(path=path, cut=cut)
        self._refuse_exact("factors")
        some = fitted_parameters(self.model.numbers, self.theta, self.covariance, "", (), names)
        return some.factors(path=path, cut=cut)

    @check_arguments
    def apply(
        self, target: T, *, values: Mapping[str, float] | None = None, path: str = "", experiment: str | None = None
    ) -> T:
        """A block or an `Ode` with the estimated parameters in place, or with other `values` by name.

        `path` is that of the block in the fitted system, such as "plant."; an unknown one raises a LookupError. With an
        `experiment` it begins in the initial states that were estimated for it, too. Delays, offsets and scales are
        numbers of the log, which no block has.
        """
        own, initial = estimates_of(self.model.numbers, self.theta, values or {}, experiment)
        done = apply_values(own, target, {}, path) if own or not initial else target
        return apply_initial_states(initial, done, path)

    @cached_property
    def parameters(self) -> FittedParameters:
        """The estimated parameters of the system with their covariance: for studies and files, without the log."""
        self._refuse_exact("parameters")
        source = self.model.dataset.source or ", ".join(one.name for one in self.model.dataset)
        return fitted_parameters(self.model.numbers, self.theta, self.covariance, source, self.warnings)

    @cached_property
    def _deviance(self) -> Deviance:
        return Deviance(self.data, self.end.sigma if self.is_noise_known else None)

    def _refuse_exact(self, call: str) -> None:
        if self.is_exact:
            raise ValueError(
                f"`Fit.{call}(...)` needs a log with noise; this one has none beyond rounding, so that nothing is left "
                "in doubt: use `values`, or give `noise`."
            )

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
        pairs = zip(self.root_mean_squares.items(), unit, strict=True)
        return {name: float(value / size) for (name, value), size in pairs}

    @property
    def hold_out(self) -> dict[str, float]:
        """By sensor, the root mean square of the errors on the hold-out over that on the fit; NaN if none was made."""
        inside, outside = self.root_mean_squares, self._root_mean_squares(self.held_out)
        floors = LEAST_NOISE * spread(self.data)
        pairs = zip(inside, floors, strict=True)
        return {name: float(outside[name] / max(inside[name], floor)) for name, floor in pairs}

    @cached_property
    def residual_tests(self) -> tuple[ResidualTest, ...]:
        """Tests of each sensor's residuals in each experiment, for samples without a gap between them."""
        return residual_tests_of(self.data, self.errors, 2 * len(self.theta) + 8)

    @property
    def numbers_at_bounds(self) -> tuple[str, ...]:
        """The numbers whose estimate lies on a bound of theirs."""
        pairs = zip(self.model.numbers, self.theta, strict=True)
        return tuple(number.name for number, value in pairs if number.is_at_bound(value))

    @property
    def warnings(self) -> tuple[str, ...]:
        """Sentences that speak against the fit, the misfit first."""
        said = misfit_sentences(self.misfit, self.is_noise_known) + hold_out_sentences(self.hold_out)
        failed = [f"{test.about} ({test.kind})" for test in self.residual_tests if not test.is_passed]
        if failed and not self.is_exact:
            said.append(
                f"The residuals are no white noise: {', '.join(failed[:4])}{' and others' if len(failed) > 4 else ''}. "
                "The intervals are too narrow for such noise."
            )
        if at := self.numbers_at_bounds:
            said.append(f"An estimate lies on its bound, where its interval does not hold: {', '.join(at)}.")
        if not self.certificate.is_passed:
            said.append(self.certificate.refusal)
        if self.end.agreeing == 1 < self.end.starts - 1:  # one of two tells no more than one alone
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

    def plot(self, kind: str = "outputs") -> object:
        """The picture of a kind: "outputs", "residuals" or "correlations", as `workbench.plot` draws it."""
        return draw(self, kind=kind)

    def __repr__(self) -> str:
        values = ", ".join(
            f"{name} = {value:.4g} +- {error:.1g}"
            for (name, value), error in list(zip(self.values.items(), self.standard_errors.values(), strict=True))[
                :SHORT
            ]
        )
        values += f" and {len(self.names) - SHORT} more" if len(self.names) > SHORT else ""
        return f"<Fit: {values}; {len(self.warnings) or 'no'} warning{'' if len(self.warnings) == 1 else 's'}>"

    def _repr_html_(self) -> str:
        frame = self.to_frame().reset_index()
        return table_to_html(f"Fit; {' '.join(self.warnings)}", tuple(frame.columns), frame.to_numpy().tolist())

"""An estimated polynomial model: parameters with their covariance, tests, and systems for analysis and design."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import lfilter
from scipy.stats import norm

from workbench.core import Entry, Layout
from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array, finite, whole
from workbench.core.validation.signatures import check_arguments
from workbench.design.control_system import System
from workbench.identification.datasets import Dataset
from workbench.identification.linear_models.frequency_estimate import FrequencyEstimate
from workbench.identification.linear_models.gap_innovations import innovations
from workbench.identification.linear_models.gauss_newton import LocalMinimum
from workbench.identification.linear_models.model_residuals import CorrelationTest, input_correlation, whiteness
from workbench.identification.linear_models.model_systems import (
    model_matrices,
    observer_form,
    response_and_gradient,
    response_covariance,
    simulate_record,
)
from workbench.identification.linear_models.polynomial_structure import Polynomials, PolynomialStructure
from workbench.identification.linear_models.prediction_errors import Predictor, Record
from workbench.identification.linear_models.signal_records import LinearSignals, signals_of

GRID = 400  # frequencies of a response, if none are named


@dataclass(frozen=True, eq=False)
@show
class ModelFit:
    """The misfit of a model to the output of a dataset: RMSE, and 100 (1 - |y - y_model| / |y - mean|) in percent.

    `prediction` is one period ahead, `simulation` from the inputs alone. Initial values are fitted in both.
    """

    prediction_rmse: float
    prediction: float
    simulation_rmse: float
    simulation: float


@dataclass(frozen=True, eq=False)
class PolynomialModel:
    """An estimate of A y = sum B_i/F_i q^-nk_i u_i + C/D e, about u0 (nu,) and y0 (1,), at a period in s.

    `theta` (size,) has the parameters in the order of `structure.names`, and `covariance` (size, size) that of the
    estimate. `noise_variance` is that of e, `squares` the sum of its squares over `samples`; with missing outputs and a
    C, times det(H' H)^(1 / samples), see `prediction_errors`. `distance` is the length
    of the last Gauss-Newton step in standard errors; `ends` are the ends of the search. `holdout` is the fit of other
    data, None if there are none. `at_limit` is true if a root of the noise model or of F is held at the unit circle.
    """

    structure: PolynomialStructure
    theta: Array
    covariance: Array
    period: float
    inputs: Layout
    output: Layout
    u0: Array
    y0: Array
    noise_variance: float
    squares: float
    samples: int
    distance: float
    at_limit: bool
    ends: tuple[LocalMinimum, ...]
    predictor: Predictor
    fit: ModelFit
    holdout: ModelFit | None
    remarks: tuple[str, ...] = ()

    @property
    def kind(self) -> str:
        """ARX, ARMAX, output error, Box-Jenkins, FIR or polynomial."""
        return self.structure.kind

    @property
    def polynomials(self) -> Polynomials:
        """A, B, C, D and F in rising powers of q^-1."""
        return self.structure.polynomials(self.theta)

    @property
    def parameters(self) -> Mapping[str, float]:
        """The parameters by their names."""
        return dict(zip(self.structure.names, self.theta.tolist(), strict=True))

    @property
    def standard_errors(self) -> Mapping[str, float]:
        """The standard errors of the parameters by their names."""
        return dict(zip(self.structure.names, np.sqrt(np.diag(self.covariance)).tolist(), strict=True))

    @check_arguments
    def intervals(self, level: float = 0.95) -> Mapping[str, tuple[float, float]]:
        """The intervals of the parameters at a level, by the normal distribution of the estimate."""
        level = finite("intervals(level=...)", level)
        if not 0 < level < 1:
            raise ValueError(f"`intervals(level=...)` must lie between 0 and 1; got {level:g}.")
        reach = norm.ppf((1 + level) / 2) * np.sqrt(np.diag(self.covariance))
        ends = np.column_stack([self.theta - reach, self.theta + reach]).tolist()
        return {name: (low, high) for name, (low, high) in zip(self.structure.names, ends, strict=True)}

    @property
    def AIC(self) -> float:
        """Akaike's criterion N ln(squares / N) + 2 size; Ljung (1999), equation 16.30."""
        return self.samples * float(np.log(self.squares / self.samples)) + 2 * self.structure.size

    @property
    def BIC(self) -> float:
        """The Bayesian criterion N ln(squares / N) + size ln N; Ljung (1999), section 16.4."""
        return self.AIC + self.structure.size * (float(np.log(self.samples)) - 2)

    @check_arguments
    def residual_tests(self, lags: int = 25) -> tuple[CorrelationTest, ...]:
        """The whiteness of the residuals, then their correlation with each input at lags from its delay on.

        Raises
        ------
        ValueError
            If there are fewer samples than four times the lags.
        """
        whole("residual_tests(lags=...)", lags, 1, max(self.samples // 4, 1))
        errors = self.predictor.errors(self.theta)
        residuals, held = self.predictor.residuals(errors.e), self.structure
        white = residuals if errors.basis is None else innovations(self.predictor, self.theta, errors)
        tests = [whiteness(white, lags, held.na + held.nc + held.nd)]
        J = self.predictor.on_grid(errors.J, 0.0)
        for i, label in enumerate(self.inputs.labels):
            inputs = [record.u[i] for record in self.predictor.records]
            name = f"correlation with {label}"
            tests.append(input_correlation(residuals, inputs, J, held.nk[i], lags, name, errors.basis))
        return tuple(tests)

    def to_ss(self) -> System:
        """The system from the inputs to the output as a `StateSpace` in discrete time, about u0 and y0."""
        from workbench.design.linear.sampled_models import sampled_model

        matrices = model_matrices(self.structure, self.polynomials)
        return sampled_model(*matrices, self.period, self.inputs, self.output, self.u0, self.y0, self._name)

    def noise_model(self) -> System:
        """The system C/(D A) from e to the noise at the output, as a `StateSpace` in discrete time."""
        from workbench.design.linear.sampled_models import sampled_model

        model = self.polynomials
        matrices = observer_form(np.convolve(model.D, model.A), [model.C])
        e = Layout((Entry("e", np.zeros(()), self.output.entries[0].unit),))
        return sampled_model(*matrices, self.period, e, self.output, np.zeros(1), self.y0, f"noise of {self._name}")

    def to_continuous(self) -> tuple[System, Array]:
        """The system in continuous time behind a zero-order hold, and the delays (nu,) in s before its inputs.

        Raises
        ------
        DesignError
            If there is none, as `d2c` says.
        """
        from workbench.design.frequency import d2c

        prompt = tuple(min(nk, 1) for nk in self.structure.nk)
        delays = self.period * (np.array(self.structure.nk) - np.array(prompt))
        return d2c(replace(self, structure=replace(self.structure, nk=prompt)).to_ss()), delays

    @check_arguments
    def frequency_response(self, frequencies: Array | None = None, signal: str | None = None) -> FrequencyEstimate:
        """The response from an input, by default the only one, over frequencies (m,) in rad/s, with its covariance.

        Raises
        ------
        LookupError
            If there is no such input, or none is named of several.
        """
        i = self._input(signal)
        top = np.pi / self.period
        omega = np.geomspace(top / 1000, top, GRID) if frequencies is None else frequencies
        G, slope = response_and_gradient(self.structure, self.theta, i, np.exp(1j * omega * self.period))
        spread = response_covariance(slope, self.covariance)
        return FrequencyEstimate(
            f"{self.kind} model", omega, G, spread, self.period, self.inputs.labels[i], self.output.labels[0]
        )

    @check_arguments
    def impulse_response(self, count: int) -> Array:
        """The responses (count, nu) of the output to unit impulses of the inputs: the Markov parameters, D first."""
        size = whole("impulse_response(count=...)", count, 1, 1_000_000)
        impulse, model = np.eye(1, size)[0], self.polynomials
        columns = [lfilter(B, np.convolve(model.A, F), impulse) for B, F in zip(model.B, model.F, strict=True)]
        return np.column_stack(columns)

    def _input(self, signal: str | None) -> int:
        labels = self.inputs.labels
        if signal is None and len(labels) == 1:
            return 0
        if signal not in labels:
            raise LookupError(f"`frequency_response(signal=...)` must name one of the inputs {', '.join(labels)}.")
        return labels.index(signal)

    @check_arguments
    def compare(self, data: Dataset) -> ModelFit:
        """The misfit of predictions and simulations of a dataset, about the same offsets.

        Raises
        ------
        ValueError, LookupError
            As of the estimate, or if the period of the data is another one.
        """
        signals = signals_of("compare(data)", data, self.inputs.labels, self.output.labels)
        if abs(signals.period / self.period - 1) > 1e-6:
            raise ValueError(
                f"`compare(data)` needs data at the period of the model, {self.period:g} s; got {signals.period:g} s: "
                "resample them."
            )
        return fit_of_model(self.structure, self.theta, signals, self.u0, self.y0)

    @property
    def _name(self) -> str:
        return f"{self.kind} model of {self.output.labels[0]}"

    @property
    def summary(self) -> str:
        """A summary in words, the doubts first."""
        whole_fit = f"{self.kind} of {self.structure.size} parameters from {self.samples} samples"
        held = self.holdout
        quality = f"hold-out {held.simulation:.1f} % simulated" if held else "no hold-out"
        return " ".join([*self.remarks[:2], f"{whole_fit}, {quality}."])

    def __repr__(self) -> str:
        values = ", ".join(f"{name} {value:.4g}" for name, value in list(self.parameters.items())[:4])
        more = ", ..." if self.structure.size > 4 else ""
        return f"<{self.kind} model of {self.output.labels[0]} at {self.period:g} s: {values}{more}>"


def fit_of_model(
    structure: PolynomialStructure, theta: Array, signals: LinearSignals, u0: Array, y0: Array
) -> ModelFit:
    """Prediction and simulation of some signals by parameters theta, with initial values that fit best."""
    records = signals.records(u0, y0)
    at = Predictor(structure, records).errors(theta, gradients=False)
    e, model = at.e / at.scale, structure.polynomials(theta)
    misfit = np.concatenate([_there(r.y - simulate_record(structure, model, r.u, r.y, r.counts), r) for r in records])
    moved = np.concatenate([_there(record.y, record) for record in records])
    size = float(np.linalg.norm(moved - moved.mean()))

    def shares(error: Array) -> tuple[float, float]:
        norm_of = float(np.linalg.norm(error)) if np.isfinite(error).all() else np.inf
        return norm_of / np.sqrt(len(error)), 100 * (1 - norm_of / size)

    return ModelFit(*shares(e), *shares(misfit))


def _there(values: Array, record: Record) -> Array:
    """The values (N,) at the outputs that are not missing."""
    return values if record.counts is None else values[record.counts]

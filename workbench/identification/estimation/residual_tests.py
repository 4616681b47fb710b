"""Tests of a fit's residuals: are they white, and do they still depend on the inputs?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.identification.estimation.weighed_data import WeighedData

LAGS = 20
LEVEL = 0.01  # of a test: the share of perfect models that it blames


@dataclass(frozen=True)
@check_arguments
class ResidualTest:
    """One test of the residuals of a sensor in an experiment.

    Parameters
    ----------
    about
        The sensor, and for a test of dependence the input or the residuals on which it may depend.
    kind
        "whiteness" (Ljung and Box 1978) or "dependence" on an input (Ljung 1999, section 16.6), or of a command on the
        residuals of a reading, whose noise the law of a loop feeds back.
    statistic, degrees
        The statistic, and the degrees of freedom of the chi-square distribution that it has for a perfect model.
    p_value
        The probability that a perfect model has a statistic at least as large.

    Examples
    --------
    >>> from workbench.identification.estimation.residual_tests import whiteness
    >>> noise = np.random.default_rng(0).standard_normal(500)
    >>> whiteness("omega", noise).is_passed, whiteness("omega", np.cumsum(noise)).is_passed
    (True, False)
    """

    about: str
    kind: str
    statistic: float
    degrees: int
    p_value: float

    @property
    def is_passed(self) -> bool:
        """True if a perfect model has residuals like these in at least one of a hundred logs."""
        return self.p_value >= LEVEL


@check_arguments
def whiteness(about: str, residuals: Array) -> ResidualTest:
    """The test that residuals (N,) do not predict each other up to lag 20."""
    e = residuals - residuals.mean()
    n, power = len(e), float(e @ e)
    lags = min(LAGS, max(1, n // 4))
    correlations = np.array([e[k:] @ e[:-k] for k in range(1, lags + 1)]) / (power or 1.0)
    statistic = n * (n + 2) * float(np.sum(correlations**2 / (n - np.arange(1, lags + 1))))
    return ResidualTest(about, "whiteness", statistic, lags, float(stats.chi2.sf(statistic, lags)))


@check_arguments
def dependence(about: str, residuals: Array, values: Array) -> ResidualTest:
    """The test that residuals (N,), taken as white, do not depend on the past values (N,) of an input up to lag 20."""
    e, u = residuals - residuals.mean(), values - values.mean()
    n = len(e)
    lags = min(LAGS, max(1, n // 4))
    past = np.column_stack([np.append(np.zeros(k), u[: n - k]) for k in range(lags + 1)])
    left, sizes, _ = np.linalg.svd(past, full_matrices=False)
    kept = sizes > 1e-8 * sizes.max(initial=0.0)  # an input that is held repeats itself
    explained = float(np.sum((left[:, kept].T @ e) ** 2))
    statistic, degrees = n * explained / (float(e @ e) or 1.0), int(kept.sum())
    return ResidualTest(about, "dependence", statistic, degrees, float(stats.chi2.sf(statistic, max(degrees, 1))))


def residual_tests_of(data: WeighedData, errors: Sequence[Array], least: int) -> tuple[ResidualTest, ...]:
    """Tests of each sensor's `errors` (N, ny) in each experiment that has at least so many samples of it."""
    tests, model = list[ResidualTest](), data.model
    labels, several = model.dataset.signals.labels, len(errors) > 1
    shown = model.ode.outputs
    commands = {label for name in model.ode.drives if name in shown for label in shown[name].labels()}
    for experiment, error, mask in zip(model.dataset, errors, data.weighs, strict=True):
        for j, (signal, label) in enumerate(model.outputs):
            if mask[:, j].sum() < least:
                continue
            about = f"{signal} of {experiment.name}" if several else signal
            residuals = error[mask[:, j], j]
            tests.append(whiteness(about, residuals))
            for one in model.inputs:
                column = experiment.values[mask[:, j], labels.index(one.signal)]
                tests.append(dependence(f"{about} on {one.signal}", residuals, column))
            for i, (other, reading) in enumerate(model.outputs):
                both = mask[:, j] & mask[:, i]
                if label in commands and reading not in commands and both.sum() >= least:
                    tests.append(dependence(f"{about} on residuals of {other}", error[both, j], error[both, i]))
    return tuple(tests)

"""Residuals of a model against the samples that a fit weighs, in standard deviations of the sensors' noise."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.identification.datasets.dataset import Marks
from workbench.identification.estimation.output_model import OutputModel

LARGEST = 1e150  # of a residual, whose square is finite


def finite_or_infinite(residuals: Array) -> Array:
    """The residuals, infinite where a run has diverged or is about to."""
    with np.errstate(invalid="ignore"):
        return np.where(np.abs(residuals) < LARGEST, residuals, np.inf)


@dataclass(frozen=True, eq=False)
class WeighedData:
    """The samples of the outputs of a model, and which of them count.

    `weighs` has for each experiment a mask (N, ny): samples that are finite, not marked and not held out.
    """

    model: OutputModel
    weighs: tuple[Marks, ...]

    @cached_property
    def samples(self) -> tuple[Array, ...]:
        """The samples (N, ny) of the outputs in each experiment."""
        labels = self.model.dataset.signals.labels
        columns = [labels.index(signal) for signal, _ in self.model.outputs]
        return tuple(experiment.values[:, columns] for experiment in self.model.dataset)

    @cached_property
    def counts(self) -> Array:
        """(ny,), how many samples of each sensor count."""
        return np.asarray(sum(mask.sum(axis=0) for mask in self.weighs), dtype=float)

    def errors(self, z: Array) -> list[Array]:
        """Model minus sample (N, ny) in each experiment, for numbers z (nz,)."""
        each = range(len(self.samples))
        return [self.model.values(z[np.newaxis], i)[0] - self.samples[i] for i in each]

    def residuals(self, z: Array, sigma: Array) -> Array:
        """(M,), the errors of the samples that count, over `sigma` (ny,); infinite where a run diverges."""
        parts = [(error / sigma)[mask] for error, mask in zip(self.errors(z), self.weighs, strict=True)]
        r = np.concatenate(parts)
        return finite_or_infinite(r)

    def linearized(self, z: Array, sigma: Array) -> tuple[Array, Array]:
        """The residuals (M,) and their derivatives (M, nz)."""
        residuals, slopes = [], []
        for i, mask in enumerate(self.weighs):
            y, J = self.model.derivatives(z, i)
            residuals.append(((y - self.samples[i]) / sigma)[mask])
            slopes.append((J / sigma[:, np.newaxis])[mask])
        return np.concatenate(residuals), np.concatenate(slopes)

    def sum_of_squares(self, z: Array) -> Array:
        """(ny,), the sum of the squares of the errors that count, of each sensor."""
        each = zip(self.errors(z), self.weighs, strict=True)
        return np.asarray(sum(np.sum(np.where(mask, error, 0.0) ** 2, axis=0) for error, mask in each))

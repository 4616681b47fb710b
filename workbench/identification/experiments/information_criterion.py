"""The criterion of an experiment: a number of the expected covariance of the estimates, each in units of its size."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.identification.estimation.identifiability import RANK

CRITERIA = {
    "D": "log det of the covariance, which is the volume of the ellipsoid of confidence",
    "A": "trace of the covariance, which is the sum of the squared relative standard errors",
}


class InformationCriterion(NamedTuple):
    """log det (D) or trace (A) of the inverse of the Fisher information J^T J (Goodwin and Payne 1977, section 6.2)."""

    name: str  # of `CRITERIA`
    sizes: Array  # (nz,), the units of the numbers

    def covariance(self, J: Array) -> Array:
        """The covariance (nz, nz) for derivatives J (N, ny, nz) in standard deviations of the noise."""
        flat = J.reshape(-1, len(self.sizes)) * self.sizes
        _, s, right = np.linalg.svd(flat, full_matrices=False)
        return np.asarray((right.T / s**2) @ right * np.outer(self.sizes, self.sizes))

    def value(self, J: Array) -> float:
        """The criterion; infinite where the numbers cannot be told."""
        s = self._singular_values(J)
        if s is None:
            return np.inf
        return float(-2 * np.sum(np.log(s))) if self.name == "D" else float(np.sum(s**-2.0))

    def goal(self, J: Array) -> tuple[float, Array | None]:
        """The criterion as a search takes it, D or log A, and its derivatives (N, ny, nz) by J; None if infinite."""
        if self._singular_values(J) is None:
            return np.inf, None
        flat = J.reshape(-1, len(self.sizes)) * self.sizes
        left, s, right = np.linalg.svd(flat, full_matrices=False)
        if self.name == "D":
            value, slopes = float(-2 * np.sum(np.log(s))), -2 * (left / s) @ right
        else:
            total = float(np.sum(s**-2.0))
            value, slopes = float(np.log(total)), -2 * (left / s**3) @ right / total
        return value, np.asarray(slopes * self.sizes).reshape(J.shape)

    def _singular_values(self, J: Array) -> Array | None:
        flat = J.reshape(-1, len(self.sizes)) * self.sizes
        if len(flat) < len(self.sizes) or not np.isfinite(flat).all():
            return None
        s = np.linalg.svd(flat, compute_uv=False)
        return np.asarray(s) if s[-1] > RANK * s[0] else None

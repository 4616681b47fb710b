"""The derivative action kd s / (1 + s / N) on the axis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.matrices import Complex


@dataclass(frozen=True)
class DerivativeAction:
    """kd s / (1 + s / N); nothing for kd = 0."""

    kd: float = 0.0
    N: float = np.inf

    @property
    def limit(self) -> float:
        """The gain at infinity."""
        return self.kd * self.N if self.kd else 0.0

    @property
    def corner(self) -> float:
        """The frequency of its filter in rad/s, 0 for none."""
        return self.N if self.kd else 0.0

    def response(self, omega: Array) -> Complex:
        """Its values at some frequencies."""
        s = 1j * omega
        values: Complex = self.kd * s / (1 + s / self.N)
        return values

    def slopes(self, omega: float) -> tuple[complex, complex, complex]:
        """Its value at one frequency, with its first and second derivative by the frequency."""
        s = 1j * omega
        lag = 1 + s / self.N
        return self.kd * s / lag, 1j * self.kd / lag**2, 2 * self.kd / self.N / lag**3


def law_polynomials(k: float, ki: float, derivative: DerivativeAction) -> tuple[Array, Array]:
    """Numerator and denominator of k + ki/s and a derivative action, highest power first."""
    if not derivative.kd:
        return np.array([k, ki]), np.array([1.0, 0.0])
    N = derivative.N
    return np.array([k + derivative.limit, k * N + ki, ki * N]), np.array([1.0, N, 0.0])

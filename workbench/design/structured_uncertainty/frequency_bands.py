"""The band of frequencies in which one pair of scalings D and G proves one bound, between the samples too.

W(omega) = beta^2 D - M'DM - j (G M - M'G), with M = C (j omega - A)^-1 B + D0, is singular exactly where a Hamiltonian
matrix has an eigenvalue j omega. About a frequency at which W is positive definite it stays so up to the next of them.

References
----------
Boyd, Balakrishnan and Kabamba (1989), A bisection method for computing the H-infinity norm of a transfer matrix, Math.
Control Signals Systems 2. Bauer and Fike (1960), Norms and exclusion theorems, Numerische Mathematik 2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import linalg

from workbench.core.validation.refusals import Array
from workbench.design.matrices import EPS, Complex
from workbench.design.structured_uncertainty.scaling_search import Scalings


@dataclass(frozen=True, eq=False)
class PerturbedSystem:
    """The matrix M(omega) of a stable continuous system, square."""

    A: Array
    B: Array
    C: Array
    D: Array

    def at(self, omega: float) -> Complex:
        """The matrix at a frequency in rad/s, which may be infinite."""
        if math.isinf(omega) or not len(self.A):
            return self.D.astype(complex)
        return np.asarray(self.C @ np.linalg.solve(1j * omega * np.eye(len(self.A)) - self.A, self.B) + self.D)

    def slope(self, omega: float) -> Complex:
        """The derivative of the matrix by the frequency."""
        resolvent = np.linalg.inv(1j * omega * np.eye(len(self.A)) - self.A)
        return np.asarray(-1j * self.C @ resolvent @ resolvent @ self.B)


def clear_band(system: PerturbedSystem, beta: float, scalings: Scalings, omega: float) -> tuple[float, float] | None:
    """The band about a frequency in which the scalings prove the bound beta, or None if they do not at it.

    An infinite upper end is included, as is a lower end of zero.
    """
    if not _holds(system.at(omega), beta, scalings):
        return None
    at_infinity = _holds(system.at(math.inf), beta, scalings)
    if not len(system.A):
        return 0.0, math.inf
    crossings = _crossings(system, beta, scalings)
    if crossings is None:
        return None
    low, high = 0.0, math.inf if at_infinity else 1e300
    for first, last in crossings:
        if first <= omega <= last:
            return None
        if last < omega:
            low = max(low, last)
        else:
            high = min(high, first)
    return low, high


def _holds(M: Complex, beta: float, scalings: Scalings) -> bool:
    """True if W is positive definite beyond rounding at one frequency."""
    D = scalings.D
    size = np.linalg.norm(D) * np.linalg.norm(M) ** 2 + 2 * np.linalg.norm(scalings.G) * np.linalg.norm(M)
    slack = 64 * len(M) * EPS * (size + beta**2 * np.linalg.norm(D))
    try:
        np.linalg.cholesky(beta**2 * D - scalings.form(M) - slack * np.eye(len(M)))
    except np.linalg.LinAlgError:
        return False
    return True


def _crossings(system: PerturbedSystem, beta: float, scalings: Scalings) -> list[tuple[float, float]] | None:
    """Intervals that hold each frequency at which W is singular, or None if rounding hides them."""
    C, D0 = system.C, system.D
    D, jG = scalings.D, 1j * scalings.G
    R = beta**2 * D - D0.T @ D @ D0 + D0.T @ jG - jG @ D0
    S = C.T @ jG - C.T @ D @ D0
    if np.linalg.cond(R) > 1e12:
        return None
    H, doubt = _hamiltonian(system, D, S, R)
    _, (unit, _) = linalg.matrix_balance(H, permute=False, separate=True)
    scale = np.asarray(unit, dtype=float)
    H, doubt = H * scale / scale[:, None], doubt * scale / scale[:, None]
    values, V = np.linalg.eig(H)
    try:
        inverse = np.linalg.inv(V)
    except np.linalg.LinAlgError:
        return None
    wrong = float(np.linalg.norm(np.eye(len(H)) - inverse @ V, np.inf))
    if not wrong < 0.1:
        return None
    # inverse H V is the diagonal of the values but for this much: Gershgorin's circles hold all eigenvalues
    rest = (
        np.abs(H @ V - V * values) + (doubt + 8 * len(H) * EPS * np.abs(H)) @ np.abs(V) + 4 * EPS * np.abs(V * values)
    )
    radii = (np.abs(inverse) @ rest).sum(axis=1) / (1 - wrong)
    return [
        (float(z.imag - r), float(z.imag + r))
        for z, r in zip(values, radii, strict=True)
        if abs(z.real) <= r and z.imag + r >= 0
    ]


def _hamiltonian(system: PerturbedSystem, D: Complex, S: Complex, R: Complex) -> tuple[Complex, Array]:
    """The matrix with an eigenvalue j omega where W(omega) is singular, and a bound of its rounding, entry by entry."""
    A, B, C = system.A, system.B, system.C
    over, across = np.linalg.solve(R, B.T), np.linalg.solve(R, S.conj().T)
    H = np.block([[A - B @ across, -B @ over], [C.T @ D @ C + S @ across, -A.T + S @ over]])
    b, c, s, d, o, x = (np.abs(M) for M in (B, C, S, D, over, across))
    terms = np.block([[b @ x, b @ o], [c.T @ d @ c + s @ x, s @ o]])
    return H, 16 * (len(A) + len(R)) * EPS * float(np.linalg.cond(R)) * terms

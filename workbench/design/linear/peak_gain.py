"""The largest gain of a linear system over all frequencies, also under scalings and phases of its channels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.design.matrices import Complex, Refused
from workbench.validation.refusals import Array
from workbench.validation.views import show

TOLERANCE = 1e-6  # relative, between what is proved and what is reached
ROUNDS = 60
PHASES, LOOKED_AT = 16, 100  # phases of a channel and frequencies from which searches begin
MOST_ON_A_GRID = 3  # channels whose phases are searched together


@dataclass(frozen=True, eq=False)
class Realisation:
    """The matrices of x' = A x + B u, y = C x + D u."""

    A: Array
    B: Array
    C: Array
    D: Array

    def response(self, frequencies: Array) -> Complex:
        """C (i omega - A)^-1 B + D at frequencies (N,) in rad/s: (N, ny, nu)."""
        points = 1j * np.asarray(frequencies)[:, np.newaxis, np.newaxis] * np.eye(len(self.A)) - self.A
        return np.asarray(
            self.C @ np.linalg.solve(points, np.broadcast_to(self.B, (len(points), *self.B.shape))) + self.D
        )

    def scaled(self, d: Array) -> Realisation:
        """The system between scaled channels: diag(d) G diag(d)^-1."""
        return Realisation(self.A, self.B / d, d[:, np.newaxis] * self.C, d[:, np.newaxis] * self.D / d)


@dataclass(frozen=True)
@show
class Peak:
    """The largest gain of a system: it is reached, `below`, at a frequency in rad/s, and nowhere beyond `above`."""

    below: float
    above: float
    frequency: float


def largest_gain(G: Realisation) -> Peak:
    """The H-infinity norm of a stable system: the largest singular value of G(i omega).

    References
    ----------
    Bruinsma and Steinbuch (1990), Systems & Control Letters 14, section 3.
    """
    seen = np.concatenate([[0.0], pole_frequencies(G, 60), np.abs(np.linalg.eigvals(G.A).imag)])
    below, frequency = _highest(G, seen)
    at_infinity = float(np.linalg.norm(G.D, 2))
    if at_infinity > below:
        below, frequency = at_infinity, float("inf")
    if not below:
        return Peak(0.0, 0.0, 0.0)
    for _ in range(ROUNDS):
        gamma = (1 + TOLERANCE) * below
        crossings = crossings_of(G, gamma)
        middles = np.concatenate([crossings, (crossings[1:] + crossings[:-1]) / 2])
        found, at = _highest(G, middles) if len(middles) else (0.0, 0.0)
        if found <= gamma:
            return Peak(below, gamma, frequency)
        below, frequency = found, at
    raise Refused("The largest gain over all frequencies was not found: the eigenvalues are too rough.")


def _highest(G: Realisation, frequencies: Array) -> tuple[float, float]:
    sizes = np.linalg.norm(G.response(frequencies), 2, axis=(-2, -1))
    best = int(np.argmax(sizes))
    return float(sizes[best]), float(frequencies[best])


def crossings_of(G: Realisation, gamma: float) -> Array:
    """The frequencies at which a singular value of G may equal gamma, in order, perhaps with some others."""
    A, B, C, D = G.A, G.B, G.C, G.D
    R = np.linalg.inv(gamma**2 * np.eye(D.shape[1]) - D.T @ D)
    F = A + B @ R @ D.T @ C
    H = np.block([[F, B @ R @ B.T], [-C.T @ (np.eye(len(C)) + D @ R @ D.T) @ C, -F.T]])
    values = np.linalg.eigvals(H)
    # a double eigenvalue on the axis may be moved off it by the root of rounding
    near = np.abs(values.real) <= 1e-6 * (np.abs(values) + 1e-3 * np.abs(values).max(initial=0.0))
    return np.unique(np.abs(values.imag[near]))


def pole_frequencies(G: Realisation, count: int) -> Array:
    """Frequencies in rad/s, spread by powers from far below the slowest pole to far above the fastest."""
    sizes = np.abs(np.linalg.eigvals(G.A))
    sizes = sizes[sizes > 1e-9 * sizes.max(initial=0.0)]
    low, high = (float(sizes.min()), float(sizes.max())) if sizes.size else (1.0, 1.0)
    return np.geomspace(low / 100, 100 * high, count)


def scaled_peak(G: Realisation) -> float:
    """The least H-infinity norm of diag(d) G diag(d)^-1 over constant d > 0 that is found: an upper bound of mu."""
    from scipy.optimize import minimize

    n = len(G.D)
    if n == 1:
        return largest_gain(G).above
    response = G.response(np.concatenate([[0.0], pole_frequencies(G, LOOKED_AT)]))

    def size(logarithms: Array) -> float:
        d = np.exp(np.concatenate([[0.0], logarithms]))
        return float(np.linalg.norm(d[:, np.newaxis] * response / d, 2, axis=(-2, -1)).max())

    best = minimize(size, np.zeros(n - 1), method="Nelder-Mead", options={"xatol": 1e-3, "fatol": 1e-7})
    plain, scaled = (largest_gain(G.scaled(np.exp(np.concatenate([[0.0], at])))).above for at in (0 * best.x, best.x))
    return min(plain, scaled)


def spectral_peak(G: Realisation) -> tuple[float, float]:
    """The largest spectral radius of G(i omega) U over diagonal unitary U, a lower bound of mu, and its frequency."""
    from scipy.optimize import minimize

    n = len(G.D)
    frequencies = np.concatenate([[0.0], pole_frequencies(G, LOOKED_AT)])
    response = G.response(frequencies)
    steps = np.arange(PHASES if n <= MOST_ON_A_GRID else 1) / PHASES
    turns = np.exp(2j * np.pi * np.stack(np.meshgrid(*[steps] * (n - 1)), -1).reshape(-1, n - 1))
    best = (0.0, 0, np.zeros(n - 1))
    for turn in turns:
        radii = np.abs(np.linalg.eigvals(response * np.concatenate([[1.0], turn]))).max(axis=-1)
        k = int(np.argmax(radii))
        if radii[k] > best[0]:
            best = (float(radii[k]), k, np.angle(turn))

    def small(at: Array) -> float:
        unitary = np.exp(1j * np.concatenate([[0.0], at[1:]]))
        return -float(np.abs(np.linalg.eigvals(G.response(np.exp(at[:1]))[0] * unitary)).max())

    start = np.concatenate([[np.log(max(frequencies[best[1]], frequencies[1]))], best[2]])
    end = minimize(small, start, method="Nelder-Mead", options={"xatol": 1e-5, "fatol": 1e-9})
    return max((-float(end.fun), float(np.exp(end.x[0]))), (best[0], float(frequencies[best[1]])))

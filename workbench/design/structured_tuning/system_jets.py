"""A linear system with its derivatives by the parameters that are tuned."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.matrices import Complex


@dataclass(frozen=True, eq=False)
class SystemJet:
    """The matrix M = [A B; C D] (n + ny, n + nu) of a system, and its derivatives (d, n + ny, n + nu).

    `n` is the number of states; the `period` of a sampled system is in s, and None in continuous time.
    `origin` is what the system was taken from, for those who take more from it.
    """

    M: Array
    slopes: Array
    n: int
    period: float | None = None
    origin: object = None

    @property
    def A(self) -> Array:
        """The matrix (n, n) of the states."""
        return self.M[: self.n, : self.n]

    @property
    def B(self) -> Array:
        """The matrix (n, nu) of the inputs."""
        return self.M[: self.n, self.n :]

    @property
    def C(self) -> Array:
        """The matrix (ny, n) of the outputs."""
        return self.M[self.n :, : self.n]

    @property
    def D(self) -> Array:
        """The matrix (ny, nu) of the direct paths."""
        return self.M[self.n :, self.n :]

    @property
    def finite(self) -> bool:
        """True if the system and its derivatives are finite."""
        return bool(np.isfinite(self.M).all() and np.isfinite(self.slopes).all())

    def pull(self, G: Array) -> Array:
        """The gradient (d,) of a function of M whose gradient by M is G."""
        return np.asarray(self.slopes.reshape(len(self.slopes), -1) @ G.ravel())

    def part(self, outputs: Sequence[int], inputs: Sequence[int]) -> SystemJet:
        """The same system with some outputs and inputs alone, by their places."""
        rows = [*range(self.n), *(self.n + i for i in outputs)]
        columns = [*range(self.n), *(self.n + j for j in inputs)]
        return replace(self, M=self.M[np.ix_(rows, columns)], slopes=self.slopes[:, rows][:, :, columns])

    def negative(self) -> SystemJet:
        """The system with the sign of its outputs turned."""
        sign = np.concatenate([np.ones(self.n), -np.ones(len(self.M) - self.n)])[:, np.newaxis]
        return replace(self, M=sign * self.M, slopes=sign * self.slopes)

    def closed_at(self, places: Sequence[int]) -> SystemJet:
        """The system whose inputs at some places are its outputs at the same places; their own outputs are kept."""
        if not places:
            return self
        fed = [self.n + i for i in places]
        rest = [j for j in range(self.M.shape[1]) if j not in fed]
        E = np.linalg.inv(np.eye(len(fed)) - self.M[np.ix_(fed, fed)])
        left = np.eye(len(self.M))
        left[:, fed] += self.M[:, fed] @ E
        right = np.zeros((self.M.shape[1], len(rest)))
        right[rest, range(len(rest))] = 1.0
        right[fed] = E @ self.M[np.ix_(fed, rest)]
        M = self.M[:, rest] + self.M[:, fed] @ right[fed]
        return replace(self, M=M, slopes=_between(left, self.slopes, right))

    def feedback(self, kind: str) -> SystemJet:
        """S = (I + L)^-1 or T = L (I + L)^-1 of the loop gain L that the system is."""
        m = len(self.M) - self.n
        E = np.linalg.inv(np.eye(m) + self.D)
        B, C = self.B, self.C
        S = np.block([[self.A - B @ E @ C, B @ E], [-E @ C, E]])
        left, right = np.eye(len(self.M)), np.eye(len(self.M))
        left[:, self.n :] = np.vstack([-B @ E, -E])
        right[self.n :] = np.hstack([-E @ C, E])
        slopes = _between(left, self.slopes, right)
        if kind == "S":
            return replace(self, M=S, slopes=slopes)
        sign = np.concatenate([np.ones(self.n), -np.ones(m)])[:, np.newaxis]
        T = sign * S
        T[self.n :, self.n :] += np.eye(m)
        return replace(self, M=T, slopes=sign * slopes)

    def plus_direct(self, D: Array) -> SystemJet:
        """The system with a constant matrix added to D."""
        M = self.M.copy()
        M[self.n :, self.n :] += D
        return replace(self, M=M)

    def times(self, output_weights: Array, input_weights: Array) -> SystemJet:
        """The system with each output and each input multiplied by its weight."""
        rows = np.concatenate([np.ones(self.n), output_weights])[:, np.newaxis]
        columns = np.concatenate([np.ones(self.n), input_weights])
        return replace(self, M=rows * self.M * columns, slopes=rows * self.slopes * columns)

    def point(self, omega: float) -> complex:
        """The point s of a frequency, or z of a sampled system."""
        return complex(1j * omega) if self.period is None else complex(np.exp(1j * omega * self.period))

    def response(self, omega: float) -> tuple[Complex, Complex, Complex]:
        """G (ny, nu) at a frequency, with (s I - A)^-1 B (n, nu) and C (s I - A)^-1 (ny, n); G is D at infinity."""
        ny, nu = self.D.shape
        if np.isinf(omega):
            return self.D.astype(complex), np.zeros((self.n, nu), complex), np.zeros((ny, self.n), complex)
        inverse = np.linalg.inv(self.point(omega) * np.eye(self.n) - self.A)
        X, Y = inverse @ self.B, self.C @ inverse
        return self.C @ X + self.D, X, Y

    def cell_slopes(self, X: Complex, Y: Complex, left: Complex, right: Complex) -> Array:
        """The matrix whose product with the derivatives of M is that of Re(left G right), for G of `response`."""
        row, column = np.concatenate([left @ Y, left]), np.concatenate([X @ right, right])
        return np.asarray(np.multiply.outer(row, column).real)


def _between(left: Array, slopes: Array, right: Array) -> Array:
    return np.asarray(np.matmul(np.matmul(left, slopes), right))

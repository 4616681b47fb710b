"""The smooth pieces whose largest value is a figure of a system: those of its poles, and its H2 norm."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg

from workbench.core.validation.refusals import Array
from workbench.design.matrices import Complex
from workbench.design.structured_tuning.system_jets import SystemJet

MOST_PIECES = 8  # of one figure
NEAR = 0.3  # relative distance in frequency up to which a peak or a pole counts as the same one at another point


@dataclass(frozen=True, eq=False)
class FigurePiece:
    """One smooth function at a point: its value, its gradient (d,), and what tells it from its neighbours.

    `figure` is the number of the figure that it is part of, `place` its frequency, and `rank` tells pieces at the same
    place apart.
    """

    value: float
    gradient: Array
    place: float = 0.0
    rank: int = 0
    figure: int = 0

    def same_as(self, other: FigurePiece) -> bool:
        """True for a piece that continues this one at a point nearby."""
        if (self.figure, self.rank) != (other.figure, other.rank):
            return False
        if self.place == other.place:
            return True
        return abs(self.place - other.place) <= NEAR * max(abs(self.place), abs(other.place))


def logarithm(piece: FigurePiece, reference: float, sign: float = 1.0) -> FigurePiece:
    """The piece sign log(value / reference); of a value that is not positive an infinite one."""
    if not piece.value > 0:
        return replace(piece, value=sign * -math.inf if piece.value == 0 else math.inf, gradient=0 * piece.gradient)
    return replace(piece, value=sign * math.log(piece.value / reference), gradient=sign * piece.gradient / piece.value)


def spectral_abscissa(A: Array, period: float | None) -> float:
    """The largest real part of a pole, or the logarithm of the largest |z| over the period."""
    values = np.linalg.eigvals(A) if len(A) else np.array([-np.inf])
    if period is None:
        return float(values.real.max())
    return float(np.log(np.maximum(np.abs(values).max(), 1e-300)) / period)


def pole_pieces(jet: SystemJet, width: float = 0.1) -> list[FigurePiece]:
    """The real parts of the poles that are nearly as large as the largest one; for |z| of a sampled system log|z| / h.

    `width` is the share of the size of the poles within which a pole counts.
    """
    values, left, right = _poles(jet.A)
    values_s = values if jet.period is None else np.log(np.where(values == 0, 1e-300, values)) / jet.period
    growth, size = values_s.real, np.abs(values_s).max(initial=1e-300)
    order = np.argsort(-growth, kind="stable")
    pieces: list[FigurePiece] = []
    for k in order:
        if growth[k] < growth[order[0]] - width * size or len(pieces) == MOST_PIECES:
            break
        if values[k].imag < 0:
            continue
        pieces.append(FigurePiece(float(growth[k]), _pole_gradient(jet, values, left, right, k), float(abs(values[k]))))
    return _ranked(pieces)


def damping_pieces(jet: SystemJet) -> list[FigurePiece]:
    """The cosines Re s / |s| of the poles, the largest first: the least damping with its sign turned."""
    values, left, right = _poles(jet.A)
    s = values if jet.period is None else np.log(np.where(values == 0, 1e-300, values)) / jet.period
    modulus = np.where(s == 0, 1e-300, np.abs(s))
    cosine = s.real / modulus
    pieces: list[FigurePiece] = []
    for k in np.argsort(-cosine, kind="stable")[: 2 * MOST_PIECES]:
        if values[k].imag < 0 or not np.isfinite(cosine[k]):
            continue
        slope = _pole_derivative(jet, values, left, right, k)
        real, imaginary = slope.real, slope.imag
        gradient = (real * s[k].imag ** 2 - s[k].real * s[k].imag * imaginary) / modulus[k] ** 3
        pieces.append(FigurePiece(float(cosine[k]), np.asarray(gradient), float(modulus[k])))
    return _ranked(pieces[:MOST_PIECES])


def _poles(A: Array) -> tuple[Complex, Complex, Complex]:
    """The eigenvalues (n,) with their left and right eigenvectors, as columns."""
    # SciPy's stub forgets one of the three
    values, left, right = scipy.linalg.eig(A, left=True, right=True)  # type: ignore[misc]
    return values, left, right


def _pole_derivative(jet: SystemJet, values: Complex, left: Complex, right: Complex, k: int) -> Complex:
    """The derivative (d,) of a pole s by the parameters, complex."""
    u, v = left[:, k].conj(), right[:, k]
    product, n = complex(u @ v), jet.n
    product = product if abs(product) > 1e-12 else 1e-12
    slope = np.einsum("i,kij,j->k", u, jet.slopes[:, :n, :n], v) / product
    return np.asarray(slope if jet.period is None else slope / (values[k] * jet.period))


def _pole_gradient(jet: SystemJet, values: Complex, left: Complex, right: Complex, k: int) -> Array:
    return np.asarray(_pole_derivative(jet, values, left, right, k).real)


def _ranked(pieces: list[FigurePiece]) -> list[FigurePiece]:
    """The pieces, those at nearly the same place with ranks of their own."""
    made: list[FigurePiece] = []
    for piece in pieces:
        made.append(replace(piece, rank=sum(1 for one in made if replace(one, rank=0).same_as(piece))))
    return made


def h2_piece(jet: SystemJet) -> FigurePiece:
    """The H2 norm of a stable system, and its gradient by two Lyapunov equations; infinite with a direct path."""
    A, B, C, D = jet.A, jet.B, jet.C, jet.D
    if jet.period is None:
        if np.abs(D).max(initial=0.0) > 0:
            return FigurePiece(math.inf, np.zeros(len(jet.slopes)))
        P = scipy.linalg.solve_continuous_lyapunov(A, -B @ B.T)
        Q = scipy.linalg.solve_continuous_lyapunov(A.T, -C.T @ C)
        whole = np.block([[Q @ P, Q @ B], [C @ P, 0 * D]])
        square = float(np.trace(C @ P @ C.T))
    else:
        P = scipy.linalg.solve_discrete_lyapunov(A, B @ B.T)
        Q = scipy.linalg.solve_discrete_lyapunov(A.T, C.T @ C)
        whole = np.block([[Q @ A @ P, Q @ B], [C @ P, D]])
        square = float(np.trace(C @ P @ C.T) + np.sum(D * D))
    norm = math.sqrt(max(square, 0.0))
    if norm == 0:
        return FigurePiece(0.0, np.zeros(len(jet.slopes)))
    return FigurePiece(norm, jet.pull(whole) / norm)

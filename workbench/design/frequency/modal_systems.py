"""A system in coordinates near to those of its modes, in which rounding harms its frequency response least.

With any regular W and V, the system s (W V) q = (W A V) q + W B u, y = C V q + D u has the frequency response and the
poles of A, B, C, D. Here V has the eigenvectors of A, and W is nearly its inverse, in twice the precision: products
with them are enclosed. In a closed loop of large gains, the response is a small difference of large terms; here it is
a sum over modes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.frequency.limit_pencils import Eigensystem, Pencil, refine, wide_inverse
from workbench.design.frequency.wide_matrices import Wide, is_contraction
from workbench.design.riccati.conditioning import Exponents

SWEEPS = 12  # of balancing
MOST = 150  # of an exponent of two, so that nothing underflows
LEAST = 1e-16  # of the largest row or column: one that is smaller is balanced as if it had this size


@dataclass(frozen=True, eq=False)
class ModalSystem:
    """s E q = A q + B u, y = C q + D u; and, with rounding, its `continuous` A, B, C, D by the bilinear transform."""

    E: Wide
    A: Wide
    B: Wide
    C: Wide
    D: Wide
    discrete: bool
    continuous: tuple[Array, Array, Array, Array]

    @staticmethod
    def in_good_units(A: Wide, B: Wide, C: Wide, D: Wide, discrete: bool) -> ModalSystem:
        """The system with its states in units, powers of two, in which their rows and columns have one size."""
        units = _balance(A.high, B.high, C.high)
        E = Wide.of(np.eye(len(units)))
        return _system(E, A.scale(-units, units), B.scale(-units, 0), C.scale(0, units), D, discrete)

    def by_modes(self, steps: int) -> ModalSystem | None:
        """The system in its modes, after some steps of refinement; None where two eigenvectors nearly coincide."""
        n = len(self.A.high)
        try:
            values, vectors = np.linalg.eig(self.A.high)
            pencil = Pencil(self.A, self.E, 0, discrete=False)
            modes = Eigensystem.of(values, np.ones_like(values), vectors, discrete=False)
            V = refine(pencil, modes, steps).vectors
            W = wide_inverse(V)
        except np.linalg.LinAlgError:
            return None
        units = _balance(np.zeros((n, n)), (W @ self.B).high, (self.C @ V).high, modes.blocks)
        V, W = V.scale(0, units), W.scale(-units, 0)
        E = W @ V
        if not is_contraction((E - np.eye(n)).size):
            return None
        return _system(E, W @ self.A @ V, W @ self.B, self.C @ V, self.D, self.discrete)


def _system(E: Wide, A: Wide, B: Wide, C: Wide, D: Wide, discrete: bool) -> ModalSystem:
    a, b, c, d = A.high, B.high, C.high, D.high
    if discrete:
        one = np.eye(len(a))
        inverse = np.linalg.inv(one + a)
        root = np.sqrt(2.0)
        a, b, c, d = inverse @ (a - one), root * inverse @ b, root * c @ inverse, d - c @ inverse @ b
    return ModalSystem(E, A, B, C, D, discrete, (a, b, c, d))


def _balance(A: Array, B: Array, C: Array, blocks: list[tuple[int, int]] | None = None) -> Exponents:
    """Exponents of two by which rows and columns of the states come to one size; those of a block are the same."""
    units = np.zeros(len(A), dtype=int)
    for _ in range(SWEEPS):
        factor = np.exp2(units.astype(float))
        off = A * factor / factor[:, None]
        off = off - np.diag(np.diag(off))
        rows = np.linalg.norm(np.hstack([off, B / factor[:, None]]), axis=1)
        columns = np.linalg.norm(np.vstack([off, C * factor]), axis=0)
        for first, count in blocks or []:
            for sizes in (rows, columns):
                sizes[first : first + count] = sizes[first : first + count].max()
        least = LEAST * max(float(rows.max(initial=0.0)), float(columns.max(initial=0.0)), 1e-300)
        change = np.round(np.log2(np.maximum(rows, least) / np.maximum(columns, least)) / 2).astype(int)
        if not change.any():
            break
        units = np.clip(units + change, -MOST, MOST)
    return units

"""Riccati and Lyapunov equations solved in 300 bits, by roads that the workbench does not take."""

from __future__ import annotations

import flint
import numpy as np

BITS = 300
DIGITS_ENOUGH = 1e-40  # of a step over the solution: far below a float's last digit


def exact(matrix):
    """A float matrix as one of flint's, without rounding."""
    matrix = np.atleast_2d(matrix)
    return flint.arb_mat(*matrix.shape, [flint.arb(float(value)) for value in matrix.ravel()])


def floats(matrix):
    """The nearest floats."""
    return np.array([[float(matrix[i, j]) for j in range(matrix.ncols())] for i in range(matrix.nrows())])


def middle(matrix):
    """The middle of every ball: what is computed is corrected by Newton's method, and needs no enclosure."""
    entries = [matrix[i, j].mid() for i in range(matrix.nrows()) for j in range(matrix.ncols())]
    return flint.arb_mat(matrix.nrows(), matrix.ncols(), entries)


def riccati(A, B, Q, R, X, S=None, E=None, discrete=False):
    """X and K to the last digit by Newton's method from an X nearby; its steps come from Kronecker products."""
    flint.ctx.prec = BITS
    n, m = np.shape(B)
    S, E = np.zeros((n, m)) if S is None else S, np.eye(n) if E is None else E
    a, b, q, r, s, e, x = (exact(matrix) for matrix in (A, B, Q, R, S, E, X))
    for _ in range(60):
        if discrete:
            K = middle((r + b.transpose() * x * b).solve(b.transpose() * x * a + s.transpose(), algorithm="approx"))
            F = a - b * K
            left = F.transpose() * x * F - e.transpose() * x * e
        else:
            K = middle(r.solve(b.transpose() * x * e + s.transpose(), algorithm="approx"))
            F = a - b * K
            left = e.transpose() * x * F + F.transpose() * x * e
        left = left + q - s * K - K.transpose() * s.transpose() + K.transpose() * r * K
        step = _step(F, e, left, discrete)
        x = middle(x + step)
        if np.abs(floats(step)).max() <= DIGITS_ENOUGH * np.abs(floats(x)).max():
            return floats(x), floats(K)
    raise AssertionError("the oracle did not settle")


def lyapunov(A, Q, E=None, discrete=False):
    """X of A X E' + E X A' + Q = 0, or A X A' - E X E' + Q = 0, to the last digit."""
    flint.ctx.prec = BITS
    E = np.eye(len(A)) if E is None else E
    a, q, e, x = exact(A), exact(Q), exact(E), exact(np.zeros_like(Q))
    for _ in range(60):
        if discrete:
            left = a * x * a.transpose() - e * x * e.transpose() + q
        else:
            left = a * x * e.transpose() + e * x * a.transpose() + q
        step = _step(a.transpose(), e.transpose(), left, discrete)
        x = middle(x + step)
        if np.abs(floats(step)).max() <= DIGITS_ENOUGH * np.abs(floats(x)).max():
            return floats(x)
    raise AssertionError("the oracle did not settle")


def margin(A, B, K, E):
    """1 - max |z| over the eigenvalues z of E^-1 (A - B K)."""
    flint.ctx.prec = BITS
    closed = exact(E).solve(exact(A) - exact(B) * exact(K), algorithm="approx")
    return 1 - max(float(abs(z).mid()) for z in flint.acb_mat(middle(closed)).eig(algorithm="approx"))


def _step(F, E, left, discrete):
    """The D of F'DE + E'DF, or F'DF - E'DE, = -left by a dense system of n^2 equations."""
    n = F.nrows()
    first, second, sign = ((F, F), (E, E), -1) if discrete else ((E, F), (F, E), 1)
    places = [(i, j) for i in range(n) for j in range(n)]
    rows = [
        [first[0][k, i] * first[1][m, j] + sign * second[0][k, i] * second[1][m, j] for k, m in places]
        for i, j in places
    ]
    known = flint.arb_mat(n * n, 1, [-left[i, j] for i, j in places])
    D = middle(middle(flint.arb_mat(rows)).solve(known, algorithm="approx"))
    D = flint.arb_mat(n, n, [D[i, 0] for i in range(n * n)])
    return middle((D + D.transpose()) / 2)


def away(value, truth):
    """How far a matrix is from the true one, over the size of that."""
    return float(np.linalg.norm(value - truth) / np.linalg.norm(truth))


def in_order(poles):
    """Poles by their real parts, then by their imaginary ones; a pair's real parts may differ in their last digits."""
    poles = np.asarray(poles, dtype=complex)
    size = np.abs(poles).max()
    return poles[np.lexsort((poles.imag, np.round(poles.real / size, 10)))]

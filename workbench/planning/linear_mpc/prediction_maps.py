r"""The maps from a state and multipliers to the rows of a horizon, about the LQR law.

With u_k = -K_k x_k + d_k, where K_k, S_k = R + B'P_{k+1} B and P_k are the backward Riccati recursion from P_N = P, the
cost is x_0'P_0 x_0 + sum d_k'S_k d_k, and the rows of all stages are y = Y x_0 + T d. So the problem is the least
distance problem

    min d'S d,   low <= Y x_0 + T d <= high,    with   d = -S^-1 T' lambda,   y(lambda) = Y x_0 - D lambda,

D = T S^-1 T', for multipliers lambda of half the cost. T is made of the closed loops A - B K_k, which do not grow where
A does: an unstable plant costs no digits. References: Rossiter, Kouvaritakis and Rice (1998), A numerically robust
state-space approach to stable-predictive control strategies, Automatica 34, for the closed-loop parametrisation.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import cho_factor, cho_solve, cholesky, solve_triangular

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.planning.linear_mpc.linear_problem import LinearMpc


@dataclass(frozen=True, eq=False)
@show
class PredictionMaps:
    """The maps y = Y x_0 + T d and u = V x_0 + G d of a horizon, and the cost x_0'P_0 x_0 + |roots d|^2.

    Parameters
    ----------
    Y, T
        (N nc, nx) and (N nc, N nu), of the rows.
    V, G
        (N nu, nx) and (N nu, N nu), of the inputs.
    roots
        (N nu, N nu), upper triangular blocks, with roots' roots = S.
    P0
        (nx, nx), the cost without limits.
    gains
        (N, nu, nx), K_k.
    """

    Y: Array
    T: Array
    V: Array
    G: Array
    roots: Array
    P0: Array
    gains: Array

    @cached_property
    def unit_rows(self) -> Array:
        """T roots^-1, (N nc, N nu), the map of inputs of unit weight to the rows."""
        return np.asarray(solve_triangular(self.roots, self.T.T, trans="T").T)

    @cached_property
    def dual(self) -> Array:
        """D = T S^-1 T', (N nc, N nc)."""
        return np.asarray(self.unit_rows @ self.unit_rows.T)


@check_arguments
def prediction_maps(problem: LinearMpc) -> PredictionMaps:
    """The maps of a problem's horizon."""
    A, B, N = problem.A, problem.B, problem.horizon
    nx, nu = B.shape
    gains, S, P0 = backward_riccati(problem)
    F, E, nc = problem.rows.F, problem.rows.E, problem.rows.count
    state = np.hstack([np.eye(nx), np.zeros((nx, N * nu))])  # x_k as a map of (x_0, d)
    rows, inputs = [], []
    for k in range(N):
        move = -gains[k] @ state
        move[:, nx + k * nu : nx + (k + 1) * nu] += np.eye(nu)
        rows.append(F @ state + E @ move)
        inputs.append(move)
        state = A @ state + B @ move
    y, u = np.vstack(rows).reshape(N * nc, -1), np.vstack(inputs)
    roots = np.zeros((N * nu, N * nu))
    for k in range(N):
        roots[k * nu : (k + 1) * nu, k * nu : (k + 1) * nu] = cholesky(S[k])
    return PredictionMaps(y[:, :nx], y[:, nx:], u[:, :nx], u[:, nx:], roots, P0, gains)


def backward_riccati(problem: LinearMpc) -> tuple[Array, Array, Array]:
    """K_k (N, nu, nx), S_k (N, nu, nu) and P_0 (nx, nx)."""
    A, B, P = problem.A, problem.B, problem.P
    gains, weights = [], []
    for _ in range(problem.horizon):
        S = problem.R + B.T @ P @ B
        S = (S + S.T) / 2
        K = cho_solve(cho_factor(S), B.T @ P @ A)
        loop = A - B @ K
        P = loop.T @ P @ loop + K.T @ problem.R @ K + problem.Q  # a sum of squares, whatever the rounding
        P = (P + P.T) / 2
        gains.append(K)
        weights.append(S)
    return np.array(gains[::-1]), np.array(weights[::-1]), P

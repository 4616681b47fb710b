"""Problems of predictive control for tests: drawn ones, the cart-pole of the tutorial, and a peer's answer."""

from __future__ import annotations

import casadi as ca
import numpy as np
from scipy.linalg import expm

from workbench.planning import LinearMpc, MpcLimits, mpc_problem

NONE = np.inf


def drawn(rng: np.random.Generator, *, soft: bool) -> LinearMpc:
    """A problem of 1 to 6 states, stable or not, with limits on inputs and on some states."""
    nx, nu, N = int(rng.integers(1, 7)), int(rng.integers(1, 4)), int(rng.integers(2, 16))
    A, B = rng.normal(size=(nx, nx)), rng.normal(size=(nx, nu))
    A *= rng.uniform(0.5, 1.2) / np.abs(np.linalg.eigvals(A)).max()
    Q, R = np.diag(rng.uniform(0.1, 10.0, nx)), np.diag(10.0 ** rng.uniform(-2, 1, nu))
    low, high = -rng.uniform(0.5, 3, nx), rng.uniform(0.5, 3, nx)
    low[rng.random(nx) < 0.5], high[rng.random(nx) < 0.5] = -NONE, NONE
    inputs = (-rng.uniform(0.2, 2, nu), rng.uniform(0.2, 2, nu))
    weight = 10.0 ** rng.uniform(0, 3) if soft else None
    return mpc_problem(A, B, Q, R, N, MpcLimits(inputs=inputs, states=(low, high), soft_weight=weight))


def cart_pole(horizon: int = 20, force: float = 3.0, **limits: object) -> LinearMpc:
    """The cart-pole of the Michigan tutorials upright, at 50 Hz, with its tutorial's weights and |F| limited."""
    M, m, b, length, inertia, g = 0.5, 0.2, 0.1, 0.3, 0.006, 9.8
    a, c = inertia + m * length**2, m * length
    det = (M + m) * a - c**2
    A = np.array(
        [[0, 1, 0, 0], [0, -a * b, c * m * g * length, 0], [0, 0, 0, 1], [0, -c * b, (M + m) * m * g * length, 0]]
    )
    A[[1, 3]] /= det
    B = np.array([[0], [a], [0], [c]]) / det
    both = expm(np.block([[A, B], [np.zeros((1, 5))]]) * 0.02)
    own = MpcLimits(inputs=(-force, force), **limits)  # type: ignore[arg-type]
    return mpc_problem(both[:4, :4], both[:4, 4:], np.diag([5000.0, 0.0, 100.0, 0.0]), [[1.0]], horizon, own)


def peer_answer(problem: LinearMpc, x: np.ndarray) -> tuple[np.ndarray, float] | None:
    """DAQP's first input and objective, of the problem in plain inputs and slacks; None if it finds no solution."""
    A, B, N = problem.A, problem.B, problem.horizon
    (nx, nu), rows = B.shape, problem.rows
    state, move = np.hstack([np.eye(nx), np.zeros((nx, N * nu))]), np.zeros((nu, nx + N * nu))
    H, lines = np.zeros((nx + N * nu,) * 2), []
    for k in range(N):
        move = np.zeros((nu, nx + N * nu))
        move[:, nx + k * nu : nx + (k + 1) * nu] = np.eye(nu)
        H += state.T @ problem.Q @ state + move.T @ problem.R @ move
        lines.append(rows.F @ state + rows.E @ move)
        state = A @ state + B @ move
    H += state.T @ problem.P @ state
    G, soft = np.vstack(lines), np.flatnonzero(np.tile(rows.softness, N))
    weights = 1 / np.tile(rows.softness, N)[soft]
    full = np.block([[H[nx:, nx:], np.zeros((N * nu, len(soft)))], [np.zeros((len(soft), N * nu)), np.diag(weights)]])
    linear = np.r_[2 * H[nx:, :nx] @ x, np.zeros(len(soft))]
    slack = np.zeros((len(G), len(soft)))
    slack[soft, np.arange(len(soft))] = -1
    lhs, at = np.hstack([G[:, nx:], slack]), G[:, :nx] @ x
    solver = ca.conic(
        "peer", "daqp", {"h": ca.DM(2 * full).sparsity(), "a": ca.DM(lhs).sparsity()}, {"error_on_fail": False}
    )
    ends = [np.clip(end - at, -1e20, 1e20) for end in (problem.low, problem.high)]
    answer = solver(h=2 * full, g=linear, a=lhs, lba=ends[0], uba=ends[1])
    if not solver.stats()["success"]:
        return None
    return np.asarray(answer["x"]).ravel()[:nu], float(answer["cost"]) + float(x @ H[:nx, :nx] @ x)

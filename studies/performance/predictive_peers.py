"""Solvers of quadratic programs in the place of a predictive law, called from Python as one who knows them calls them.

Each is prepared once for a problem, gets the new vectors of a period alone, and starts from its last solution. The
linear terms of all periods are computed by NumPy at once.

DAQP and OSQP are wheels of the package index; OSQP takes the condensed problem, too, as it needs 3 % of the time that
it needs for the sparse one. TinyMPC is compiled from its source: `pip install --no-deps tinympc` with CXXFLAGS="-O3
-march=native", as its metadata ask for a SciPy that is too old.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.util import find_spec

import numpy as np

import workbench as wb

# States (M, nx) of following periods to first inputs (M,); it is warm from one call to the next.
Solver = Callable[[wb.Array], wb.Array]


@dataclass(frozen=True)
class CondensedProblem:
    """min u'H u / 2 + (f x)'u,  low <= u <= high,  low_rows <= C u + c x <= high_rows, all rows beyond the inputs soft.

    `weight` is w of the cost w s^2 of a violation s.
    """

    H: wb.Array
    f: wb.Array
    C: wb.Array
    c: wb.Array
    low: wb.Array  # of the inputs, and then of the rows
    high: wb.Array
    weight: float

    @staticmethod
    def of(problem: wb.planning.LinearMpc) -> CondensedProblem:
        """The condensed problem of one input, whose rows are stage by stage."""
        A, B, N, rows = problem.A, problem.B, problem.horizon, problem.rows
        nx, state, states = len(A), np.hstack([np.eye(len(A)), np.zeros((len(A), N))]), list[wb.Array]()
        for k in range(N + 1):  # x_k as a map of (x_0, u)
            states.append(state)
            state = A @ state
            state[:, nx + k : nx + k + 1] += B[:, : min(1, N - k)]
        weights = [*[problem.Q] * N, problem.P]
        cost = 2 * np.sum([x.T @ weight @ x for x, weight in zip(states, weights, strict=True)], axis=0)
        cost[nx:, nx:] += 2 * problem.R[0, 0] * np.eye(N)
        inputs = np.eye(N, N + nx, nx)
        others = [rows.F[1:] @ x + rows.E[1:] @ u[np.newaxis] for x, u in zip(states, inputs, strict=False)]
        C, soft = np.vstack(others), rows.softness[1:]
        low, high = (np.r_[np.full(N, end[0]), np.tile(end[1:], N)] for end in (rows.low, rows.high))
        weight = 1 / float(soft[0]) if len(soft) else np.inf
        return CondensedProblem(cost[nx:, nx:], cost[nx:, :nx], C[:, nx:], C[:, :nx], low, high, weight)


def daqp(problem: wb.planning.LinearMpc) -> Solver:
    """DAQP, whose active set stays from one period to the next."""
    from daqp import Model

    qp, model, N = CondensedProblem.of(problem), Model(), problem.horizon
    soft = len(qp.C)
    sense = np.r_[np.zeros(N), np.full(soft, 8)].astype(np.int32)
    model.setup(qp.H, np.zeros(N), qp.C, qp.high, qp.low, sense)
    if soft:
        model.soft_weights(*[np.full(N + soft, 1 / (2 * qp.weight))] * 2)  # its cost is s^2 / (2 rho)

    def march(x: wb.Array) -> wb.Array:
        moves, update, solve = np.empty(len(x)), model.update, model.solve
        if not soft:
            for i, f in enumerate(x @ qp.f.T):
                update(f=f)
                moves[i] = solve()[0][0]
            return moves
        beside = np.hstack([np.zeros((len(x), N)), x @ qp.c.T])
        vectors = zip(x @ qp.f.T, qp.high - beside, qp.low - beside, strict=True)
        for i, (f, high, low) in enumerate(vectors):
            update(f=f, bupper=high, blower=low)
            moves[i] = solve()[0][0]
        return moves

    return march


def daqp_clock(problem: wb.planning.LinearMpc, x: wb.Array) -> wb.Array:
    """The seconds (M,) of each solution by DAQP's own clock, which has neither its update nor Python."""
    from daqp import Model

    qp, model, spent = CondensedProblem.of(problem), Model(), np.empty(len(x))
    model.setup(qp.H, np.zeros(problem.horizon), qp.C, qp.high, qp.low, np.zeros(problem.horizon, dtype=np.int32))
    for i, f in enumerate(x @ qp.f.T):
        model.update(f=f)
        spent[i] = model.solve()[3]["solve_time"]
    return spent


def osqp(problem: wb.planning.LinearMpc) -> Solver:
    """OSQP at its default tolerance, from the last solution."""
    from osqp import OSQP
    from scipy import sparse

    qp, model, N = CondensedProblem.of(problem), OSQP(), problem.horizon
    model.setup(
        sparse.csc_matrix(np.triu(qp.H)), np.zeros(N), sparse.eye(N, format="csc"), qp.low, qp.high, verbose=False
    )

    def march(x: wb.Array) -> wb.Array:
        moves, update, solve = np.empty(len(x)), model.update, model.solve
        for i, f in enumerate(x @ qp.f.T):
            update(q=f)
            moves[i] = solve(raise_error=False).x[0]
        return moves

    return march


def tinympc(problem: wb.planning.LinearMpc) -> Solver:
    """TinyMPC at its default penalty and tolerance, by the functions of its extension, without those in Python."""
    from tinympc import TinyMPC

    model, N = TinyMPC(), problem.horizon
    model.setup(problem.A, problem.B, problem.Q, problem.R, N + 1, u_min=problem.rows.low, u_max=problem.rows.high)
    model.update_settings(en_state_bound=False)

    def march(x: wb.Array) -> wb.Array:
        moves, inner = np.empty(len(x)), model._solver
        start, solve = inner.set_x0, inner.solve
        with _without_output():  # it prints a line for each solution
            for i, row in enumerate(x):
                start(row)
                solve()
                moves[i] = inner.solution.u[0, 0]
        return moves

    return march


@contextmanager
def _without_output() -> Iterator[None]:
    """Send what a library prints to nowhere."""
    sys.stdout.flush()
    own, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
    finally:
        os.dup2(own, 1)
        os.close(own)
        os.close(nowhere)


@dataclass(frozen=True)
class PredictivePeer:
    """A solver of a package: `bar` is how many times as fast we must be."""

    name: str
    package: str
    bar: float
    solver: Callable[[wb.planning.LinearMpc], Solver]

    @property
    def is_installed(self) -> bool:
        """True where the package is here."""
        return find_spec(self.package) is not None


PREDICTIVE_PEERS = (
    PredictivePeer("DAQP", "daqp", 40.0, daqp),
    PredictivePeer("TinyMPC", "tinympc", 60.0, tinympc),
    PredictivePeer("OSQP", "osqp", 300.0, osqp),
)

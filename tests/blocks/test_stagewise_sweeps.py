"""The sweeps of a predictive law on drawn problems, against the quadratic programming of CasADi's wheel (DAQP)."""

import casadi as ca
import numpy as np
import pytest

from workbench.blocks.laws.stagewise_sweeps import StageRows, StageWeights, solve_definite, solve_stages

STAGES, SWEEPS = 15, 30


class DrawnProblem:
    """A linear-quadratic problem over stages with hard limits of inputs and soft rows, drawn by a seed."""

    def __init__(self, seed, nx, nu, nr, size):
        rng = np.random.default_rng(seed)
        A0 = rng.normal(size=(nx, nx))
        A0 *= size / np.abs(np.linalg.eigvals(A0)).max()
        B0, C = 0.3 * rng.normal(size=(nx, nu)), rng.normal(size=(nr, nx))
        self.A = [A0 + 0.05 * rng.normal(size=(nx, nx)) for _ in range(STAGES)]
        self.B = [B0 + 0.1 * rng.normal(size=(nx, nu)) for _ in range(STAGES)]
        self.Q, self.R = np.diag(10 ** rng.uniform(-2, 2, nx)), np.diag(10 ** rng.uniform(-2, 0, nu))
        self.P, self.w, self.C = 10 * self.Q, 10 ** rng.uniform(0, 2, nr), C
        self.u = rng.uniform(-1.0, 1.0, (STAGES, nu))
        self.r, self.s = 0.1 * rng.normal(size=(STAGES + 1, nx)), 0.1 * rng.normal(size=(STAGES, nu))
        self.x = [10 * rng.normal(size=nx)]
        for A, B, u in zip(self.A, self.B, self.u, strict=True):
            self.x.append(A @ self.x[-1] + B @ u)
        self.ends = -0.3 * np.abs(C @ self.x[0]) - 1e-3, 0.5 * np.abs(C @ self.x[0]) + 1e-3

    def by_sweeps(self, count):
        """The inputs (STAGES, nu) and the residual after some sweeps."""
        ones = np.ones(self.u.shape[1])
        values = (self.Q, self.R, self.P, -ones, ones, *self.ends, self.w)
        weights = StageWeights(*(ca.SX(ca.DM(value)) for value in values))
        columns = []
        for k in range(STAGES):
            parts = self.x[k], self.u[k], self.A[k], self.B[k], self.r[k], self.s[k], self.C @ self.x[k], self.C
            columns.append(np.concatenate([np.ravel(part, order="F") for part in parts]))
        v = ca.SX.sym("v", *self.u.T.shape)
        rows = StageRows(ca.SX(ca.DM(np.array(columns).T)), ca.SX(ca.DM(self.x[-1] - self.r[-1])))
        answer = solve_stages(weights, rows, v, 0 * v, ca.SX(2.0), count)
        v, residual = ca.Function("sweeps", [v], [answer.v, answer.residual])(self.u.T)
        return np.array(v).T, float(residual)

    def by_daqp(self):
        """The inputs (STAGES, nu) of the quadratic program."""
        nu, nr = self.u.shape[1], len(self.w)
        v, d = ca.SX.sym("v", nu, STAGES), ca.SX.sym("d", nr, STAGES)
        x, cost, rows = ca.SX(self.x[0]), 0, []
        for k in range(STAGES):
            e, move = x - self.r[k], v[:, k] - self.s[k]
            cost += e.T @ self.Q @ e + move.T @ self.R @ move + ca.dot(self.w, d[:, k] ** 2)
            rows.append(self.C @ x - d[:, k])
            x = self.A[k] @ x + self.B[k] @ v[:, k]
        e = x - self.r[-1]
        program = {"x": ca.veccat(v, d), "f": cost + e.T @ self.P @ e, "g": ca.vertcat(ca.SX(0, 1), *rows)}
        most = np.r_[np.ones(nu * STAGES), np.full(nr * STAGES, np.inf)]
        ends = {"lbg": np.tile(self.ends[0], STAGES), "ubg": np.tile(self.ends[1], STAGES)} if nr else {}
        answer = ca.qpsol("exact", "daqp", program)(lbx=-most, ubx=most, **ends)
        return np.array(answer["x"])[: nu * STAGES].reshape(STAGES, nu)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("sizes", [(2, 1, 0, 1.0), (4, 2, 0, 1.05), (4, 1, 2, 1.0), (5, 3, 2, 1.05)])
def test_sweeps_solve_the_problem(sizes, seed):
    problem = DrawnProblem(seed, *sizes)
    exact, (v, residual) = problem.by_daqp(), problem.by_sweeps(SWEEPS)
    assert np.abs(exact).max() > 1 - 1e-9  # a limit acts
    np.testing.assert_allclose(v, exact, rtol=0, atol=1e-8)  # as the issue of the law asks
    assert residual < 1e-9


def test_a_residual_says_that_sweeps_are_missing():
    problem = DrawnProblem(1, 4, 2, 0, 1.05)
    (v, residual), exact = problem.by_sweeps(1), problem.by_daqp()
    assert np.abs(v - exact).max() > 1e-3
    assert residual > 1e-3


def test_one_sweep_is_exact_where_no_limit_acts():
    problem = DrawnProblem(2, 4, 2, 0, 0.9)
    problem.R = 1e4 * problem.R
    problem.s = 0.1 * problem.s
    v, exact = problem.by_sweeps(1)[0], problem.by_daqp()
    assert np.abs(exact).max() < 1.0
    np.testing.assert_allclose(v, exact, rtol=0, atol=1e-9)


def test_a_definite_matrix_is_solved_without_pivots():
    rng = np.random.default_rng(0)
    root, right = rng.normal(size=(4, 4)), rng.normal(size=(4, 3))
    H = root @ root.T + np.eye(4)
    answer = ca.Function("solve", [], [solve_definite(ca.SX(ca.DM(H)), ca.SX(ca.DM(right)))])()["o0"]
    np.testing.assert_allclose(H @ np.array(answer), right, rtol=0, atol=1e-12)

"""What has no trustworthy answer is refused by name, and nothing wrong is handed back in silence."""

from __future__ import annotations

import control
import numpy as np
import pytest

from tests.support import riccati_oracles as oracle
from tests.support.cases import heavy_but
from workbench.design.matrices import DesignError
from workbench.design.riccati import care, dare, lqe, lqg, lqr

A, B, I2, ONE = np.array([[0.0, 1], [0, 0]]), np.array([[0.0], [1]]), np.eye(2), np.eye(1)
SPOILT = np.array([[0.0, np.nan], [0, 0]])

BAD = [
    ("not square", (np.ones((2, 3)), B, I2, ONE), r"`care\(A, B, Q, R\)`: A must be square; got shape \(2, 3\)"),
    ("empty", (np.zeros((0, 0)), B, I2, ONE), "A must be a matrix .* not empty"),
    ("no matrix", (np.zeros(2), B, I2, ONE), r"A must be a matrix .* got shape \(2,\)"),
    ("not a number", (SPOILT, B, I2, ONE), r"A\[0, 1\] is nan"),
    ("infinite", (A, np.array([[np.inf], [1]]), I2, ONE), r"B\[0, 0\] is inf"),
    ("complex", (A * 1j, B, I2, ONE), "A must be a matrix of real numbers"),
    ("text", ([["a", "b"], ["c", "d"]], B, I2, ONE), "A must be a matrix of real numbers"),
    ("nothing", (None, B, I2, ONE), "A must be a matrix of real numbers; got None"),
    ("ragged", ([[1, 2], [3]], B, I2, ONE), "A must be a matrix of real numbers"),
    ("huge", (A * 1e308, B, I2, ONE), r"largest entry of A .* A\[0, 1\] is 1e\+308. Choose other units"),
    ("tiny", (A * 1e-320, B, I2, ONE), "largest entry of A must lie between"),
    ("rows of B", (A, np.ones((3, 1)), I2, ONE), r"B must be a matrix of shape \(2, any\).* got shape \(3, 1\)"),
    ("shape of Q", (A, B, np.eye(3), ONE), r"Q must be a matrix of shape \(2, 2\)"),
    ("shape of R", (A, B, I2, I2), r"R must be a matrix of shape \(1, 1\)"),
    ("asymmetric Q", (A, B, [[1, 2], [0, 1]], ONE), r"Q\[0, 1\] is 2 but Q\[1, 0\] is 0"),
    ("asymmetric R", (A, I2, I2, [[1, 0.5], [0, 1]]), "R must be symmetric"),
    ("R zero", (A, B, I2, [[0]]), "R must be positive definite .* from 0 to 0"),
    ("R negative", (A, B, I2, [[-1]]), "R must be positive definite"),
    ("R indefinite", (A, I2, I2, np.diag([1, -1])), "R must be positive definite .* from -1 to 1"),
    ("R singular", (A, I2, I2, np.ones((2, 2))), "R must be positive definite beyond rounding"),
    ("R far off", (A, I2, I2, np.diag([1e150, 1e-150])), "largest entry of R"),
    ("shape of S", (A, B, I2, ONE, np.ones((1, 2))), r"S must be a matrix of shape \(2, 1\)"),
    ("E singular", (A, B, I2, ONE, None, np.ones((2, 2))), "E must have an inverse; its condition number"),
]


@pytest.mark.parametrize(("given", "message"), [case[1:] for case in BAD], ids=[case[0] for case in BAD])
def test_what_is_no_equation_is_refused_in_a_sentence(given, message):
    with pytest.raises(ValueError, match=message):
        care(*given)


def turns(n, many=6):
    rng = np.random.default_rng(n)
    return [np.linalg.qr(rng.normal(size=(n, n)))[0] for _ in range(many)]


def test_a_mode_that_no_input_moves_is_named_in_any_coordinates():
    a, b = np.diag([1.5, -1.0, -2.0]), np.array([[0.0], [1.0], [1.0]])
    for T in [np.eye(3), *turns(3)]:
        with pytest.raises(DesignError, match=r"not stabilisable: no input moves the unstable mode 1\.5 of A"):
            care(T @ a @ T.T, T @ b, np.eye(3), 1)
    for T in [np.eye(3), *turns(3)]:
        with pytest.raises(DesignError, match=r"no input moves the unstable mode 1\.5 of A"):
            dare(T @ np.diag([1.5, 0.5, 0.2]) @ T.T, T @ b, np.eye(3), 1)


def test_a_mode_on_the_boundary_that_costs_nothing_is_named_in_any_coordinates():
    a, b = np.array([[0, 3.0, 0], [-3.0, 0, 0], [0, 0, -1.0]]), np.array([[0.0], [1.0], [1.0]])
    q = np.diag([0.0, 0.0, 1.0])
    for T in [np.eye(3), *turns(3)]:
        with pytest.raises(DesignError, match=r"mode .*3j of A lies on the imaginary axis and costs nothing in Q"):
            care(T @ a @ T.T, T @ b, T @ q @ T.T, 1)
    a = np.array([[0.6, 0.8, 0], [-0.8, 0.6, 0], [0, 0, 0.5]])
    for T in [np.eye(3), *turns(3)]:
        with pytest.raises(DesignError, match=r"mode 0\.6.0\.8j of A lies on the unit circle and costs nothing in Q"):
            dare(T @ a @ T.T, T @ b, T @ q @ T.T, 1)


def test_an_indefinite_q_without_a_stabilising_solution_names_the_eigenvalue():
    # s^4 + 5 s^2 + 1 = 0 has four imaginary roots
    with pytest.raises(DesignError, match=r"Hamiltonian matrix has the eigenvalue 0\+0\.4569j on the imaginary axis"):
        care(A, B, np.diag([1.0, -5.0]), 1)


def test_a_closed_loop_on_the_imaginary_axis_is_refused_in_any_coordinates():
    # Laub (1992): X = [2 1; 1 1] solves the equation, and leaves the poles +-i; rounding may move them either way
    a, b, q = np.array([[3.0, 1], [4, 2]]), np.ones((2, 1)), np.array([[-11.0, -5], [-5, -2]])
    for T in [np.eye(2), *turns(2, 12)]:
        with pytest.raises(DesignError, match="imaginary axis|edge of stability"):
            care(T @ a @ T.T, T @ b, T @ q @ T.T, 1)


@pytest.mark.parametrize("discrete", heavy_but([False, True], False))
def test_an_answer_near_the_end_of_what_can_be_solved_is_right_or_refused(discrete):
    """The input that moves the unstable mode grows weaker until it is lost in the rounding of the turned data."""
    solved = refused = 0
    for weak, T in zip(10.0 ** -np.arange(16.0), turns(3, 16), strict=True):
        a = np.diag([1.3, 0.4, -0.2]) if discrete else np.diag([0.3, -1.0, -2.0])
        b = np.array([[weak], [1.0], [1.0]])
        a, b = T @ a @ T.T, T @ b
        try:
            found = (dare if discrete else care)(a, b, np.eye(3), [[1.0]])
        except DesignError:
            refused += 1
            continue
        X, _ = oracle.riccati(a, b, np.eye(3), [[1.0]], found.X, discrete=discrete)
        assert oracle.away(found.X, X) <= 10 * found.certificate.error
        assert found.certificate.condition * np.finfo(float).eps <= 1e-2
        solved += 1
    assert solved >= 5
    assert refused >= 5


def test_the_weights_of_a_regulator_must_make_a_cost():
    with pytest.raises(ValueError, match=r"`lqr\(A, B, Q, R\)`: Q must be positive semidefinite; its least eigenvalue"):
        lqr(A, B, np.diag([1.0, -1e-3]), 1)
    with pytest.raises(ValueError, match=r"\[Q N; N' R\] must be positive semidefinite, or the cost has no minimum"):
        lqr(A, B, I2, 1, [[0.0], [2.0]])
    with pytest.raises(ValueError, match="Qn must be positive semidefinite"):
        lqe(A, I2, [[1, 0]], -I2, 1)
    with pytest.raises(ValueError, match="Rn must be positive definite"):
        lqe(A, I2, [[1, 0]], I2, 0)


def test_what_lqr_cannot_stabilise_is_named_by_the_mode_and_lqe_by_what_is_not_seen():
    with pytest.raises(DesignError, match="no input moves the unstable mode 2 of A"):
        lqr(np.diag([2.0, -1.0]), B, I2, 1)
    with pytest.raises(DesignError, match="no output sees the unstable mode 2 of A"):
        lqe(np.diag([2.0, -1.0]), I2, [[0.0, 1.0]], I2, 1)


def test_lqg_wants_a_system():
    with pytest.raises(ValueError, match=r"system must be a python-control `StateSpace`; got ndarray"):
        lqg(A, I2, 1, I2, 1)
    with pytest.raises(ValueError, match="Qn must be a matrix of shape"):
        lqg(control.ss(A, B, [[1, 0]], 0), I2, 1, 1, 1)

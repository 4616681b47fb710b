"""Modes that the cut of a loop does not show, and the linear answers of loops with hundreds of states."""

import time

import control
import numpy as np
import pytest

import workbench as wb
from tests.support.cases import heavy_but
from workbench.design.linear import controllability, observability
from workbench.design.linear.hidden_modes import LARGE, MOST, hidden_modes

RANDOM = np.random.default_rng(20261128)
SIGNAL = wb.layout(y="V"), wb.layout(u="V")
LAW = wb.PID(*SIGNAL, Kp=0.1, Ki=0.2)


def turned(A, B, Cy):
    """The same system in other states."""
    T = RANDOM.standard_normal(A.shape)
    return control.ss(T @ A @ np.linalg.inv(T), T @ B, Cy @ np.linalg.inv(T), 0)


def row_of_springs(n):
    """n states of which each pulls at its neighbours, written as functions; the first one is driven and read."""

    def rates(t, x, u):
        first, last = x[1] - 2 * x[0] + u[0], x[n - 2] - 2 * x[n - 1]
        return [first, *(x[i - 1] - 2 * x[i] + x[i + 1] for i in range(1, n - 1)), last]

    A = np.diag(np.full(n, -2.0)) + np.diag(np.ones(n - 1), 1) + np.diag(np.ones(n - 1), -1)
    plant = wb.OdePlant.of(rates, tuple(f"x{i}:V" for i in range(n)), ("u:V",), ("y:V",), h=lambda t, x: [x[0]])
    return plant, (A, np.eye(n)[:, :1], np.eye(n)[:1])


def dense(n):
    """A stable system whose entries are random."""
    A = RANDOM.standard_normal((n, n)) / np.sqrt(n)
    A -= (np.linalg.eigvals(A).real.max() + 0.5) * np.eye(n)
    return A, RANDOM.standard_normal((n, 1)), RANDOM.standard_normal((1, n)) / np.sqrt(n)


def full_matrices(n):
    """A model of python-control, of which each entry is a parameter of the loop."""
    A, B, Cy = dense(n)
    return control.ss(A, B, Cy, 0, inputs="u", outputs="y"), (A, B, Cy)


@pytest.mark.parametrize(("kind", "test"), [("controllable", controllability), ("observable", observability)])
def test_modes_are_hidden_that_fail_the_test_of_hautus(kind, test):
    A = np.diag([-1.0, -2.0, -3.0, -4.0])
    system = turned(A, np.array([[1.0], [0.0], [1.0], [1.0]]), np.array([[1.0, 0.0, 1.0, 1.0]]))
    found, undecided = hidden_modes(system, kind)
    assert undecided == 0
    assert [mode.value for mode in found] == pytest.approx([-2.0], rel=1e-9)
    assert [mode.value for mode in test(system).failing_modes] == pytest.approx([-2.0], rel=1e-9)


def test_a_hidden_mode_of_a_hundred_states_is_found():
    A, B, Cy = dense(99)
    wide = np.block([[A, np.zeros((99, 1))], [np.zeros((1, 99)), -np.eye(1)]])
    system = control.ss(wide, np.vstack([B, [[0.0]]]), np.hstack([Cy, [[1.0]]]), 0)
    found, undecided = hidden_modes(system, "controllable")
    assert (len(found), undecided) == (1, 0)
    assert found[0].value == pytest.approx(-1.0, abs=1e-9)
    assert hidden_modes(system, "observable") == ((), 0)


def test_modes_of_a_long_chain_of_integrators_are_not_decided():
    system = control.ss(np.diag(np.ones(99), 1), np.eye(100)[:, -1:], np.eye(100)[:1], 0)
    found, undecided = hidden_modes(system, "controllable")
    assert len(found) + undecided >= 100 - MOST


@pytest.mark.parametrize(
    ("made", "states"),
    heavy_but(
        [(row_of_springs, LARGE + 5), (row_of_springs, 200), (full_matrices, LARGE + 1)], (row_of_springs, LARGE + 5)
    ),
)
def test_a_plant_of_hundreds_of_states_has_its_linear_answers_in_seconds(made, states):
    plant, (A, B, Cy) = made(states)
    loop = wb.ClosedLoop(plant, controller=LAW, reference=wb.Step("y", "V", 1.0))
    start = time.process_time()
    linear, omega = wb.linear_loop(loop), np.geomspace(1e-2, 1e2, 20)
    gains, remarks = linear.response(omega, "closed", "u_load", "y").values[:, 0, 0], linear.remarks
    assert time.process_time() - start < 60  # some seconds on an idle machine; of 100 full states it took more than 400
    assert not any("not decided" in remark for remark in remarks)
    L = linear.response(omega).values[:, 0, 0]
    plant_gain = np.array([(Cy @ np.linalg.solve(1j * w * np.eye(states) - A, B))[0, 0] for w in omega])
    np.testing.assert_allclose(gains, plant_gain / (1 + L), rtol=1e-8)  # of two ways to solve 100 to 200 equations

"""Poles, and the modes that no input reaches or no output shows."""

import control
import numpy as np
import pytest

from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.blocks.loop import open_loop
from workbench.design.linear import (
    controllability,
    linearize,
    observability,
    poles,
)

I2 = np.eye(2)


def system(A, B, C, **options):
    A, B, C = (np.array(M, dtype=float) for M in (A, B, C))
    return control.ss(A, B, C, np.zeros((len(C), B.shape[1])), **options)


def hidden(seed, value, multiple=1):
    """A system of 6 states in random coordinates with one uncontrollable mode, and its left eigenvector."""
    rng = np.random.default_rng(seed)
    A, B = rng.normal(size=(6, 6)), rng.normal(size=(6, 2))
    B[5] = 0
    for k in range(multiple):  # rows from below: no input, no other state
        A[5 - k, : 6 - k] = 0
        A[5 - k, 5 - k] = value
        if k:
            A[5 - k, 6 - k] = 1.0  # one chain, a Jordan block, of which inputs reach all but the end
    Q, _ = np.linalg.qr(rng.normal(size=(6, 6)))
    return system(Q @ A @ Q.T, Q @ B, np.eye(6)), Q[:, 5]


@pytest.mark.parametrize("seed", range(8))
def test_a_mode_that_no_input_reaches_is_found_with_its_direction(seed):
    made, w = hidden(seed, -0.7)
    found = controllability(made)
    assert not found.holds
    (mode,) = found.failing_modes
    assert mode.value == pytest.approx(-0.7, abs=1e-8)
    # the direction is known as well as the mode is apart from others
    assert abs(abs(mode.direction @ w) - 1) < 1e-8
    assert mode.margin < 1e-14


@pytest.mark.parametrize("seed", range(4))
def test_a_defective_mode_is_found_though_rounding_splits_it(seed):
    made, _ = hidden(seed, -0.7, multiple=3)
    # three equal eigenvalues are moved by the third root of rounding, 1e-5
    assert np.abs(np.linalg.eigvals(made.A) + 0.7).min() > 1e-8
    found = controllability(made)
    assert found.failing_modes
    assert all(mode.value == pytest.approx(-0.7, abs=1e-6) for mode in found.failing_modes)
    assert found.failing_modes[0].margin < 1e-12


@pytest.mark.parametrize("seed", range(8))
def test_random_systems_are_controllable_and_observable_with_margins_that_are_distances(seed):
    rng = np.random.default_rng(100 + seed)
    A, B, C = rng.normal(size=(4, 4)), rng.normal(size=(4, 1)), rng.normal(size=(1, 4))
    made = system(A, B, C)
    assert controllability(made).holds
    assert observability(made).holds
    mode = controllability(made).modes[0]
    if abs(mode.value.imag) < 1e-12:  # else the nearest uncontrollable pair is complex
        w, value = mode.direction.real, mode.value.real
        row = w @ np.hstack([value * np.eye(4) - A, B])
        change = np.outer(w, row)  # of norm margin: it hides the mode
        size = np.linalg.norm(np.hstack([A, B]), 2)
        assert np.linalg.norm(change, 2) == pytest.approx(mode.margin * size, rel=1e-9)
        assert not controllability(system(A + change[:, :4], B - change[:, 4:], C)).holds


@pytest.mark.parametrize("seed", range(4))
def test_observability_is_controllability_of_the_transpose(seed):
    rng = np.random.default_rng(seed)
    A, C = rng.normal(size=(5, 5)), rng.normal(size=(2, 5))
    margins = [mode.margin for mode in observability(system(A, np.ones((5, 1)), C)).modes]
    other = [mode.margin for mode in controllability(system(A.T, C.T, np.eye(5))).modes]
    np.testing.assert_allclose(margins, other, rtol=1e-9)


def test_an_integrator_that_nothing_drives_is_not_controllable():
    found = controllability(system([[0, 0], [0, -1]], [[0], [1]], I2, states=["drift", "lag"]))
    assert str(found).startswith("not controllable: no input moves the mode 0 1/s along drift (margin 0")


def test_the_arm_with_one_torque_alone_names_no_lost_mode_and_without_gravity_it_does():
    G = linearize(open_loop(Manipulator(paper_arm(), q=[0, 0])), 0.0, np.zeros(4))
    assert controllability(G).holds
    second = control.ss(G.A, G.B[:, 1:], G.C, 0, states=G.state_labels)
    assert controllability(second).holds
    still = control.ss(np.array(G.A) * [[1], [1], [0], [0]], G.B[:, 1:], G.C, 0, states=G.state_labels)
    found = controllability(still)  # one torque on two free masses: a turn that it cannot start
    assert not found.holds
    assert set(found.failing_modes[0].states) <= {"q[0]", "q[1]", "qd[0]", "qd[1]"}
    assert "not controllable: no input moves the mode 0 1/s along" in str(found).replace("-0 1/s", "0 1/s")


def test_poles_know_damping_frequency_and_the_states_that_take_part():
    omega, zeta = 5.0, 0.3
    A = np.zeros((3, 3))
    A[:2, :2] = [[0, 1], [-(omega**2), -2 * zeta * omega]]
    A[2, 2] = -40
    found = poles(system(A, np.ones((3, 1)), np.eye(3), states=["q", "qd", "lag"]))
    np.testing.assert_allclose([p.frequency for p in found], [5, 5, 40], rtol=1e-12)
    np.testing.assert_allclose([p.damping for p in found], [0.3, 0.3, 1.0], rtol=1e-12)
    assert [set(p.states) for p in found] == [{"q", "qd"}, {"q", "qd"}, {"lag"}]
    assert found[2].condition == pytest.approx(1, rel=1e-12)


def test_the_pole_of_a_sampled_lag_is_that_of_the_lag():
    sampled = control.c2d(control.ss(-3.0, 1, 1, 0), 0.01)
    (pole,) = poles(sampled)
    assert pole.frequency == pytest.approx(3.0, rel=1e-12)
    assert pole.damping == pytest.approx(1.0)


def test_a_defective_pole_has_no_finite_condition():
    # a double eigenvalue in one chain: 1 / (w' v) is limited by rounding alone
    assert poles(system([[-1, 1], [0, -1]], [[0], [1]], I2))[0].condition > 1e12


def test_equal_poles_of_states_apart_keep_their_states_and_a_condition_of_one():
    found = poles(system(-I2, I2, I2, states=["a", "b"]))
    assert {pole.states for pole in found} == {("a",), ("b",)}
    assert [pole.condition for pole in found] == [1.0, 1.0]


def test_the_condition_bounds_how_far_a_pole_moves():
    rng = np.random.default_rng(2)
    A = np.triu(rng.normal(size=(4, 4))) + np.diag([-1.0, -3.0, -6.0, -10.0])
    before = poles(system(A, np.ones((4, 1)), np.eye(4)))
    E = rng.normal(size=(4, 4))
    E *= 1e-7 / np.linalg.norm(E, 2)
    moved = np.linalg.eigvals(A + E)
    for pole in before:
        # first order in the change: the second is 1e-7 of it
        assert np.abs(moved - pole.value).min() <= 1.001e-7 * pole.condition


@pytest.mark.parametrize("call", [controllability, observability, poles])
def test_what_is_no_system_is_refused(call):
    with pytest.raises(ValueError, match="must be a `StateSpace` of python-control"):
        call(np.eye(2))
    with pytest.raises(ValueError, match="finite matrices"):
        call(control.ss([[np.nan]], [[1]], [[1]], 0))


def test_a_tolerance_below_rounding_is_refused():
    with pytest.raises(ValueError, match="tolerance.*between rounding, 2e-16, and 1; got 0"):
        controllability(system(I2, I2, I2), tolerance=0.0)


@pytest.mark.parametrize("multiple", [4, 6, 8])
def test_a_defective_mode_of_high_order_is_found(multiple):
    """Rounding moves a sixfold eigenvalue by its sixth root, 2e-3; no input reaches the last state of the chain."""
    rng = np.random.default_rng(multiple)
    b = np.append(rng.normal(size=multiple - 1), 0.0)
    T = np.linalg.qr(rng.normal(size=(multiple, multiple)))[0]
    A = T @ (2 * np.eye(multiple) + np.eye(multiple, k=1)) @ T.T
    lost = system(A, (T @ b)[:, np.newaxis], np.eye(multiple))
    assert not controllability(lost).holds


def test_a_pole_at_zero_of_a_sampled_system_is_gone_at_once():
    (pole,) = poles(system([[0.0]], [[1.0]], [[1.0]], dt=0.1))
    assert pole.frequency == np.inf
    assert pole.damping == 1

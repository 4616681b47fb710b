"""Gains of a state observer: poles, noise, peaking and tolerated mismatch against closed forms and other roads."""

import casadi as ca
import numpy as np
import pytest
from scipy.linalg import solve_continuous_lyapunov

from workbench.arms.dynamics import Dynamics
from workbench.arms.mechanics import paper_arm
from workbench.arms.mechanics.planar_arm import PlanarArm, PointMass
from workbench.arms.observer_gains import (
    Gains,
    Mismatch,
    Region,
    audit,
    by_poles,
    error_dynamics,
    frozen_poles,
    frozen_poles_over,
    high_gain,
    lipschitz,
    noise,
    peaking,
    tolerated_mismatch,
)
from workbench.arms.observers import Luenberger
from workbench.design.matrices import DesignError

I, ZERO = np.eye(2), np.zeros((1, 2))
PAPER = Gains(30 * I, 50 * I)
BOX = Region([5.0, 5.0], [30.0, 30.0])
DYNAMICS = Dynamics.of(paper_arm())
MISMATCH = Mismatch.of(DYNAMICS)
PENDULUM = Dynamics.of(PlanarArm((PointMass(2.0, 0.5),), 9.81))


def states(count, rng):
    return rng.uniform(-np.pi, np.pi, (count, 2)), rng.uniform(-5, 5, (count, 2)), rng.uniform(-30, 30, (count, 2))


def test_the_jacobian_is_the_difference_quotient_of_the_acceleration():
    rng, h = np.random.default_rng(1), 1e-6
    q, qd, tau = states(20, rng)
    J = MISMATCH.at(q, qd, tau)
    for i in range(20):
        x = np.concatenate([q[i], qd[i]])
        for k in range(4):
            step = h * np.eye(4)[k]
            ends = [DYNAMICS.acceleration(*np.split(x + sign * step, 2), tau[i]) for sign in (1, -1)]
            # central differences: h^2 times third derivatives of up to 1e4, and rounding of 1e3 * 1e-16 / h
            np.testing.assert_allclose(J[i][:, k], (ends[0] - ends[1]) / (2 * h), atol=1e-5)


def test_its_coefficients_add_up_to_it():
    q, qd, tau = states(50, np.random.default_rng(2))
    A, _, R = MISMATCH.expand(q, np.zeros_like(q))
    J = np.einsum("bk,bkij->bij", MISMATCH.monomials(qd, qd**2, tau), A)
    np.testing.assert_allclose(J, MISMATCH.at(q, qd, tau), atol=1e-11)  # rounding of numbers of some hundred
    assert R.max() < 1e-10


def test_the_vertices_hold_every_speed_and_torque_in_their_hull():
    """In any direction the monomials of states do not reach beyond the farthest vertex."""
    rng = np.random.default_rng(3)
    Y = MISMATCH.vertices(BOX)
    _, qd, tau = states(5000, rng)
    y = MISMATCH.monomials(qd, qd**2, tau)
    for direction in rng.normal(size=(200, Y.shape[1])):
        assert (y @ direction).max() <= (Y @ direction).max() * (1 + 1e-12)


def test_the_enclosure_holds_the_coefficients_all_over_a_box():
    rng = np.random.default_rng(4)
    c, r = rng.uniform(-3, 3, (30, 2)), rng.uniform(0.01, 0.3, (30, 2))
    A, L, R = MISMATCH.expand(c, r)
    for _ in range(20):
        step = rng.uniform(-1, 1, (30, 2)) * r
        there = MISMATCH.expand(c + step, np.zeros_like(c))[0]
        gap = np.abs(there - A - np.einsum("bl,blkij->bkij", step, L))
        assert (gap <= R + 1e-10).all()  # what is compared is itself rounded


def test_the_poles_are_those_of_the_observer_block():
    """The error's Jacobian from the block (10) itself, differentiated by CasADi along another road."""
    rng = np.random.default_rng(5)
    (q,), (qd,), (tau,) = states(1, rng)
    observer = Luenberger(paper_arm(), PAPER.L1, PAPER.L2, q_hat=np.zeros(2))
    z, torque = ca.SX.sym("z", 4), ca.SX.sym("tau", 2)
    model = paper_arm().acceleration(z[:2], z[2:], torque)
    rate = ca.vertcat(z[2:] - observer.L1 @ z[:2], model - observer.L2 @ z[:2])
    A = np.array(ca.Function("A", [z, torque], [ca.jacobian(rate, z)])(np.concatenate([q, qd]), tau))
    ours = frozen_poles(MISMATCH, PAPER, q[None], qd[None], tau[None])[0]
    np.testing.assert_allclose(np.sort_complex(ours), np.sort_complex(np.linalg.eigvals(A)), atol=1e-9)


def test_near_rest_the_papers_poles_are_those_of_the_linear_pendulums():
    """At q = 0, M^-1 dG/dq has the eigenvalues w^2, and each mode the poles of s^2 + 30 s + 50 + w^2."""
    M, _, _ = DYNAMICS.matrices(np.zeros(2), np.zeros(2))
    stiffness = 9.81 * np.array([[3.0, 1.0], [1.0, 1.0]])
    squares = np.linalg.eigvals(np.linalg.solve(M, stiffness)).real
    wanted = np.concatenate([np.roots([1, 30, 50 + w]) for w in squares])
    ours = frozen_poles(MISMATCH, PAPER, ZERO, ZERO, ZERO)[0]
    np.testing.assert_allclose(np.sort(ours.real), np.sort(wanted.real), rtol=1e-10)  # rounding


def test_the_papers_gains_are_unstable_in_frozen_time_at_a_seventh_of_the_box():
    seen = frozen_poles_over(MISMATCH, PAPER, BOX)
    assert seen.unstable == pytest.approx(0.14, abs=0.01)  # 20,000 states: 0.0025 of standard error if independent
    assert seen.slowest < -5


@pytest.mark.parametrize(("l1", "l2"), [(30.0, 50.0), (60.0, 900.0), (3.0, 40.0)])
def test_noise_of_one_joint_has_its_closed_form(l1, l2):
    """s^2 + l1 s + l2 driven by noise through (l1 s + l2, l2 s): variances (l1^2 + l2) / (2 l1) and l2^2 / (2 l1)."""
    found = noise(Gains([[l1]], [[l2]]))
    assert found.position == pytest.approx(np.sqrt((l1**2 + l2) / (2 * l1)), rel=1e-12)
    assert found.velocity == pytest.approx(np.sqrt(l2**2 / (2 * l1)), rel=1e-12)


def test_noise_at_a_state_is_that_of_scipys_lyapunov_equation():
    J = MISMATCH.at(ZERO, ZERO, ZERO)[0]
    A, L = PAPER.error_matrix(J), PAPER.L
    X = solve_continuous_lyapunov(A, -L @ L.T)
    found = noise(PAPER, J)
    assert found.position == pytest.approx(np.sqrt(np.trace(X[:2, :2])), rel=1e-10)
    assert found.velocity == pytest.approx(np.sqrt(np.trace(X[2:, 2:])), rel=1e-10)


@pytest.mark.parametrize("p", [2.0, 30.0, 400.0])
def test_a_double_pole_peaks_at_p_over_e(p):
    """qd~(t) = -p^2 t exp(-p t)."""
    assert peaking(by_poles(3, -p, -p)) == pytest.approx(p / np.e, rel=1e-4)  # as stated


@pytest.mark.parametrize(("l1", "l2"), [(30.0, 50.0), (60.0, 900.0), (2.0, 100.0)])
def test_the_tolerated_mismatch_is_one_over_the_peak_of_the_frequency_response(l1, l2):
    """|(1, i w + l1) / (l2 - w^2 + i l1 w)| over a fine grid of frequencies."""
    w = np.concatenate([[0.0], np.geomspace(1e-3, 1e4, 400_000)])
    gain = np.sqrt(1 + l1**2 + w**2) / np.abs(l2 - w**2 + 1j * l1 * w)
    rho, _ = tolerated_mismatch(Gains([[l1]], [[l2]]))
    assert rho == pytest.approx(1 / gain.max(), rel=1e-5)  # 2e-6 are given away for the exact check
    assert rho < 1 / gain.max()


def test_a_larger_mismatch_than_the_tolerated_one_has_no_certificate():
    from workbench.arms.observer_gains.inequality import bears_mismatch

    rho, P = tolerated_mismatch(PAPER)
    A, B = PAPER.error_matrix(), np.eye(4)[:, 2:]
    assert bears_mismatch(P, A, B, rho)
    assert not bears_mismatch(P, A, B, 1.001 * rho)
    assert not bears_mismatch(-P, A, B, rho)


def test_the_lipschitz_constants_of_a_pendulum_are_its_stiffness_and_zero():
    """q'' = (tau - m g l sin q) / (m l^2): |df/dq| <= g / l whatever the torque, and no velocity in it."""
    found = lipschitz(Mismatch.of(PENDULUM), Region([3.0], [7.0]))
    assert found.position.lower == pytest.approx(9.81 / 0.5, rel=1e-3)  # 20,000 samples of a turn
    assert 9.81 / 0.5 <= found.position.upper <= 1.02 * 9.81 / 0.5
    assert found.velocity.upper <= 1e-9


@pytest.mark.heavy
def test_no_state_of_the_box_exceeds_the_proved_constants():
    found = lipschitz(MISMATCH, BOX)
    J = MISMATCH.at(*states(20_000, np.random.default_rng(6)))
    for bound, part in ((found.position, J[..., :2]), (found.velocity, J[..., 2:])):
        assert np.linalg.norm(part, 2, axis=(1, 2)).max() <= bound.upper <= 1.05 * bound.lower


def test_poles_are_placed_exactly():
    gains = by_poles(2, -3 + 4j, -3 - 4j)
    np.testing.assert_array_equal(gains.L1, 6 * I)
    np.testing.assert_array_equal(gains.L2, 25 * I)
    np.testing.assert_allclose(np.sort(np.linalg.eigvals(gains.error_matrix()).real), -3, atol=1e-12)


def test_a_high_gain_is_a_faster_time():
    slow, fast = high_gain(2, 3.0, 2.0, 1.0), high_gain(2, 3.0, 2.0, 0.01)
    np.testing.assert_allclose(
        np.sort(np.linalg.eigvals(fast.error_matrix()).real),
        100 * np.sort(np.linalg.eigvals(slow.error_matrix()).real),
        rtol=1e-10,  # rounding
    )


def test_a_growing_mode_has_no_noise_gain():
    J = MISMATCH.at(np.array([[np.pi, 0.0]]), ZERO, ZERO)[0]
    with pytest.raises(DesignError, match="grows"):
        noise(Gains(30 * I, 10 * I), J)


@pytest.mark.heavy
def test_an_audit_says_what_is_proved_of_the_papers_gains(monkeypatch):
    monkeypatch.setattr(error_dynamics, "HALVINGS", 2)  # each asks a solver: the share is rougher
    found = audit(DYNAMICS, PAPER, BOX, 0.8, 0.1)
    assert found.certificate is not None
    assert found.admitted_errors is not None
    assert found.share is not None
    assert 0.02 < found.share < 0.2
    assert found.admitted_errors.position < 0.02  # rad: errors must be small indeed
    assert found.frozen_poles.unstable > 0.1


def test_states_that_are_none_are_refused_by_name():
    two, rows = np.zeros((3, 2)), np.zeros((2, 2))
    for states, words in (((two, rows, two), "2 numbers a row"), ((two, two, two * np.nan), "finite")):
        with pytest.raises(ValueError, match=words):
            frozen_poles(MISMATCH, PAPER, *states)
    with pytest.raises(ValueError, match="whole number from 1 to 10000000"):
        frozen_poles_over(MISMATCH, PAPER, BOX, 0)
    with pytest.raises(ValueError, match="shape"):
        noise(PAPER, np.zeros((3, 3)))
    with pytest.raises(ValueError, match="must be a `Dynamics`"):
        Mismatch.of(None)

"""Certificates of an observer's decay: by hand for one joint, tampered with, and against runs."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import solve_continuous_lyapunov

from workbench.arms.dynamics import Dynamics
from workbench.arms.mechanics import paper_arm
from workbench.arms.mechanics.planar_arm import PlanarArm, PointMass
from workbench.arms.observer_gains import (
    Gains,
    Mismatch,
    Region,
    audit,
    by_lmi,
    by_poles,
    certify,
    check,
    kalman,
    least_double_pole,
    noise,
)
from workbench.design.matrices import DesignError

DYNAMICS = Dynamics.of(paper_arm())
MISMATCH = Mismatch.of(DYNAMICS)
BOX = Region([5.0, 5.0], [30.0, 30.0])
PENDULUM = Dynamics.of(PlanarArm((PointMass(2.0, 0.5),), 9.81))
SWING = Mismatch.of(PENDULUM)
TURN = Region([3.0], [7.0])
STIFFNESS = 9.81 / 0.5  # |df/dq| of the pendulum, in 1/s^2


@pytest.fixture(scope="module")
def certificate():
    return certify(DYNAMICS, by_poles(2, -40, -40), BOX, 1.0)


def by_hand(gains, rate, P):
    """The largest eigenvalue of P A + A' P + 2 rate P at both extremes of the pendulum's stiffness."""
    found = []
    for k in (-STIFFNESS, STIFFNESS):
        A = np.array([[-gains.L1[0, 0], 1.0], [k - gains.L2[0, 0], 0.0]])
        found.append(np.linalg.eigvalsh(P @ A + A.T @ P + 2 * rate * P)[-1])
    return max(found)


@pytest.mark.parametrize("rate", [0.5, 2.0, 6.0, 9.0, 15.0])
def test_of_a_pendulum_a_certificate_holds_if_and_only_if_it_does_at_both_extremes(rate):
    """df/dq covers [-g/l, g/l] and enters affinely, so two matrices decide."""
    gains = by_poles(1, -20, -20)
    A = gains.error_matrix()
    P = solve_continuous_lyapunov((A + 8 * np.eye(2)).T, -np.diag([1.0, 0.01]))
    margin = by_hand(gains, rate, P)
    assert abs(margin) > 1e-3  # no close call among these rates
    if margin < 0:
        assert check(SWING, gains, TURN, P, rate).rate == rate
    else:
        with pytest.raises(DesignError, match="is not proved"):
            check(SWING, gains, TURN, P, rate)


def test_the_linear_matrix_inequality_finds_what_exists():
    assert certify(PENDULUM, by_poles(1, -20, -20), TURN, 5.0).boxes > 0
    with pytest.raises(
        DesignError
    ):  # a single frozen mode is slower: sqrt(20^2 - ...) leaves 20 - sqrt(19.62) = 15.6 1/s
        certify(PENDULUM, by_poles(1, -20, -20), TURN, 15.7)


@pytest.mark.heavy
def test_a_certificate_that_was_tampered_with_is_refused(certificate):
    P, region, rate = certificate.P, certificate.region, certificate.rate
    assert check(MISMATCH, certificate.gains, region.scale(0.2), P, rate).boxes < certificate.boxes  # in a part of it
    for worse in (
        {"P": -P},
        {"P": P + np.diag([0, 0, 0, 0.9 * P[3, 3]])},
        {"rate": 40.0},
        {"region": region.scale(6.0)},
        {"gains": Gains(10 * np.eye(2), 30 * np.eye(2))},
    ):
        parts = {"gains": certificate.gains, "region": region, "P": P, "rate": rate} | worse
        with pytest.raises(DesignError):
            check(MISMATCH, **parts)


def test_a_certificate_that_is_not_definite_by_a_hair_is_refused_exactly():
    """[[1, 1], [1, 1 + 2^-52]] is definite and [[1, 1], [1, 1]] is not: rounding does not decide."""
    from workbench.arms.observer_gains.inequality import exactly_definite

    assert exactly_definite(np.array([[1.0, 1.0], [1.0, 1 + 2.0**-52]]))
    assert not exactly_definite(np.array([[1.0, 1.0], [1.0, 1.0]]))
    assert not exactly_definite(np.array([[1.0, 1.0], [1.0, 1 - 2.0**-53]]))


def test_the_inequality_holds_at_random_states_of_the_region(certificate):
    rng = np.random.default_rng(7)
    q, qd, tau = rng.uniform(-9, 9, (20_000, 2)), rng.uniform(-5, 5, (20_000, 2)), rng.uniform(-30, 30, (20_000, 2))
    PA = certificate.P @ certificate.gains.error_matrix(MISMATCH.at(q, qd, tau))
    N = PA + PA.swapaxes(1, 2) + 2 * certificate.rate * certificate.P
    assert np.linalg.eigvalsh(N)[:, -1].max() < 0


def test_an_audit_takes_no_certificate_of_something_else(certificate):
    with pytest.raises(ValueError, match="these gains, in this region, of this rate"):
        audit(DYNAMICS, certificate.gains, BOX, 0.8, 2.0, certificate)


def test_an_audit_proves_a_certificate_that_it_is_given_again(certificate):
    heavier = Dynamics.of(PlanarArm((PointMass(3.0, 0.8), PointMass(2.0, 0.3)), 9.81))
    for arm, given in ((DYNAMICS, replace(certificate, P=-certificate.P)), (heavier, certificate)):
        with pytest.raises(DesignError):
            audit(arm, certificate.gains, BOX, 0.8, 1.0, given)


def test_a_reach_is_for_as_many_joints_as_the_certificate(certificate):
    with pytest.raises(ValueError, match="for the 2 joints of the certificate; got 1"):
        certificate.admitted_errors(Region([1.0], [1.0]))


def test_errors_that_are_admitted_decay_as_promised_along_runs(certificate):
    """Arm and observer by another integrator, from the edge of the admitted ellipsoid; the torque slows the arm."""
    arm = Region([4.0, 4.0], [30.0, 30.0])
    reach, rng = certificate.admitted_errors(arm), np.random.default_rng(8)
    P, gains, T = certificate.P, certificate.gains, np.linalg.cholesky(certificate.P)

    def rates(t, x):
        q, qd, q_hat, qd_hat = np.split(x, 4)
        M, _, G = DYNAMICS.matrices(q, qd)
        tau = np.clip(G + M @ (3 * np.sin([5 * t, 7 * t]) - 3 * qd), -30, 30)
        gap = q - q_hat
        ours, model = (DYNAMICS.acceleration(*state, tau) for state in ((q, qd), (q_hat, qd_hat)))
        return np.concatenate([qd, ours, qd_hat + gains.L1 @ gap, model + gains.L2 @ gap])

    for _ in range(2):
        x = np.concatenate([rng.uniform(-3, 3, 2), rng.uniform(-1, 1, 2)])
        direction = rng.normal(size=4)
        error = np.sqrt(0.999 * reach.level) * np.linalg.solve(T.T, direction / np.linalg.norm(direction))
        times = np.linspace(0, 0.3, 31)
        run = solve_ivp(rates, (0, 0.3), np.concatenate([x, x - error]), t_eval=times, rtol=1e-9, atol=1e-12)
        assert np.abs(run.y[2:4]).max() < 4  # the arm keeps the inner region, as the promise asks
        e = run.y[:4] - run.y[4:]
        V = np.einsum("it,ij,jt->t", e, P, e)
        promised = V[0] * np.exp(-2 * certificate.rate * times)
        assert (promised * (1 + 1e-6) - V >= 0).all()  # the integrator's tolerance
        assert (np.abs(e[2:]) < 1.0).all()


def test_the_ellipsoid_touches_the_room_of_the_estimate(certificate):
    reach = certificate.admitted_errors(Region([4.5, 4.0], [30.0, 30.0]))
    most = np.sqrt(reach.level * np.diag(np.linalg.inv(certificate.P))[2:])  # rad/s, the largest qd~ on it
    assert (most <= np.array([0.5, 1.0]) * (1 + 1e-12)).all()
    assert np.isclose(most, [0.5, 1.0], rtol=1e-12).any()


def test_an_inner_region_without_room_is_refused(certificate):
    for arm in (BOX, Region([4.0, 4.0], [31.0, 30.0]), Region([6.0, 4.0], [30.0, 30.0])):
        with pytest.raises(ValueError, match="inside the certificate"):
            certificate.admitted_errors(arm)


def test_bounded_positions_bound_the_admitted_errors_too():
    region = Region([3.0], [7.0], [-1.0], [1.0])
    found = certify(PENDULUM, by_poles(1, -20, -20), region, 2.0)
    narrow = found.admitted_errors(Region([1.0], [7.0], [-0.9], [0.9]))
    assert np.sqrt(narrow.level * np.linalg.inv(found.P)[0, 0]) <= 0.1 * (1 + 1e-12)
    with pytest.raises(ValueError, match="bounds the positions"):
        found.admitted_errors(Region([1.0], [7.0]))


def test_the_least_double_pole_of_a_pendulum_is_the_one_by_hand():
    """Of one joint s^2 + 2 p s + p^2 - k with k constant in [-g/l, g/l] decays at p - sqrt(g/l), if the roots are real.

    As k may vary, a common P asks for more; and room is kept for what lies between samples: a few percent.
    """
    found = least_double_pole(PENDULUM, TURN, 2.0)
    p = found.gains.L1[0, 0] / 2
    frozen = np.sqrt(STIFFNESS) + 2.0
    assert frozen < p < 1.4 * frozen
    with pytest.raises(DesignError):
        certify(PENDULUM, by_poles(1, -0.9 * frozen, -0.9 * frozen), TURN, 2.0)


@pytest.mark.parametrize(
    "arm", [(PENDULUM, TURN), pytest.param((DYNAMICS, BOX), marks=pytest.mark.release)], ids=["1 joint", "2 joints"]
)
def test_the_noise_of_the_gains_by_lmi_keeps_the_bound_of_their_p(arm):
    """trace L' P L bounds the square of the H2 norm to (rate q~, qd~) where the model adds nothing."""
    quiet = by_lmi(*arm, 2.0)
    L, found = quiet.gains.L, noise(quiet.gains)
    assert np.hypot(2.0 * found.position, found.velocity) ** 2 <= np.trace(L.T @ quiet.P @ L)


def test_kalmans_gain_of_a_double_integrator_is_the_textbooks():
    """Without gravity and at rest f does not depend on the state: L1 = sqrt(2 w), L2 = w, w = sqrt(Qn / Rn)."""
    floating = Dynamics.of(PlanarArm((PointMass(2.0, 0.5),), 0.0))
    found = kalman(floating, [0.3], [0.0], [0.0], [[100.0]], [[1e-4]])
    assert found.L1[0, 0] == pytest.approx(np.sqrt(2 * 1e3), rel=1e-9)
    assert found.L2[0, 0] == pytest.approx(1e3, rel=1e-9)


def test_any_position_is_refused_where_equations_do_not_repeat():
    unproved = replace(SWING, periodic=False)
    with pytest.raises(ValueError, match="repeat after a turn"):
        check(unproved, by_poles(1, -20, -20), TURN, np.eye(2), 1.0)


def test_a_certificate_of_nan_or_the_wrong_shape_is_refused():
    for P, words in (
        (np.full((2, 2), np.nan), "finite"),
        (np.eye(3), "shape"),
        (np.triu(np.ones((2, 2))), "symmetric"),
    ):
        with pytest.raises(ValueError, match=words):
            check(SWING, by_poles(1, -20, -20), TURN, P, 1.0)

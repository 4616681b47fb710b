"""Gains as series in time, and the law that takes them: the time-varying regulator along a reference."""

from functools import cache, lru_cache

import casadi as ca
import numpy as np
import pytest
from numpy.polynomial import chebyshev

from tests.support.oracles import closed_loop, matrices, wanted, worst_difference
from workbench.arms.laws import ArmStateFeedback, ScheduledFeedback
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import ArmFullState
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Sines, SineTorque
from workbench.core import rk4, with_quadrature
from workbench.design.riccati_flow import rde
from workbench.engine import simulate

COEFFICIENTS = np.array(
    [[[60.0, 5, 15, 1], [2, 30, 3, 6]], [[8.0, 1, 2, 0], [0, 3, 1, 1]], [[4.0, 0, 1, 0], [1, 2, 0, 1]]]
)
AMPLITUDE, FREQUENCY = np.array([1.0, 0.5]), np.array([2.0, 3.0])


def loop(controller, q=(0.6, -0.8), qd=(0.0, 0.0), disturbance=None):
    return ClosedLoop(
        plant=Manipulator(paper_arm(), q=q, qd=qd, disturbance=disturbance),
        observer=ArmFullState(2),
        controller=controller,
        reference=Sines("q", "rad", amplitude=AMPLITUDE, frequency=FREQUENCY),
    )


def scheduled(basis):
    """The law by hand, its gain a sum over the terms."""

    def law(p, z, q, qd, d, ref):
        M, C, G = matrices(p, "controller.model", ref[0], ref[1])
        Kp, Kd = (
            sum(b * row.reshape(2, 2) for b, row in zip(basis(p["time"], p), p[f"controller.{name}"], strict=True))
            for name in ("Kp", "Kd")
        )
        return M @ ref[2] + C @ ref[1] + G - Kp @ (q - ref[0]) - Kd @ (qd - ref[1]), {}

    return law


@pytest.mark.parametrize("series", ["chebyshev", "fourier"])
def test_the_loop_is_the_one_written_by_hand(series):
    def basis(t, p):
        x = min(t / p["controller.horizon"], 1.0)
        w = 2 * np.pi * t / p["controller.horizon"]
        return (1.0, 2 * x - 1, 2 * (2 * x - 1) ** 2 - 1) if series == "chebyshev" else (1.0, np.cos(w), np.sin(w))

    push = SineTorque(amplitude=[0.5, 0.4], frequency=[3.0, 4.0], phase=[0.0, np.pi / 2])
    ode = loop(ScheduledFeedback.of(paper_arm(), COEFFICIENTS, 6.0, series), disturbance=push).ode()

    def rates(t, z, p):
        return closed_loop(scheduled(basis))(t, z, p | {"time": t})

    assert worst_difference(ode, rates, np.random.default_rng(51)) < 1e-12  # rounding


def test_one_term_is_constant_state_feedback():
    one = loop(ScheduledFeedback.of(paper_arm(), COEFFICIENTS[:1], 1.0)).ode()
    other = loop(ArmStateFeedback.of(paper_arm(), COEFFICIENTS[0])).ode()
    x = one.states.default + 0.1
    np.testing.assert_allclose(one.rate_at(0.3, x), other.rate_at(0.3, x), rtol=1e-14)  # rounding


def test_beyond_the_horizon_the_gain_stays():
    law = ScheduledFeedback.of(paper_arm(), COEFFICIENTS, 2.0)
    ends, later = (np.hstack([np.array(ca.DM(K)) for K in law.gains(ca.SX(t))]) for t in (2.0, 7.0))
    np.testing.assert_array_equal(ends, later)
    np.testing.assert_allclose(ends, COEFFICIENTS.sum(axis=0))  # T_k(1) = 1


@lru_cache(maxsize=8)  # the equation asks for A and for B at one instant
def linear_arm(t):
    """A, B of the error about the paper's reference, by central differences of a hand-written arm."""
    p = {"a.links[0].mass": 1.0, "a.links[1].mass": 1.0, "a.links[0].length": 1.0, "a.links[1].length": 1.0}
    p |= {"a.gravity": 9.81, "reference.amplitude": AMPLITUDE, "reference.frequency": FREQUENCY}
    q, qd, qdd = wanted(t, p | {"reference.phase": np.zeros(2)})
    M, C, G = matrices(p, "a", q, qd)
    tau = M @ qdd + C @ qd + G

    def acceleration(x):
        M, C, G = matrices(p, "a", x[:2], x[2:])
        return np.linalg.solve(M, tau - C @ x[2:] - G)

    x, h = np.concatenate([q, qd]), 1e-5
    lower = np.array([(acceleration(x + h * d) - acceleration(x - h * d)) / (2 * h) for d in np.eye(4)]).T
    A = np.vstack([np.hstack([np.zeros((2, 2)), np.eye(2)]), lower])
    return A, np.vstack([np.zeros((2, 2)), np.linalg.inv(M)])


@pytest.mark.heavy
def test_along_the_reference_the_cost_of_the_time_varying_regulator_is_x_p_x():
    horizon, Q, R = 1.5, np.diag([40.0, 30.0, 2.0, 1.0]), np.diag([0.1, 0.2])

    at = cache(linear_arm)
    x, terms = chebyshev.chebpts1(33), 33  # 33 terms leave 1e-6 of the gains
    times = [0.0, *(x + 1) / 2 * horizon, horizon]
    flow = rde(lambda s: at(s)[0], lambda s: at(s)[1], Q, R, np.zeros((4, 4)), times, rtol=1e-7)
    K = flow.K[1 : terms + 1]
    series = chebyshev.chebfit(x, K.reshape(terms, -1), terms - 1)
    law = ScheduledFeedback.of(paper_arm(), series.reshape(K.shape), horizon)
    x0 = 1e-4 * np.array([1.0, -2.0, 0.0, 3.0])
    ode = loop(law, q=x0[:2], qd=AMPLITUDE * FREQUENCY + x0[2:]).ode()
    y = ode.outputs.view(ode.output)
    x = ca.vertcat(y["e"], y["ed"])
    Kp, Kd = law.gains(ode.t)
    u = ca.horzcat(Kp, Kd) @ x
    costly = with_quadrature(ode, {"J": (x.T @ Q @ x + u.T @ R @ u) / 1e-8})
    J = simulate(rk4(costly, 5e-4), until=horizon, every=horizon)["J"][0, -1]
    best = x0 @ flow.P[0] @ x0 / 1e-8
    assert float(np.squeeze(J)) == pytest.approx(
        best, rel=1e-4
    )  # the arm's curvature over 1e-4 rad, and RK4's error of 1e-9 rad


@pytest.mark.parametrize(
    ("coefficients", "series", "says"),
    [
        (COEFFICIENTS[:2], "fourier", "needs an odd number of terms"),
        (COEFFICIENTS[0], "chebyshev", r"must be an array \(terms, n, 2n\)"),
        (np.ones((3, 2, 3)), "chebyshev", "must have 2 rows, one a joint, and 4 columns"),
    ],
)
def test_coefficients_that_are_none_are_refused(coefficients, series, says):
    with pytest.raises(ValueError, match=says):
        ScheduledFeedback.of(paper_arm(), coefficients, 1.0, series)


def test_no_terms_at_all_are_refused_by_name():
    with pytest.raises(ValueError, match=r"`ScheduledFeedback.of\(coefficients=...\)` must be an array"):
        ScheduledFeedback.of(paper_arm(), np.ones((0, 2, 4)), 1.0)

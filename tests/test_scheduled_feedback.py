"""Gains as series in time, and the law that takes them: the time-varying regulator along a reference."""

import casadi as ca
import numpy as np
import pytest
from oracles import closed_loop, matrices, wanted, worst_difference

from workbench.controllers import ScheduledFeedback, StateFeedback
from workbench.core import rk4, with_quadrature
from workbench.design.certificates import Refused
from workbench.design.riccati_flow import chebyshev, fourier, rde
from workbench.loop import ClosedLoop
from workbench.observers import FullState
from workbench.plants import Manipulator
from workbench.robots import paper_arm
from workbench.signals import Sines, SineTorque
from workbench.simulate import simulate

COEFFICIENTS = np.array(
    [[[60.0, 5, 15, 1], [2, 30, 3, 6]], [[8.0, 1, 2, 0], [0, 3, 1, 1]], [[4.0, 0, 1, 0], [1, 2, 0, 1]]]
)
AMPLITUDE, FREQUENCY = np.array([1.0, 0.5]), np.array([2.0, 3.0])


def loop(controller, q=(0.6, -0.8), qd=(0.0, 0.0), disturbance=None):
    return ClosedLoop(
        plant=Manipulator(paper_arm(), q=q, qd=qd, disturbance=disturbance),
        observer=FullState(2),
        controller=controller,
        reference=Sines(amplitude=AMPLITUDE, frequency=FREQUENCY),
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
    other = loop(StateFeedback.of(paper_arm(), COEFFICIENTS[0])).ode()
    x = one.states.default + 0.1
    np.testing.assert_allclose(one.rate_at(0.3, x), other.rate_at(0.3, x), rtol=1e-14)  # rounding


def test_beyond_the_horizon_the_gain_stays():
    law = ScheduledFeedback.of(paper_arm(), COEFFICIENTS, 2.0)
    ends, later = (np.hstack([np.array(ca.DM(K)) for K in law.gains(ca.SX(t))]) for t in (2.0, 7.0))
    np.testing.assert_array_equal(ends, later)
    np.testing.assert_allclose(ends, COEFFICIENTS.sum(axis=0))  # T_k(1) = 1


def test_the_series_is_within_its_error_everywhere():
    def gains(t):
        return np.exp(-3 * t)[:, None, None] * np.array([[1.0, -2.0]]) + np.sin(5 * t)[:, None, None]

    times = np.linspace(0, 4.0, 977)
    for tolerance in (1e-3, 1e-6, 1e-10):
        series = chebyshev(gains, 4.0, tolerance)
        size = np.abs(gains(times)).max()
        assert series.error <= tolerance
        assert np.abs(series.at(times) - gains(times)).max() <= 2 * tolerance * size  # between its points
    assert len(chebyshev(gains, 4.0, 1e-3).coefficients) < len(series.coefficients) < 50


def test_a_periodic_gain_is_a_short_fourier_series():
    def gains(t):
        return (1.0 + np.cos(2 * t) - 0.3 * np.sin(6 * t))[:, None, None] * np.ones((1, 2, 4))

    series = fourier(gains, np.pi)
    assert len(series.coefficients) == 7  # up to the third harmonic
    times = np.linspace(-5, 20, 301)
    np.testing.assert_allclose(series.at(times), gains(times), atol=1e-12)  # rounding


@pytest.mark.parametrize(("make", "name"), [(chebyshev, "chebyshev"), (fourier, "fourier")])
def test_a_gain_with_a_jump_is_refused(make, name):
    with pytest.raises(Refused, match=rf"`{name}\(.*1025 terms do not come within 1e-08 of the gains"):
        make(lambda t: (t > 1.0).astype(float)[:, None, None], 3.0)


def test_gains_that_do_not_repeat_are_refused_as_a_fourier_series():
    with pytest.raises(Refused, match="do not repeat as asked"):
        fourier(lambda t: t[:, None, None], 2.0)


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


def test_along_the_reference_the_cost_of_the_time_varying_regulator_is_x_p_x():
    horizon, Q, R = 1.5, np.diag([40.0, 30.0, 2.0, 1.0]), np.diag([0.1, 0.2])

    def flow(t):
        return rde(lambda s: linear_arm(s)[0], lambda s: linear_arm(s)[1], Q, R, np.zeros((4, 4)), t, rtol=1e-7)

    series = chebyshev(lambda t: flow(t).K, horizon, 1e-6)
    law = ScheduledFeedback.of(paper_arm(), series.coefficients, horizon)
    x0 = 1e-4 * np.array([1.0, -2.0, 0.0, 3.0])
    ode = loop(law, q=x0[:2], qd=AMPLITUDE * FREQUENCY + x0[2:]).ode()
    y = ode.outputs.view(ode.output)
    x = ca.vertcat(y["e"], y["ed"])
    Kp, Kd = law.gains(ode.t)
    u = ca.horzcat(Kp, Kd) @ x
    costly = with_quadrature(ode, {"J": (x.T @ Q @ x + u.T @ R @ u) / 1e-8})
    J = simulate(rk4(costly, 5e-4), until=horizon, every=horizon)["J"][0, -1]
    best = x0 @ flow([0.0, horizon]).P[0] @ x0 / 1e-8
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


def test_a_horizon_that_is_none_is_refused():
    with pytest.raises(ValueError, match=r"`ScheduledFeedback\(horizon=...\)` must be finite, with 0 < value"):
        ScheduledFeedback.of(paper_arm(), COEFFICIENTS, 0.0)


@pytest.mark.parametrize("bad", [{"horizon": -1.0}, {"tolerance": 0.0}, {"gains": lambda t: t}])
def test_a_series_of_nothing_is_refused(bad):
    with pytest.raises(ValueError, match=r"`chebyshev\(gains, horizon\)`"):
        chebyshev(**({"gains": lambda t: np.ones((len(t), 1, 1)), "horizon": 1.0} | bad))


def test_no_terms_at_all_are_refused_by_name():
    with pytest.raises(ValueError, match=r"`ScheduledFeedback.of\(coefficients=...\)` must be an array"):
        ScheduledFeedback.of(paper_arm(), np.ones((0, 2, 4)), 1.0)

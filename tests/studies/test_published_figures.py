"""Figures of linear systems that the literature gives in closed form or in print, through the face."""

import math

import control
import numpy as np
import pytest

import workbench as wb


@pytest.mark.parametrize("q", [60.0, 5.0, 1e4 - 4])
def test_a_loop_of_lqg_has_the_gain_margins_of_doyle_which_vanish_as_its_weights_grow(q):
    """Doyle (1978), Guaranteed margins for LQG regulators, IEEE Trans. Autom. Control 23.

    The weights q [1 1]'[1 1] and 1 on both sides give gains K = f [1 1] and L = f [1 1]', f = 2 + sqrt(4 + q); with m
    times the gain the last two coefficients of the closed loop are 2 f - 4 + 2 (m - 1) f^2 and 1 + (1 - m) f^2. That
    the first is positive is necessary for stability, and no more.
    """
    A, B, C, ones = np.array([[1.0, 1.0], [0.0, 1.0]]), np.array([[0.0], [1.0]]), np.eye(1, 2), np.ones((2, 2))
    f = 2 + math.sqrt(4 + q)
    K, L = f * np.ones((1, 2)), f * np.ones((2, 1))
    np.testing.assert_allclose(wb.lqr(control.ss(A, B, C, 0), q * ones, [[1.0]]).K, K, rtol=1e-8)
    law = control.ss(A - B @ K - L @ C, L, K, 0)
    found = wb.stability_margins(law * control.ss(A, B, C, 0))
    assert found.gain_high.value == pytest.approx(1 + 1 / f**2, rel=1e-12)
    assert 1 - (2 * f - 4) / (2 * f**2) < found.gain_low.low < 1
    for factor, inward in ((found.gain_low.value, 1.001), (found.gain_high.value, 0.999)):
        closed = control.feedback(factor * inward * law * control.ss(A, B, C, 0), 1)
        assert closed.poles().real.max() < 0
        beyond = control.feedback(factor / inward * law * control.ss(A, B, C, 0), 1)
        assert beyond.poles().real.max() > 0


@pytest.mark.heavy
def test_no_stabilising_controller_has_a_smaller_Ms_than_a_zero_and_a_pole_on_the_right_allow_and_one_has_it():
    """Skogestad and Postlethwaite (2005), Multivariable Feedback Control, chapter 5: Ms >= |z + p| / |z - p|.

    S(z) = 1 and S(p) = 0, so S (s + p) / (s - p) is at least (z + p) / (z - p) by the maximum principle; where that is
    constant, it is reached.
    """
    z, p = 3.0, 1.0
    least = (z + p) / (z - p)
    plant = control.tf([1, -z], [1, -p])
    best = wb.stability_margins(-0.5 * plant)  # S = 2 (s - 1) / (s + 1)
    assert best.Ms.gain.low == best.Ms.gain.high == least
    rng, tried = np.random.default_rng(2), 0
    while tried < 3:
        law = control.tf(rng.normal(size=3), np.poly(-(10.0 ** rng.uniform(-1, 1, 2))))
        if control.feedback(law * plant).poles().real.max() < -1e-3:  # others have no margins to compare
            tried += 1
            margins = wb.stability_margins(law * plant)
            assert margins.stable
            assert margins.Ms.gain.high >= least


def test_two_masses_whose_first_is_pushed_by_its_own_speed_cross_a_gain_of_one_thrice():
    """Wie and Bernstein (1992), Benchmark problems for robust control design, J. Guidance, Control and Dynamics 15.

    With masses and spring of one, L = (s^2 + 1) / (s (s^2 + 2)), and |L| = 1 at |2 cos(2 pi k / 7)|: the roots of
    x^3 + x^2 - 2 x - 1. A positive real L has a phase margin of 90 degrees at each.
    """
    A = np.zeros((4, 4))
    A[:2, 2:], A[2:, :2] = np.eye(2), [[-1, 1], [1, -1]]
    found = wb.stability_margins(control.ss(A, [[0], [0], [1], [0]], [[0, 0, 1, 0]], 0))
    places = sorted(abs(2 * math.cos(2 * math.pi * k / 7)) for k in (1, 2, 3))
    assert [row.frequency.value for row in found.gain_crossovers] == pytest.approx(places, rel=1e-14)
    # the phase falls to -90 degrees between each zero and the next pole, and rises to 90 after a zero
    assert [row.margin.value for row in found.gain_crossovers] == pytest.approx([90.0, -90.0, 90.0], rel=1e-13)
    assert not found.stable  # the masses may drift together, which their speeds do not show


@pytest.mark.parametrize(("gamma", "published"), [((0.7, 0.6), 1.40), ((0.43, 0.34), -0.64)])
def test_the_quadruple_tank_has_the_relative_gain_of_its_publication(gamma, published):
    """Johansson (2000), The quadruple-tank process, IEEE Trans. Control Systems Technology 8, table 1."""
    (g1, g2), minimum_phase = gamma, sum(gamma) > 1
    T = (62.0, 90.0) if minimum_phase else (63.0, 91.0)
    area, (k1, k2) = (28.0, 32.0), (3.33, 3.35) if minimum_phase else (3.14, 3.29)
    c1, c2 = T[0] * 0.5 / area[0], T[1] * 0.5 / area[1]
    gains = wb.relative_gains([[g1 * k1 * c1, (1 - g2) * k2 * c1], [(1 - g1) * k1 * c2, g2 * k2 * c2]])
    assert gains[0, 0].real == pytest.approx(g1 * g2 / (g1 + g2 - 1), rel=1e-12)
    assert round(float(gains[0, 0].real), 2) == published


def test_the_distillation_column_has_its_published_figures_at_every_frequency_as_its_lags_are_equal():
    """Skogestad, Morari and Doyle (1988), Robust control of ill-conditioned plants, IEEE Trans. Autom. Control 33."""
    G = np.array([[0.878, -0.864], [1.082, -1.096]])
    column = control.ss(-np.eye(2) / 75, np.eye(2) / 75, G, 0)
    for omega in (0.0, 0.01, 1.0):
        answer = np.asarray(column(1j * omega))
        assert round(wb.condition_number(answer), 1) == 141.7
        assert round(float(wb.relative_gains(answer)[0, 0].real), 1) == 35.1
    norm = wb.hinf_norm(column)
    assert norm.gain.value == pytest.approx(1.972, abs=5e-4)
    assert norm.frequency == 0

"""Harmonic balance: closed forms, the integrals behind the describing functions, and what is refused."""

import control
import numpy as np
import pytest
from scipy.integrate import quad

from workbench.design.chattering import BoundaryLayer, LinearPart, Relay, harmonic_balance

K, TAU = 5.0, 0.01
s = control.tf("s")
TWO_LAGS = 1 / (s * (TAU * s + 1) ** 2)
ONE_LAG = 1 / (s * (TAU * s + 1))
SWITCHES = [
    (Relay(K), lambda x: K * np.sign(x)),
    (BoundaryLayer(K, 0.3), lambda x: K * np.clip(x / 0.3, -1, 1)),
]


def only(balance):
    (oscillation,) = balance.oscillations
    return oscillation


def test_a_relay_behind_two_equal_lags_oscillates_as_the_closed_form_says():
    found = only(harmonic_balance(TWO_LAGS, Relay(K)))
    # the phase is -180 degrees at w = 1/tau, where |W| = tau/2; a root of a smooth function, to rounding
    np.testing.assert_allclose([found.frequency, found.amplitude], [1 / TAU, 2 * K * TAU / np.pi], rtol=1e-11)
    np.testing.assert_allclose(found.third, (1 / 3) * (1 / 3) * (2 / 10), rtol=1e-10)
    assert found.stable


def test_one_lag_alone_makes_no_relay_oscillate_and_it_is_said():
    balance = harmonic_balance(ONE_LAG, Relay(K))
    assert balance.oscillations == ()
    assert "meet at no finite frequency" in balance.verdict


@pytest.mark.parametrize("share", [0.9, 0.999, 1.001, 1.1])
def test_a_layer_ends_the_oscillation_where_the_exact_poles_say_so(share):
    least = K * TAU / 2
    balance = harmonic_balance(TWO_LAGS, BoundaryLayer(K, share * least))
    np.testing.assert_allclose(balance.least_phi, least, rtol=1e-11)
    assert bool(balance.oscillations) == (share < 1)
    assert (balance.rest > 0) == (share > 1)
    assert ("the layer is wider" in balance.verdict) == (share > 1)


@pytest.mark.parametrize("a", [0.1, 0.31, 2.0])
@pytest.mark.parametrize(("switch", "f"), SWITCHES)
def test_a_describing_function_is_the_fourier_integral_of_its_switch(switch, f, a):
    kinks = [np.arcsin(0.3 / a)] if a > 0.3 else None
    first, third = (
        4
        / np.pi
        * quad(lambda x, k: f(a * np.sin(x)) * np.sin(k * x), 0, np.pi / 2, (k,), points=kinks, epsabs=1e-12)[0]
        for k in (1, 3)
    )
    np.testing.assert_allclose(switch.gain(a), first / a, rtol=1e-8)
    np.testing.assert_allclose(switch.third(a), abs(third), rtol=1e-7, atol=1e-9)


@pytest.mark.parametrize(("switch", "f"), SWITCHES)
def test_the_slope_of_a_describing_function_is_its_central_difference(switch, f):
    a, d = 0.5, 1e-5
    expected = (switch.gain(a + d) - switch.gain(a - d)) / (2 * d)
    np.testing.assert_allclose(switch.slope(a), expected, rtol=1e-8)  # d^2 times third derivatives


@pytest.mark.parametrize("W", [LinearPart.of(ONE_LAG), LinearPart.of(control.c2d(ONE_LAG, 1e-3))])
def test_the_slope_of_the_response_is_its_difference(W):
    w, d = 80.0, 1e-3
    expected = (W.response(w + d)[0] - W.response(w - d)[0]) / (2j * d)
    np.testing.assert_allclose(W.response(w)[1], expected, rtol=1e-7)  # d^2 / w^2, and rounding over d / w


@pytest.mark.parametrize(
    ("system", "words"),
    [
        (-ONE_LAG, "sign of u"),
        (1 / (s - 1), "unstable pole"),
        (control.tf([1], [1.0, -1.1], 0.1), "unstable pole"),
        ((s + 2) / (s + 1), "strictly proper"),
        (control.tf([1], [1.0, -1.0], True), "`dt`"),
        (control.ss(np.diag([-1.0, -2.0]), np.eye(2), np.eye(2), 0), "one input"),
        (control.ss([[-1.0]], [[0.0]], [[1.0]], 0), "does not answer"),
        (np.eye(2), "python-control"),
        (control.tf([1e-16, 1.0], [1.0, 1.0, 0.0]), "polynomials can be trusted"),
    ],
)
def test_a_linear_part_that_can_be_none_is_refused_by_name(system, words):
    with pytest.raises(ValueError, match=words):
        harmonic_balance(system, Relay(K))


def test_numbers_that_are_none_are_refused_by_name():
    with pytest.raises(ValueError, match=r"LinearPart\(b=...\)` must be finite"):
        LinearPart(-np.eye(1), np.array([np.nan]), np.ones(1))
    for A in (np.zeros((2, 3)), np.zeros((0, 0)), [[np.inf]], [[1j]]):
        with pytest.raises(ValueError, match=r"LinearPart\(A"):
            LinearPart(A, np.ones(2), np.ones(2))
    for wrong in (lambda: Relay(-1.0), lambda: BoundaryLayer(1.0, 0.0), lambda: Relay(float("nan"))):
        with pytest.raises(ValueError, match="positive, finite"):
            wrong()
    with pytest.raises(ValueError, match="harmonic_balance"):
        harmonic_balance(ONE_LAG, 5.0)


def test_two_crossings_close_to_a_hardly_damped_resonance_are_both_found():
    w0, zeta = 50.0, 1e-6
    resonance = w0**2 / (s**2 + 2 * zeta * w0 * s + w0**2)
    # Im W is negative but within a hundred-thousandth about w0, where this small mode in opposition outweighs it
    W = control.ss(1 / (s * (s + 1))) - control.ss(4e-10 * resonance)
    found = [o.frequency for o in harmonic_balance(W, Relay(K)).oscillations]
    value = LinearPart.of(W).response(np.array(found))[0]
    assert len(found) == 2
    np.testing.assert_allclose(found, w0, rtol=1e-4)
    assert np.all(value.real < 0)
    np.testing.assert_allclose(value.imag / abs(value), 0.0, atol=1e-7)


def test_an_oscillation_at_a_frequency_of_the_grid_itself_is_found():
    """10 / (s (s + 10)^2) turns by -180 degrees at its own corner, where |W| = 1 / 200."""
    found = only(harmonic_balance(LinearPart([[0, 1, 0], [0, -10, 1], [0, 0, -10]], [0, 0, 10], [1, 0, 0]), Relay(1.0)))
    assert found.frequency == pytest.approx(10, rel=1e-12)
    assert found.amplitude == pytest.approx(4 / np.pi / 200, rel=1e-12)


def test_an_unstable_pole_beside_a_fast_one_is_refused():
    with pytest.raises(ValueError, match=r"no unstable pole.*0\.9"):
        LinearPart(np.diag([0.9, -1e6]), [1.0, 1.0], [1.0, 1.0])

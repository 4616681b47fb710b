"""The reference integrator where surfaces are reached, crossed, slid on and left, against closed forms."""

import casadi as ca
import numpy as np
import pytest

from tests.support.reference_runs import equation, run, times_of
from workbench.engine.reference import reference_run

# The runs below are asked for 1e-10, and what is handed back is closer by far; a factor is what an equation magnifies.
EXACT = 1e-10


# Jumps


def test_a_relay_reaches_its_surface_at_the_known_time_and_slides_on_it():
    result = run(lambda t, x: [-ca.sign(x[0]) + 0.3], [1.0], 3.0)
    np.testing.assert_allclose(result.x[:, 0], np.maximum(0, 1 - 0.7 * result.t), atol=1e-15)
    (event,) = result.events
    assert (event.what, event.surface) == ("slides", "x[0]")
    assert event.t == pytest.approx(1 / 0.7, abs=1e-15)
    assert event.rate == pytest.approx(-0.7)
    assert result.sliding_spans == ((event.t, 3.0, ("x[0]",)),)


def test_a_relay_rejects_a_sinusoid_and_is_left_when_that_exceeds_it():
    result = run(lambda t, x: [-ca.sign(x[0]) + 2 * ca.sin(t)], [0.1], 2.0)
    # left when 2 sin t = 1; from there x = -(t - t1) - 2 (cos t - cos t1)
    (left,) = times_of(result, "leaves")
    assert left == pytest.approx(np.pi / 6, abs=EXACT)
    after = result.t[result.t > left]
    expected = -(after - left) - 2 * (np.cos(after) - np.cos(left))
    np.testing.assert_allclose(result.x[result.t > left, 0], expected, atol=EXACT)


@pytest.mark.parametrize("phase", [0.0, 2.0])
def test_a_relay_that_a_sinusoid_exceeds_again_and_again_is_left_and_reached_again(phase):
    a, w = 1.5, 3.0
    times = np.array([2.0, 5.0, 10.0]) - phase / w
    result = reference_run(equation(lambda t, x: [-ca.sign(x[0]) + a * ca.sin(w * t + phase)], [0.0]), times=times)
    # held until a sin = 1, then x' = a sin - 1 until it is back at zero; and half a period later the same below
    half, s = np.pi / w, times + phase / w
    n, left = (s - np.arcsin(1 / a) / w) // half, np.arcsin(1 / a) / w
    tau = s - n * half
    x = (-1) ** n * np.maximum(0, left - tau - a / w * (np.cos(w * tau) - np.cos(w * left)))
    np.testing.assert_allclose(x, [-0.14320, 0.18455, -0.11782], atol=1e-5)  # as LSODA has it, with a steep tanh
    np.testing.assert_allclose(result.x[:, 0], x, atol=EXACT)


def test_a_push_in_any_phase_is_followed_off_the_surface_and_back():
    rng = np.random.default_rng(0)
    for a, w, phase in rng.uniform([1.05, 1, 0], [3, 5, 6], (3, 3)):
        result = run(lambda t, x: [-ca.sign(x[0]) + a * ca.sin(w * t + phase)], [0.0], 6.0, 2)  # noqa: B023
        assert result.error.max() < EXACT


def test_sliding_mode_control_of_a_double_integrator_follows_its_closed_form():
    lam, k, e0, v0 = 6.0, 5.0, 1.0, 0.5
    result = run(lambda t, x: [x[1], -lam * x[1] - k * ca.sign(lam * x[0] + x[1])], [e0, v0], 3.0)
    s0 = lam * e0 + v0
    T = s0 / k

    def reaching(t):  # e' = -lam e + s0 - k t
        a = (s0 + k / lam) / lam
        return (e0 - a) * np.exp(-lam * t) + a - k * t / lam

    e = np.where(result.t < T, reaching(result.t), reaching(T) * np.exp(-lam * (result.t - T)))
    s = np.maximum(0, s0 - k * result.t)
    np.testing.assert_allclose(result.x[:, 0], e, atol=EXACT)
    np.testing.assert_allclose(result.x[:, 1], s - lam * e, atol=EXACT)
    # on the surface to the rounding of its terms
    assert np.abs(result.x[result.t > T] @ [lam, 1]).max() < 1e-15
    assert times_of(result, "slides") == pytest.approx([T], abs=1e-14)


def test_dry_friction_holds_the_mass_where_the_spring_cannot_move_it():
    F = 0.15
    result = run(lambda t, x: [x[1], -x[0] - F * ca.sign(x[1])], [1.0, 0.0], 12.0)
    # half a turn about -F or F, the amplitude less by 2 F each: 1, -0.7, 0.4, -0.1, and there |x| < F
    n = np.minimum(result.t // np.pi, 3)
    side = (-1) ** n
    x = side * np.where(n < 3, F + (1 - (2 * n + 1) * F) * np.cos(result.t - n * np.pi), 0.1)
    np.testing.assert_allclose(result.x[:, 0], x, atol=EXACT)
    assert times_of(result, "crosses") == pytest.approx([np.pi, 2 * np.pi], abs=10 * EXACT)
    assert times_of(result, "slides") == pytest.approx([3 * np.pi], abs=10 * EXACT)


def test_super_twisting_crosses_in_a_geometric_sequence_and_settles_at_its_end():
    k1, k2, v0 = 1.5, 1.1, 2.0

    def law(t, x):
        return [-k1 * ca.sqrt(ca.fabs(x[0])) * ca.sign(x[0]) + x[1], -k2 * ca.sign(x[0])]

    result = run(law, [0.0, v0], 4.0)
    # with w = sqrt|x| and dt = 2 w dtau a phase is linear, w' = v - k1 w, v' = -2 k2 w: it turns v into -r v, and as
    # v falls at the rate k2, lasts v (1 + r) / k2
    r = np.exp(-k1 * np.pi / (2 * np.sqrt(2 * k2 - k1**2 / 4)))
    n = np.arange(1, 6)
    np.testing.assert_allclose(times_of(result, "crosses")[:5], v0 * (1 + r) / k2 * (1 - r**n) / (1 - r), atol=1e-9)
    np.testing.assert_allclose([e.rate for e in result.events[:5]], v0 * (-r) ** n, atol=1e-9)
    (end,) = times_of(result, "settles")
    assert end == pytest.approx(v0 * (1 + r) / (1 - r) / k2, abs=1e-8)
    np.testing.assert_allclose(result.x[result.t > end], 0.0, atol=1e-15)


def test_super_twisting_with_a_large_gain_settles_without_a_crossing():
    # v falls at the rate k2 all the way, and x with it: both are at zero after v0 / k2
    result = run(
        lambda t, x: [-20 * ca.sqrt(ca.fabs(x[0])) * ca.sign(x[0]) + x[1], -10 * ca.sign(x[0])], [0.0, 2.0], 1.0
    )
    (event,) = result.events
    assert event.what == "settles"
    assert event.t == pytest.approx(0.2, abs=1e-7)
    np.testing.assert_allclose(result.x[:, 1], np.maximum(0, 2 - 10 * result.t), atol=1e-7)


def test_super_twisting_holds_second_order_sliding_against_a_perturbation():
    def law(t, x):
        return [
            -1.5 * ca.sqrt(ca.fabs(x[0])) * ca.sign(x[0]) + x[1] + 0.3 * ca.sin(t),
            -1.1 * ca.sign(x[0]),
        ]

    result = run(law, [0.5, 1.0], 6.0)
    (end,) = times_of(result, "settles")
    later = result.t > end
    np.testing.assert_allclose(result.x[later, 0], 0.0, atol=1e-14)
    np.testing.assert_allclose(result.x[later, 1], -0.3 * np.sin(result.t[later]), atol=EXACT)


def test_two_surfaces_are_slid_on_one_after_the_other_and_then_both():
    def rate(t, x):
        return [-ca.sign(x[0]) + 0.3 * ca.sign(x[1]), -ca.sign(x[1]) - 0.2 * ca.sign(x[0])]

    result = run(rate, [1.0, 0.5], 3.0)
    # x2 falls at 1.2; then u2 = -0.2 keeps it, and x1 falls at 1 + 0.3 * 0.2 instead of 0.7
    first = 0.5 / 1.2
    second = first + (1 - 0.7 * first) / 1.06
    assert times_of(result, "slides") == pytest.approx([first, second], abs=1e-14)
    assert (
        result.sliding_spans[-1] == (times_of(result, "slides")[1], 3.0, ("x[1]", "x[0]"))
        or len(result.sliding_spans[-1][2]) == 2
    )
    np.testing.assert_allclose(result.x[result.t > second], 0.0, atol=1e-15)


def test_surfaces_that_are_reached_at_one_instant_are_taken_together():
    result = run(lambda t, x: [-ca.sign(x[0]), -2 * ca.sign(x[1])], [1.0, 2.0], 3.0)
    np.testing.assert_allclose(result.x, np.maximum(0, 1 - result.t)[:, np.newaxis] * [1, 2], atol=1e-14)
    assert result.sliding_spans[-1][2] == ("x[0]", "x[1]")


def test_one_surface_by_several_names_is_one():
    result = run(lambda t, x: [-ca.sign(x[0]) - ca.sign(2 * x[0]) + ca.sign(-x[0]) / 3], [1.0], 1.0)
    np.testing.assert_allclose(result.x[:, 0], np.maximum(0, 1 - 7 / 3 * result.t), atol=1e-14)
    assert len(result.sliding_spans) == 1


def test_a_clock_switches_at_every_one_of_its_instants():
    # x' = sign sin(50 t) with no other motion: a triangle of height pi / 50, which no error of x reveals
    result = run(lambda t, x: [ca.sign(ca.sin(50 * t))], [0.0], 3.0)
    phase = np.mod(50 * result.t, 2 * np.pi)
    np.testing.assert_allclose(result.x[:, 0], np.minimum(phase, 2 * np.pi - phase) / 50, atol=1e-13)
    np.testing.assert_allclose(times_of(result, "crosses"), np.pi / 50 * np.arange(1, 48), atol=1e-13)


def test_two_crossings_within_one_step_are_both_found():
    result = run(lambda t, x: [1.0, ca.sign((x[0] - 1) ** 2 - 1e-8)], [0.0, 0.0], 2.0)
    np.testing.assert_allclose(times_of(result, "crosses"), [1 - 1e-4, 1 + 1e-4], atol=1e-12)
    np.testing.assert_allclose(result.x[-1], [2.0, 2 - 4e-4], atol=1e-12)

"""The reference mode: closed forms with jumps, corners and sliding; its own error estimate; every refusal by name."""

import casadi as ca
import numpy as np
import pytest
from scipy.linalg import expm

from tests.support.equations import decay, explosion, oscillator, root
from workbench.arms.laws import AosmcRgs
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import FullState
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Sines
from workbench.core import Entry, Layout, Ode, rk4
from workbench.core.numbers import Bounds
from workbench.engine import simulate
from workbench.engine.reference import reference, reference_of_function

# The runs below are asked for 1e-10, and what is handed back is closer by far; a factor is what an equation magnifies.
EXACT = 1e-10


def equation(rate, x0) -> Ode:
    """x' = rate(t, x) from x0."""
    states = Layout((Entry("x", np.array(x0, dtype=float)),))
    t, x = ca.SX.sym("t"), states.symbols()
    return Ode.of("equation", states, Layout(), (t, x, ca.SX(0, 1)), {"x": ca.vertcat(*rate(t, x))}, {})


def run(rate, x0, until, count=31, **options):
    return reference(equation(rate, x0), times=np.linspace(0, until, count), **options)


def times_of(result, what):
    return [event.t for event in result.events if event.what == what]


# Smooth equations


@pytest.mark.parametrize("tol", [1e-4, 1e-7, 1e-10])
def test_smooth_equations_follow_their_closed_forms_at_each_tolerance(tol):
    turning = reference(oscillator(), times=[1.0, 5.0, 20.0], rtol=tol, atol=tol)
    growing = run(lambda t, x: [x[0] * ca.cos(t)], [1.0], 20.0, rtol=tol, atol=tol)
    logistic = run(lambda t, x: [x[0] * (1 - x[0])], [0.1], 10.0, rtol=tol, atol=tol)
    # an oscillation adds its errors up, once a radian: 40 of them
    np.testing.assert_allclose(turning.x[:, 0], np.cos(2 * turning.t), atol=40 * tol)
    np.testing.assert_allclose(growing.x[:, 0], np.exp(np.sin(growing.t)), atol=10 * tol)
    np.testing.assert_allclose(logistic.x[:, 0], 1 / (1 + 9 * np.exp(-logistic.t)), atol=10 * tol)


@pytest.mark.parametrize("method", ["explicit", "implicit"])
def test_the_error_estimate_is_above_the_error(method):
    result = reference(oscillator(), times=[1.0, 5.0], rtol=1e-6, atol=1e-8, method=method)
    error = np.abs(result.x[:, 0] - np.cos(2 * result.t))
    assert (error < result.error[:, 0]).all()
    assert (result.error < 1e-3).all()
    assert result.method == method


def test_a_stiff_equation_is_left_to_the_implicit_method():
    # Prothero and Robinson: x' = -L (x - cos t); beyond the transient x = (L^2 cos t + L sin t) / (1 + L^2)
    L = 1e6
    result = run(lambda t, x: [-L * (x[0] - ca.cos(t))], [0.0], 3.0, count=4)
    t = result.t[1:]
    np.testing.assert_allclose(result.x[1:, 0], (L**2 * np.cos(t) + L * np.sin(t)) / (1 + L**2), atol=EXACT)
    assert result.method == "implicit"
    assert result.steps < 2000  # an explicit method needs 3 L / 6 of them
    assert reference(oscillator(), times=[1.0]).method == "explicit"


def test_a_plain_function_gives_what_its_equation_gives():
    plain = reference_of_function(lambda t, x: [x[1], -np.sin(x[0])], [3.0, 0.0], times=[0.0, 2.0, 8.0])
    result = reference(equation(lambda t, x: [x[1], -ca.sin(x[0])], [3.0, 0.0]), times=[0.0, 2.0, 8.0])
    np.testing.assert_allclose(plain.x, result.x, atol=10 * EXACT)  # started near the top, where errors grow
    np.testing.assert_array_equal(plain.x[0], [3.0, 0.0])
    stiff = reference_of_function(lambda t, x: -1e4 * x, [1.0], times=[1.0], method="implicit")
    np.testing.assert_allclose(stiff.x, 0.0, atol=EXACT)


def test_the_initial_time_alone_is_answered_with_the_initial_state():
    np.testing.assert_array_equal(reference(decay(), times=[0.0]).x, [[1.0]])
    np.testing.assert_array_equal(reference_of_function(lambda t, x: -x, [2.0], times=[0.0]).x, [[2.0]])


def test_parameters_and_initial_states_are_those_given():
    ode = decay()
    result = reference(ode, ode.parameters.pack({"rate": 0.5})[0], np.array([4.0]), times=[2.0])
    np.testing.assert_allclose(result.x[0, 0], 4 * np.exp(-1.0), rtol=EXACT)


# Jumps


def test_a_relay_reaches_its_surface_at_the_known_time_and_slides_on_it():
    result = run(lambda t, x: [-ca.sign(x[0]) + 0.3], [1.0], 3.0)
    np.testing.assert_allclose(result.x[:, 0], np.maximum(0, 1 - 0.7 * result.t), atol=1e-15)
    (event,) = result.events
    assert (event.what, event.surface) == ("slides", "x[0]")
    assert event.t == pytest.approx(1 / 0.7, abs=1e-15)
    assert event.rate == pytest.approx(-0.7)
    assert result.slid == ((event.t, 3.0, ("x[0]",)),)


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
    result = reference(equation(lambda t, x: [-ca.sign(x[0]) + a * ca.sin(w * t + phase)], [0.0]), times=times)
    # held until a sin = 1, then x' = a sin - 1 until it is back at zero; and half a period later the same below
    half, s = np.pi / w, times + phase / w
    n, left = (s - np.arcsin(1 / a) / w) // half, np.arcsin(1 / a) / w
    tau = s - n * half
    x = (-1) ** n * np.maximum(0, left - tau - a / w * (np.cos(w * tau) - np.cos(w * left)))
    np.testing.assert_allclose(x, [-0.14320, 0.18455, -0.11782], atol=1e-5)  # as LSODA has it, with a steep tanh
    np.testing.assert_allclose(result.x[:, 0], x, atol=EXACT)


def test_a_push_in_any_phase_is_followed_off_the_surface_and_back():
    rng = np.random.default_rng(0)
    for a, w, phase in rng.uniform([1.05, 1, 0], [3, 5, 6], (5, 3)):
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
    assert result.slid[-1] == (times_of(result, "slides")[1], 3.0, ("x[1]", "x[0]")) or len(result.slid[-1][2]) == 2
    np.testing.assert_allclose(result.x[result.t > second], 0.0, atol=1e-15)


def test_surfaces_that_are_reached_at_one_instant_are_taken_together():
    result = run(lambda t, x: [-ca.sign(x[0]), -2 * ca.sign(x[1])], [1.0, 2.0], 3.0)
    np.testing.assert_allclose(result.x, np.maximum(0, 1 - result.t)[:, np.newaxis] * [1, 2], atol=1e-14)
    assert result.slid[-1][2] == ("x[0]", "x[1]")


def test_one_surface_by_several_names_is_one():
    result = run(lambda t, x: [-ca.sign(x[0]) - ca.sign(2 * x[0]) + ca.sign(-x[0]) / 3], [1.0], 1.0)
    np.testing.assert_allclose(result.x[:, 0], np.maximum(0, 1 - 7 / 3 * result.t), atol=1e-14)
    assert len(result.slid) == 1


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


# Corners and other switches


def test_corners_are_located_and_crossed():
    result = run(lambda t, x: [1.0, ca.fabs(x[0]), ca.fmax(-0.5, ca.fmin(x[0], 0.25))], [-1.0, 0.0, 0.0], 2.0)
    t, y = result.t, result.t - 1
    saturated = np.where(y < -0.5, -0.5 * t, np.where(y < 0.25, -0.375 + y**2 / 2, -0.375 - 0.03125 + 0.25 * y))
    np.testing.assert_allclose(result.x[:, 1], 0.5 + np.sign(y) * y**2 / 2, atol=1e-14)
    np.testing.assert_allclose(result.x[:, 2], saturated, atol=1e-14)
    np.testing.assert_allclose(times_of(result, "crosses"), [0.5, 1.0, 1.25], atol=1e-14)


def test_a_boundary_layer_is_entered_at_its_edge_and_ends_linear():
    lam, k, phi = 6.0, 5.0, 0.1
    result = run(lambda t, x: [x[1], -lam * x[1] - k * ca.fmax(-1, ca.fmin(1, (lam * x[0] + x[1]) / phi))], [1, 0.5], 3)
    T = (6.5 - phi) / k
    (event,) = result.events
    assert event.t == pytest.approx(T, abs=1e-13)
    a = (6.5 + k / lam) / lam
    e = (1 - a) * np.exp(-lam * T) + a - k * T / lam
    inside = np.array([[0, 1], [-k * lam / phi, -lam - k / phi]])
    expected = [expm(inside * (t - T)) @ [e, phi - lam * e] for t in result.t if t > T]
    np.testing.assert_allclose(result.x[result.t > T], expected, atol=10 * EXACT)


@pytest.mark.parametrize("phi", [1e-5])
def test_a_thin_boundary_layer_is_entered_and_followed(phi):
    result = run(lambda t, x: [x[1], -6 * x[1] - 5 * ca.fmax(-1, ca.fmin(1, (6 * x[0] + x[1]) / phi))], [1, 0], 1.5, 2)
    # s = 6 e + e' falls at the rate 5 to phi, and inside decays as exp(-5 t / phi); e' = -6 e + s
    T = (6 - phi) / 5
    e = (1 - 41 / 36) * np.exp(-6 * T) + 41 / 36 - 5 * T / 6
    inside = e + phi / (5 / phi - 6)
    np.testing.assert_allclose(result.x[1:, 0], inside * np.exp(-6 * (result.t[1:] - T)), atol=EXACT)


def test_a_staircase_is_climbed_step_by_step_and_slid_along_where_the_rate_holds_it():
    up = run(lambda t, x: [1.0, ca.floor(3 * x[0]), ca.ceil(3 * x[0])], [0.0, 0.0, 0.0], 3.0)
    assert up.x[-1, 1] == pytest.approx(sum(range(9)) / 3, abs=1e-13)
    assert up.x[-1, 2] == pytest.approx(sum(range(1, 10)) / 3, abs=1e-13)
    held = run(lambda t, x: [0.45 - 0.1 * ca.floor(x[0] / 0.1)], [0.0], 8.0)  # 0.45 above, 0.05; below 0.5 it rises
    assert held.x[-1, 0] == pytest.approx(0.5, abs=1e-14)
    assert times_of(held, "slides") == pytest.approx([sum(0.1 / (0.45 - 0.1 * n) for n in range(5))], abs=1e-13)


def test_two_staircases_a_quarter_of_a_step_apart_are_climbed():
    result = run(lambda t, x: [ca.floor(t) - ca.floor(t - 0.25)], [0.0], 3.0)
    assert result.x[-1, 0] == pytest.approx(3 * 0.25, abs=1e-13)
    assert times_of(result, "crosses") == pytest.approx([0.25, 1.0, 1.25, 2.0, 2.25], abs=1e-13)


def test_conditions_are_surfaces_too():
    def rate(t, x):
        late = ca.logic_and(x[0] >= 1.5, ca.logic_not(t < 0.2))
        return [ca.if_else(x[0] < 1, 1.0, ca.if_else(ca.logic_or(late, x[0] > 9), -1.0, 0.5))]

    result = run(rate, [0.0], 4.0)
    expected = np.minimum(1.5, np.where(result.t < 1, result.t, 1 + 0.5 * (result.t - 1)))
    np.testing.assert_allclose(result.x[:, 0], expected, atol=1e-14)


def test_a_branch_that_is_not_taken_may_have_no_value():
    result = run(lambda t, x: [1.0, ca.if_else(x[0] > 0, ca.sqrt(x[0]), 0)], [-1.0, 0.0], 2.0)
    np.testing.assert_allclose(result.x[-1, 1], 2 / 3, atol=EXACT)


def test_a_surface_whose_function_jumps_with_another_is_met_where_it_jumps_to():
    result = run(lambda t, x: [1.0, -ca.sign(x[1] + 2 * ca.sign(x[0] - 1))], [0.0, 0.0], 4.0)
    np.testing.assert_allclose(result.x[:, 1], np.where(result.t < 1, result.t, 2 - result.t), atol=1e-13)


# A loop of the workbench


def aosmc(shape):
    law = AosmcRgs(
        paper_arm(), 6.0, 0.05, 5 * np.eye(2), 10 * np.eye(2), np.eye(2), np.eye(2), "reference", "raised", shape
    )
    return ClosedLoop(Manipulator(paper_arm(), q=[0.6, -0.8]), FullState(2), law, Sines([1.0, 0.5], [2.0, 3.0])).ode()


@pytest.mark.parametrize(
    ("shape", "h", "error"),
    [
        ("norm", 1e-5, 1e-9),  # corners: second order in the step, and fourth between them
        ("outer", 1e-5, 1e-5),  # jumps: first order, at most a step of them
    ],
)
def test_a_loop_of_the_workbench_is_the_limit_of_its_fixed_steps(shape, h, error):
    ode = aosmc(shape)
    times = np.array([0.1, 0.25, 0.4])
    result = reference(ode, times=times)
    runs = simulate(rk4(ode, h), until=0.4)
    steps = runs.x[0, np.round(times / h).astype(int)]
    np.testing.assert_allclose(result.x, steps, atol=error)
    assert (result.error < 1e-9).all()
    assert len(result.events) >= 3


# Surfaces that the state never leaves


@pytest.mark.parametrize(
    "rate",
    [
        lambda t, x: [ca.sign(x[1]), 0],
        lambda t, x: [ca.if_else(x[1] <= 0, 1, 2), 0],
        lambda t, x: [-x[0] + ca.sign(x[1]), -x[1]],
    ],
)
def test_a_state_that_stays_where_each_side_has_its_own_rate_is_refused(rate):
    with pytest.raises(ValueError, match=r"t = 0 s, where the state stays on x\[1\] = 0, where each side has a rate"):
        run(rate, [0.0, 0.0], 1.0)


@pytest.mark.parametrize("corner", [ca.fabs, lambda y: ca.fmax(y, 0), lambda y: y * ca.sign(y)])
def test_a_state_that_stays_on_a_corner_has_one_rate(corner):
    result = run(lambda t, x: [1 + corner(x[1]), -x[1]], [0.0, 0.0], 1.0)
    np.testing.assert_allclose(result.x[:, 0], result.t, atol=1e-15)


# Refusals

REFUSED = [
    (lambda t, x: [ca.sign(x[0])], [0.0], "t = 0 s.*more than one side.*not unique"),
    (lambda t, x: [-ca.sign(x[0]) + ca.sign(x[0]) * ca.sign(x[0] + 0 * t) / 2], [1.0], "t = 2 s.*not affine"),
    (lambda t, x: [x[1], -2 * ca.sign(x[0]) - ca.sign(x[1])], [1.0, 0.0], "t = 4.4614.*accumulate.*not determined"),
    (lambda t, x: [x[1], x[2], -ca.sign(x[0])], [0.0, 0.0, 0.0], "t = 0 s.*first two derivatives"),
    (lambda t, x: [x[0] ** 2], [1.0], r"t = 1\.0000.*finite escape"),
    (lambda t, x: [1000 * x[0]], [1.0], "finite escape"),
    (lambda t, x: [-ca.sign(x[0] + 5) * ca.sqrt(ca.fabs(x[0]) - 0.5)], [1.0], "rate is not finite"),
    (lambda t, x: [ca.log(x[0])], [-1.0], "t = 0 s, where the rate is not finite"),
    (lambda t, x: [-1 / x[0]], [1.0], "t = 0.49.*no step is short enough|rate is not finite"),
    (lambda t, x: [ca.if_else(x[0] == 0, 1, 0)], [1.0], "'eq'.*has none"),
    (lambda t, x: [ca.fmod(x[0], 2)], [1.0], "'fmod'"),
    (lambda t, x: [ca.if_else(x[0], 1, 0)], [1.0], "'if_else of a number'"),
    (lambda t, x: [*(-ca.sign(x[i]) for i in range(6))], [1.0] * 6, "t = 1 s.*6 surfaces at once"),
]


@pytest.mark.parametrize(("rate", "x0", "words"), REFUSED)
def test_what_cannot_be_continued_is_refused_by_name_with_the_time(rate, x0, words):
    with pytest.raises(ValueError, match=words):
        run(rate, x0, 6.0)


def test_a_run_that_needs_too_many_steps_says_how_far_it_came():
    with pytest.raises(ValueError, match="t = .* s, after 50 steps: allow more with `most_steps`"):
        reference(oscillator(), times=[1000.0], most_steps=50)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"times": []}, "times"),
        ({"times": [1.0, 1.0]}, "increase"),
        ({"times": [-1.0, 1.0]}, "from 0 on"),
        ({"times": [1.0, np.nan]}, "finite"),
        ({"times": "soon"}, "soon"),
        ({"rtol": 1e-15}, "double precision"),
        ({"rtol": "fine"}, "fine"),
        ({"atol": 0.0}, "positive"),
        ({"atol": [1e-9] * 3}, r"shape \(1,\)"),
        ({"method": "euler"}, "explicit"),
        ({"most_steps": 0}, "most_steps"),
        ({"p": [1.0, 2.0]}, r"reference\(p=...\)"),
        ({"p": [-1.0]}, "'omega'"),
        ({"x0": [np.nan]}, "finite"),
    ],
)
def test_arguments_that_are_not_as_they_must_be_are_refused(options, words):
    states, parameters = Layout((Entry("x", np.ones(1)),)), Layout((Entry("omega", np.ones(()), "", Bounds(low=0)),))
    t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
    ode = Ode.of("one", states, parameters, (t, x, p), {"x": -p * x}, {})
    with pytest.raises(ValueError, match=words):
        reference(ode, **{"times": [1.0], **options})


def test_what_is_no_equation_is_refused_with_the_way_to_one():
    with pytest.raises(ValueError, match="must be an `Ode`; got"):
        reference(rk4(decay(), 0.1), times=[1.0])
    with pytest.raises(ValueError, match=r"`reference_of_function\(f=...\)` must be a function; got 3.0"):
        reference_of_function(3.0, [1.0], times=[1.0])


def test_a_plain_function_is_refused_where_it_has_no_finite_rate():
    with pytest.raises(ValueError, match="each of the 2 states"):
        reference_of_function(lambda t, x: [1.0], [1.0, 2.0], times=[1.0])
    with pytest.raises(ValueError, match="finite escape"):
        reference_of_function(lambda t, x: x**2, [1.0], times=[2.0])
    with pytest.raises(ValueError, match="t = 0 s, where the rate is not finite"):
        reference_of_function(lambda t, x: x * np.nan, [1.0], times=[2.0])


def test_an_exception_of_a_plain_function_is_told_with_the_time():
    def breaks(t, x):
        return [1 / 0] if t > 1 else -x

    with pytest.raises(
        ValueError, match=r"stops at t = .*, where the function raised ZeroDivisionError: division"
    ) as e:
        reference_of_function(breaks, [1.0], times=[2.0])
    assert isinstance(e.value.__cause__, ZeroDivisionError)


@pytest.mark.parametrize("options", [{"times": []}, {"rtol": 2.0}, {"atol": 0.0}, {"method": "x"}, {"most_steps": 0}])
def test_a_refusal_names_the_function_that_was_called(options):
    with pytest.raises(ValueError, match=rf"`reference_of_function\({next(iter(options))}=...\)`"):
        reference_of_function(lambda t, x: -x, [1.0], **{"times": [1.0], **options})
    with pytest.raises(ValueError, match=r"`reference_of_function\(x0=...\)` must have shape \(1,\).*got \(0,\)"):
        reference_of_function(lambda t, x: -x, [], times=[1.0])


def test_numbers_of_numpy_are_numbers():
    result = reference(decay(), times=[1.0], rtol=np.float32(1e-6), most_steps=np.int64(1000))
    assert result.x[0, 0] == pytest.approx(np.exp(-3.0), abs=1e-6)


def test_an_equation_without_a_lipschitz_constant_at_its_start_and_one_that_escapes_after_the_last_time_are_run():
    assert reference(root(), times=[1.0]).x[0, 0] == 0.0  # of all solutions of x' = sqrt(x) from 0 the one that stays
    assert reference(explosion(), times=[0.9]).x[0, 0] == pytest.approx(10.0, rel=1e-8)

"""`c2d` against python-control, SciPy, runs by RK4 and closed forms; what has no sampled system is refused by name."""

import control
import numpy as np
import pytest
from scipy.linalg import expm
from scipy.signal import cont2discrete

from workbench.core import Entry, Layout
from workbench.core.point import OperatingPoint
from workbench.design.frequency import c2d
from workbench.design.linear.pointed_systems import PointedSpace, PointedTransfer
from workbench.design.matrices import DesignError

H = 0.1
# fmt: off
TWO = control.ss([[0, 1, 0], [-9, -0.6, 1], [0, 0, -4]], [[0, 0], [1, 0], [0, 2]], [[1, 0, 0], [0, 1, 1]],
                 [[0, 0], [0.5, 0]], name="two", inputs=["f", "g"], outputs=["x", "y"], states=["a", "b", "c"])
# fmt: on
TRANSFERS = [([2, 1], [1, 3, 5]), ([1], [1, 0]), ([1, 2], [1, 4]), ([3], [1, 0.2, 9, 0]), ([1, 0], [1, 1, 1])]
ROUNDING = {"rtol": 1e-11, "atol": 1e-13}  # a dozen states, moderate numbers


@pytest.mark.parametrize(("method", "theirs"), [("zoh", "zoh"), ("tustin", "bilinear")])
def test_a_state_space_is_sampled_as_by_scipy_and_python_control(method, theirs):
    ours, scipys = c2d(TWO, H, method), cont2discrete((TWO.A, TWO.B, TWO.C, TWO.D), H, theirs)
    peer = control.sample_system(TWO, H, theirs)
    for name, reference in zip("ABCD", scipys[:4], strict=True):
        np.testing.assert_allclose(getattr(ours, name), reference, **ROUNDING)
        np.testing.assert_allclose(getattr(ours, name), getattr(peer, name), **ROUNDING)
    assert (ours.name, ours.dt) == (peer.name, H)
    assert (ours.input_labels, ours.output_labels, ours.state_labels) == (["f", "g"], ["x", "y"], ["a", "b", "c"])


@pytest.mark.parametrize(("num", "den"), TRANSFERS)
@pytest.mark.parametrize(("method", "theirs"), [("zoh", "zoh"), ("tustin", "bilinear")])
def test_a_transfer_function_is_sampled_as_by_python_control(num, den, method, theirs):
    system = control.tf(num, den)
    z = np.exp(1j * np.array([0.05, 0.7, 2.0, 3.1]))
    peer = control.sample_system(system, H, theirs)(z)  # whose numerators are differences of two polynomials
    np.testing.assert_allclose(c2d(system, H, method)(z), peer, rtol=1e-9, atol=1e-14)


def test_a_prewarped_system_is_exact_at_its_frequency_and_python_control_s():
    system, w = control.tf([2, 1], [1, 0.3, 20]), 4.4
    for one in (system, control.ss(system)):
        ours = c2d(one, H, "prewarped", frequency=w)
        assert abs(ours(np.exp(1j * w * H)) - system(1j * w)) < 1e-12 * abs(system(1j * w))
        peer = control.sample_system(one, H, "bilinear", prewarp_frequency=w)
        np.testing.assert_allclose(ours(np.exp(0.3j)), peer(np.exp(0.3j)), rtol=1e-11)


@pytest.mark.parametrize(("num", "den"), [([2, 1], [1, 3, 5]), ([2], [1, 3]), ([1, 2], [1, 4]), ([1, 5], [1, 2, 2])])
def test_a_matched_system_is_python_control_s_where_at_most_one_zero_is_at_infinity(num, den):
    system, z = control.tf(num, den), np.exp(0.7j)
    np.testing.assert_allclose(c2d(system, H, "matched")(z), control.sample_system(system, H, "matched")(z), rtol=1e-11)


def test_matched_integrators_are_those_of_the_textbook():
    # Franklin, Powell and Workman (1998), section 6.1: 1/s^2 becomes h^2 / 2 (z + 1) / (z - 1)^2 by the modified method
    double = c2d(control.tf([1], [1, 0, 0]), H, "matched")
    np.testing.assert_allclose(double.num_list[0][0], [H**2 / 2, H**2 / 2], rtol=1e-14)
    np.testing.assert_allclose(double.den_list[0][0], [1, -2, 1], rtol=1e-14)
    derivative = c2d(control.tf([1, 0], [1, 5]), H, "matched")
    assert abs(derivative(1.0)) < 1e-15


def test_the_samples_behind_a_hold_are_those_of_a_run_by_rk4():
    rng, sampled, steps = np.random.default_rng(1), c2d(TWO, H), 400
    x, own = np.zeros(3), np.zeros(3)
    for _ in range(30):
        u = rng.normal(size=2)
        for _ in range(steps):  # error of RK4: (h / 400 * 4)^4, 1e-12
            slopes = [TWO.A @ x + TWO.B @ u]
            for part in (0.5, 0.5, 1.0):
                slopes.append(TWO.A @ (x + part * H / steps * slopes[-1]) + TWO.B @ u)
            x = x + H / steps / 6 * (slopes[0] + 2 * slopes[1] + 2 * slopes[2] + slopes[3])
        own = sampled.A @ own + sampled.B @ u
        np.testing.assert_allclose(own, x, atol=1e-11)


@pytest.mark.parametrize("h", [0.5, 1e-2, 1e-4])
@pytest.mark.parametrize("direct", [0.0, 2.0])
def test_a_matched_state_space_keeps_its_states_and_has_the_response_of_its_transfer_function(h, direct):
    rng = np.random.default_rng(1)
    A, B, C = rng.normal(size=(4, 4)) - 2 * np.eye(4), rng.normal(size=(4, 1)), rng.normal(size=(1, 4))
    system = control.ss(A, B, C, direct, states=["p", "q", "r", "s"])
    sampled, z = c2d(system, h, "matched"), np.exp(1j * np.array([0.1, 1.0, 3.0]))
    # the polynomials of the transfer function lose digits at 1e-4, the state space does not
    np.testing.assert_allclose(sampled(z), c2d(control.tf(system), h, "matched")(z), rtol=1e-10)
    assert sampled.state_labels == system.state_labels
    np.testing.assert_allclose(sampled.A, expm(A * h), rtol=1e-12)
    np.testing.assert_array_equal(sampled.C, C)
    assert sampled.dcgain() == pytest.approx(system.dcgain(), rel=1e-9)


def test_a_matched_state_space_needs_an_output_that_shows_all_states():
    hidden = control.ss([[-1, 0], [0, -2]], [[1], [1]], [[1, 0]], 0)
    with pytest.raises(DesignError, match="shows too little"):
        c2d(hidden, H, "matched")
    with pytest.raises(DesignError, match="always zero"):
        c2d(control.ss(-1, 1, 0, 0, remove_useless_states=False), H, "matched")
    assert c2d(control.ss([], [], [], 3.0), H, "matched").D.item() == 3


def test_each_entry_of_a_transfer_matrix_is_sampled():
    system = control.tf([[[1], [2, 1]], [[3], [0]]], [[[1, 1], [1, 4, 1]], [[1], [1]]], inputs=["a", "b"])
    sampled = c2d(system, H)
    entry = control.sample_system(control.tf([2, 1], [1, 4, 1]), H)
    np.testing.assert_allclose(sampled(np.exp(0.5j))[0, 1], entry(np.exp(0.5j)), rtol=1e-11)
    assert sampled.input_labels == ["a", "b"]


@pytest.mark.parametrize("method", ["zoh", "tustin"])
def test_a_sampled_system_is_about_the_point_of_the_continuous_one(method):
    point = OperatingPoint(_layout("a", "b", "c"), _layout("f", "g"), _layout("x", "y"), [1, 2, 3], [4, 5], [6, 7])
    sampled = c2d(PointedSpace(TWO, point), H, method)
    assert sampled.point is point
    assert (list(sampled.u0), sampled.input_labels) == ([4, 5], ["f", "g"])
    # a constant input holds the same states
    rest = np.linalg.solve(np.eye(3) - sampled.A, sampled.B)
    np.testing.assert_allclose(rest, -np.linalg.solve(TWO.A, TWO.B), **ROUNDING)


def test_a_sampled_compensator_is_about_the_point_of_the_continuous_one():
    point = OperatingPoint(Layout(), _layout("e"), _layout("u"), [], [0.0], [2.0])
    lead = PointedTransfer(control.tf([1, 1], [1, 10], inputs="e", outputs="u", name="lead"), point)
    sampled = c2d(lead, H, "matched")
    assert (sampled.point, sampled.input_labels, sampled.dt) == (point, ["e"], H)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((control.tf([1, 0, 0], [1, 1]), H), "must be proper"),
        ((TWO, 0.0), "positive"),
        ((TWO, -0.1), "positive"),
        ((TWO, float("nan")), "positive"),
        ((TWO, H, "foh"), "is one of"),
        ((TWO, H, "prewarped"), "must be given for the method 'prewarped'"),
        ((TWO, H, "tustin", 3.0), "and for no other"),
        ((TWO, H, "prewarped", 40.0), "Nyquist"),
        ((TWO, H, "prewarped", 0.0), "Nyquist"),
        ((TWO, H, "prewarped", float("nan")), "finite"),
        ((TWO, H, "matched"), "from one input to one output"),
        ((c2d(TWO, H), H), "continuous time"),
        ((3.0, H), "StateSpace"),
        ((control.ss([[np.nan]], [[1]], [[1]], 0), H), "finite"),
        ((control.tf([np.nan], [1, 1]), H), "finite"),
    ],
)
def test_what_cannot_be_sampled_is_refused(arguments, words):
    with pytest.raises(ValueError, match=words):
        c2d(*arguments)


@pytest.mark.parametrize("system", [control.tf([1], [1, -20]), control.ss([[20.0]], [[1]], [[1]], 0)])
def test_a_pole_that_tustin_maps_to_infinity_is_refused(system):
    with pytest.raises(DesignError, match="s = 20 1/s to infinity"):
        c2d(system, H, "tustin")


def test_a_pole_at_the_sampling_frequency_has_no_matched_gain():
    with pytest.raises(DesignError, match="multiple of the sampling frequency"):
        c2d(control.tf([1], [1, 0, (2 * np.pi / H) ** 2]), H, "matched")


@pytest.mark.parametrize("method", ["zoh", "matched"])
def test_a_plant_that_grows_beyond_all_numbers_within_a_period_is_refused(method):
    with pytest.raises(DesignError, match="range of floating-point numbers"):
        c2d(control.tf([1], [1, -1e4]), 1.0, method)


def _layout(*names):
    return Layout(tuple(Entry(name, np.zeros(()), "1") for name in names))

"""Corners: Jacobians of one side on request, else a refusal that names the corner, and only where it matters."""

import numpy as np
import pytest

import workbench as wb
from workbench.design.linear import along, broken_loop, loop_margins


def ode_of(f, states=("x",), inputs=("u",), **more):
    return wb.open_loop(wb.OdePlant.of(f, states=states, inputs=inputs, **more))


def model(f, x=0.0, u=0.0, **more):
    return wb.linearize(ode_of(f), 0.0, [x], u=[u], **more)


CLIP = ode_of(lambda t, x, u: [np.clip(u[0], 0, 1) - x[0]])


def test_a_clip_on_its_bound_is_refused_by_name_with_its_pieces():
    with pytest.raises(ValueError, match=r"of fmax\(u, 0\): its derivative by 'u' is 0 on one piece and 1 on another"):
        wb.linearize(CLIP, 0.0, [0.0], u=[0.0])
    with pytest.raises(ValueError, match=r"of fmin\(fmax\(u,0\), 1\).*`side=\{'u': 1\}`"):
        wb.linearize(CLIP, 0.0, [1.0], u=[1.0])
    assert wb.linearize(CLIP, 0.0, [0.5], u=[0.5]).B == 1.0


@pytest.mark.parametrize(
    ("side", "u", "B"),
    [("above", 0.0, 1.0), ("below", 0.0, 0.0), ({"u": 1}, 1.0, 0.0), ({"u": -1}, 1.0, 1.0), ("above", 0.5, 1.0)],
)
def test_one_side_of_a_corner_is_given_on_request(side, u, B):
    assert wb.linearize(CLIP, 0.0, [u], u=[u], side=side).B == B


CORNERS = [
    lambda t, x, u, m: [u[0] - m.abs(x[0])],
    lambda t, x, u, m: [u[0] - m.where(x[0] > 0, x[0], 2 * x[0])],
    lambda t, x, u, m: [m.fmax(x[0], u[0])],
    lambda t, x, u, m: [u[0] - 1e-6 * m.fmin(x[0], 0) - 1e3 * x[0]],
    lambda t, x, u, m: [np.copysign(x[0], x[0] + u[0]) + u[0]],
]


@pytest.mark.parametrize("f", CORNERS)
def test_a_corner_of_any_kind_is_refused(f):
    with pytest.raises(ValueError, match="has a corner at this state|jumps by"):
        model(f)


SMOOTH = [
    (lambda t, x, u, m: [u[0] - m.abs(x[0]) * x[0]], 0.0, 1.0),
    (lambda t, x, u, m: [u[0] - 1e4 * m.abs(x[0]) * x[0]], 0.0, 1.0),
    (lambda t, x, u, m: [u[0] - m.where(x[0] > 0, x[0], x[0] + x[0] ** 2)], -1.0, 1.0),
    (lambda t, x, u, m: [m.fmax(x[0], 0) + m.fmin(x[0], 0) + u[0]], 1.0, 1.0),
    (lambda t, x, u, m: [m.abs(x[0]) * u[0] + u[0]], 0.0, 1.0),
    (lambda t, x, u, m: [m.fmax(m.abs(x[0]), 1) + u[0]], 0.0, 1.0),
    # the mean of its pieces is -1, and it is zero on both
    (lambda t, x, u, m: [m.abs(m.abs(x[0]) + x[0]) - m.abs(x[0]) - x[0] + u[0]], 0.0, 1.0),
]


@pytest.mark.parametrize(("f", "A", "B"), SMOOTH)
def test_what_has_one_jacobian_is_linearised_with_that(f, A, B):
    linear = model(f)
    assert (linear.A[0, 0], linear.B[0, 0]) == (A, B)


def test_a_side_on_which_a_root_has_no_slope_is_refused():
    root = ode_of(lambda t, x, u, m: [u[0] - m.sqrt(m.fmax(x[0], 0))])
    with pytest.raises(ValueError, match="no derivative"):
        wb.linearize(root, 0.0, [0.0], u=[0.0], side={"x": 1})


def test_a_side_that_does_not_leave_the_corner_or_is_none_is_refused():
    with pytest.raises(ValueError, match="has a corner"):
        wb.linearize(CLIP, 0.0, [0.0], u=[0.0], side={"x": 1})
    with pytest.raises(LookupError, match="no 'v'"):
        wb.linearize(CLIP, 0.0, [0.0], u=[0.0], side={"v": 1})
    with pytest.raises(ValueError, match="must be 'above', 'below' or a mapping"):
        wb.linearize(CLIP, 0.0, [0.0], u=[0.0], side="left")


MOTOR = wb.DCMotor()
LIMITED = wb.PID(MOTOR.outputs, MOTOR.inputs, Kp=100.0, Ki=200.0, low=0.0, high=24.0)
AT_BOUND = wb.ClosedLoop(MOTOR, controller=LIMITED, reference=wb.Constant("omega", "rad/s", [0.0]))
FREE = wb.ClosedLoop(
    MOTOR,
    controller=wb.PID(MOTOR.outputs, MOTOR.inputs, Kp=100.0, Ki=200.0),
    reference=wb.Constant("omega", "rad/s", [0.0]),
)


def test_a_pid_at_rest_on_its_bound_has_all_of_its_gain_or_none():
    cut = AT_BOUND.cut()
    with pytest.raises(ValueError, match=r"'v' has a corner at this state, of fmax\(.*controller.low\[0\]\)"):
        broken_loop(cut, 0.0, cut.states.default)
    (limited,) = loop_margins(broken_loop(cut, 0.0, cut.states.default, side={"plant.omega": -1}))
    whole = FREE.cut()
    (free,) = loop_margins(broken_loop(whole, 0.0, whole.states.default))
    assert limited.crossover == pytest.approx(free.crossover, rel=1e-9)


def test_a_pid_in_a_computer_at_rest_on_its_bound_is_refused_too():
    cut, whole = (loop.digital(0.01, at="omega") for loop in (AT_BOUND, FREE))
    with pytest.raises(ValueError, match=r"after the instant has a corner at this state, of fmax\(.*controller.low"):
        wb.linearize(cut, 0.0, cut.states.default)
    ours = wb.linearize(cut, 0.0, cut.states.default, side={"drive": -1})
    z = np.exp(0.1j)
    np.testing.assert_allclose(ours(z), wb.linearize(whole, 0.0, whole.states.default)(z), rtol=1e-9)


def test_a_corner_that_a_filter_does_not_depend_on_is_let_pass():
    ode = ode_of(lambda t, x, u, m: [m.fmax(u[0], 0) - x[0]])
    assert wb.steady_kalman(ode, [[1.0]], [[1.0]]).K[0, 0] == pytest.approx(np.sqrt(2) - 1)
    with pytest.raises(ValueError, match="has a corner"):
        wb.steady_kalman(ode_of(lambda t, x, u, m: [u[0] - m.abs(x[0])]), [[1.0]], [[1.0]])
    other = ode_of(lambda t, x, u, m: [u[0] - m.abs(x[0])])
    assert wb.steady_kalman(other, [[1.0]], [[1.0]], side={"x": 1}).K[0, 0] == pytest.approx(np.sqrt(2) - 1)


def test_along_a_motion_a_corner_has_the_slope_of_the_piece_ahead():
    ode = ode_of(lambda t, x, u, m: [u[0] - m.abs(x[0])], u0=[1.0])
    assert along(ode, [0.0], [[0.0]]).A[0, 0, 0] == -1.0  # x grows
    assert along(ode, [0.0], [[0.0]], ode.parameters.pack({"u": -1.0})[0]).A[0, 0, 0] == 1.0
    with pytest.raises(ValueError, match="has a corner"):
        along(ode, [0.0], [[0.0]], ode.parameters.pack({"u": 0.0})[0])


HALVES = [
    0.5,
    1.5,
    2.5,
    -0.5,
    -1.5,
    -2.5,
    2.0**51 + 0.5,
    2.0**52 + 1,
    -(2.0**53),
    1e300,
    0.49999999999999994,
    -0.3,
    0.7,
]
ROUND = {
    "np.rint": lambda t, x, u: [np.rint(x[0])],
    "np.round": lambda t, x, u: [np.round(x[0])],
    "np.around": lambda t, x, u: [np.around(x[0])],
    "round": lambda t, x, u: [round(x[0])],
    "of a vector": lambda t, x, u: np.round(x),
}


@pytest.mark.parametrize("name", ROUND)
def test_a_rounded_symbol_is_the_rounded_number(name):
    ode = ode_of(ROUND[name])
    np.testing.assert_array_equal([ode.rate_at(0.0, [x])[0] for x in HALVES], np.rint(HALVES))


def test_decimals_are_rounded_as_numpy_does_it_and_not_as_python_does():
    for digits in (1, -1):
        ode = ode_of(lambda t, x, u, digits=digits: [np.round(x[0], digits)])
        values = [0.25, 0.35, 25.0, 35.0, -15.0]
        np.testing.assert_array_equal([ode.rate_at(0.0, [x])[0] for x in values], np.round(values, digits))
    with pytest.raises(ValueError, match="rounds decimal digits"):
        ode_of(lambda t, x, u: [round(x[0], 1)])


def test_a_rest_point_on_a_corner_has_no_poles():
    ode = ode_of(lambda t, x, u, m: [u[0] - x[0] - 0.5 * m.abs(x[0])])
    (at_corner,) = wb.equilibria(ode, {"x": (-1.0, 1.0)}).points
    assert np.isnan(at_corner.poles).all()
    (beside,) = wb.equilibria(ode, {"x": (-1.0, 1.0)}, u=[0.3]).points
    assert beside.poles == pytest.approx([-1.5])

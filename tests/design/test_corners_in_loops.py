"""Corners within bounded loops: those of the same passes written out, where no choice leaves them out."""

from functools import reduce

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from workbench.design.linear import operating_point
from workbench.design.linear.switching_functions import SwitchingFunctions

PASSES = 3


def ode_of(rate):
    """x' = rate(x) + u as equations, for an expression of x (2, 1)."""

    @wb.block
    class Drawn(wb.Plant):
        x: np.ndarray = wb.initial(default=np.zeros(2), unit="m", shape=("n",))
        inputs, outputs = wb.layout(u="m/s"), wb.layout(y="m")

        def rate(self, t, x, u):
            return {"x": rate(x["x"]) + ca.vertcat(u["u"], 0.0)}

        def measure(self, t, x):
            return {"y": x["x"][0]}

    return wb.open_loop(Drawn())


def repeated(body, x, count=PASSES):
    """The passes of a body, written out."""
    return reduce(lambda c, _: body(c), range(count), x)


def in_loop(body, x, count=PASSES):
    (end,) = wb.bounded_loop(count, lambda c: (body(c),), x)
    return end


BODIES = {
    "clip": lambda c: ca.vertcat(0.5 * ca.fmax(c[0], 0.1), ca.fmin(c[1], c[0])),
    "size": lambda c: ca.vertcat(c[1] - ca.fabs(c[0]), 0.5 * c[0]),
    "choice": lambda c: ca.if_else(c[0] > c[1], ca.vertcat(c[1], 2 * c[0] - c[1]), 0.5 * c),
    "smooth": lambda c: ca.vertcat(ca.sin(c[1]), c[0] * c[1] - 0.2),
}
POINTS = [[0.4, 1.0], [0.2, 0.3], [0.0, 0.0], [0.5, 0.5], [0.1, 0.05], [0.05, 0.1], [-0.3, 0.7], [1.0, 1.0], [0.3, 0.2]]


def answer_of(ode, x, **options):
    """The matrix A at a state, or the sort of refusal."""
    try:
        return wb.linearize(ode, 0.0, x, **options).A
    except ValueError as error:
        return "corner" if "has a corner at this state" in str(error) else "jump" if "jumps by" in str(error) else error


@pytest.mark.parametrize("name", BODIES)
def test_a_loop_has_the_corners_of_the_same_passes_written_out(name):
    loop, plain = (ode_of(lambda x, way=way: way(BODIES[name], x)) for way in (in_loop, repeated))
    answers = [[answer_of(ode, x) for ode in (loop, plain)] for x in POINTS]
    for own, other in answers:
        if isinstance(other, str):
            assert own == other
        else:
            np.testing.assert_allclose(own, other, rtol=0, atol=1e-13)  # of products of three slopes of size 1
    if name != "smooth":
        assert {one for one, _ in answers if isinstance(one, str)}  # some of the points lie on a corner
        assert any(isinstance(one, np.ndarray) for one, _ in answers)


@pytest.mark.parametrize("side", [{"x[0]": 1}, {"x[0]": -1}, "above"])
def test_a_side_of_a_corner_in_a_loop_is_that_of_the_passes_written_out(side):
    loop, plain = (ode_of(lambda x, way=way: way(BODIES["clip"], x)) for way in (in_loop, repeated))
    np.testing.assert_array_equal(*(answer_of(ode, [0.4, 1.0], side=side) for ode in (loop, plain)))


def test_the_message_names_the_pass():
    ode = ode_of(lambda x: in_loop(BODIES["clip"], x))
    with pytest.raises(ValueError, match=r"of fmax\(\.\.\.\) in pass 3 of 3 of a loop: its derivative by 'x\[0\]' is"):
        wb.linearize(ode, 0.0, [0.4, 1.0])


def test_loops_in_loops_and_rows_backward_have_their_corners():
    def nested(x):
        def outer(c, row):
            inner = in_loop(lambda d: 1.5 * ca.fmax(d, row), c, 2)
            return inner + row, row

        end, _ = wb.bounded_loop(3, outer, x, ca.horzcat(x, 0.3 * x, ca.SX([0.1, 0.2])), backward=True)
        return end

    def plain(x):
        c = x
        for row in (ca.SX([0.1, 0.2]), 0.3 * x, x):
            c = repeated(lambda d, row=row: 1.5 * ca.fmax(d, row), c, 2) + row
        return c

    odes = ode_of(nested), ode_of(plain)
    texts = SwitchingFunctions.of(odes[0]).of_loops.texts
    assert len(texts) == 2 * 2 * 3
    assert texts[0] == "fmax(...) in pass 1 of 2 in pass 1 of 3 of a loop"
    sorts = []
    for x in ([0.1, 0.2], [0.2, 0.4], [0.4, 0.8], [0.0, 0.0], [1.0, -1.0], [0.5, 0.3]):
        own, other = (answer_of(ode, x) for ode in odes)
        sorts.append(isinstance(other, str))
        if sorts[-1]:
            assert own == other
        else:
            np.testing.assert_allclose(own, other, rtol=0, atol=1e-13)  # of products of six slopes of size 1
    assert True in sorts
    assert False in sorts


def test_a_corner_that_a_choice_leaves_out_is_not_seen():
    def choice(way):
        return lambda x: ca.if_else(x[1] > 0.5, way(BODIES["size"], x), 3 * x)

    loop, plain = (ode_of(choice(way)) for way in (in_loop, repeated))
    np.testing.assert_array_equal(wb.linearize(loop, 0.0, [0.0, 0.2]).A, 3 * np.eye(2))
    assert SwitchingFunctions.of(loop).at(0.0, np.array([0.0, 0.2]), loop.parameters.default).texts == ("0.5 < x[1]",)
    assert [answer_of(ode, [0.0, 0.7]) for ode in (loop, plain)] == ["corner", "corner"]
    assert [answer_of(ode, [0.0, 0.5]) for ode in (loop, plain)] == ["jump", "jump"]


def test_a_loop_whose_passes_jump_is_refused():
    ode = ode_of(lambda x: in_loop(lambda c: c + ca.if_else(c > 0.25, 1.0, 0.0), x))
    assert answer_of(ode, [0.25, 0.0]) == "jump"
    np.testing.assert_array_equal(answer_of(ode, [0.2, 0.0]), np.eye(2))


def test_the_derivative_of_a_loop_is_that_of_central_differences():
    rng = np.random.default_rng(3)
    ode = ode_of(lambda x: in_loop(BODIES["smooth"], x))
    for x in rng.uniform(-1, 1, (5, 2)):
        A, h = wb.linearize(ode, 0.0, x).A, 1e-5
        steps = [(ode.rate_at(0.0, x + h * e) - ode.rate_at(0.0, x - h * e)) / (2 * h) for e in np.eye(2)]
        np.testing.assert_allclose(A, np.transpose(steps), rtol=0, atol=1e-9)  # h^2, and rounding 1e-16 / h


@wb.block
class Marking(wb.Controller):
    """v = -K omega, with a memory that jumps with the sign of omega, and that nothing reads."""

    K: float = wb.parameter(default=2.0, unit="V s/rad")
    reads, drives = wb.layout(omega="rad/s"), wb.layout(v="V")

    @property
    def memory(self):
        return wb.layout(mark="1")

    def command(self, t, z, est, ref):
        return {"v": -self.K * est.omega}

    def update(self, t, z, est, ref):
        return {"mark": in_loop(lambda c: ca.if_else(c > 0, c + 1, c / 2), est.omega)}


def test_a_memory_that_jumps_and_that_nothing_reads_is_no_part_of_a_linear_loop():
    motor = wb.DCMotor()
    loop = wb.ClosedLoop(motor, controller=Marking())
    linear = wb.linear_loop(wb.DigitalLoop(loop, 0.01))
    assert "controller.mark" not in linear.models.closed_model.states
    with pytest.raises(ValueError, match=r"the rate of 'controller.mark' jumps by"):
        wb.linearize(loop.digital(0.01, inputs=True), 0.0, loop.digital(0.01).states.default)


@wb.block
class Clipped(wb.Controller):
    """v = the clip of -K omega + offset to at most 1, by passes of a loop."""

    K: float = wb.parameter(default=2.0, unit="V s/rad")
    offset: float = wb.parameter(default=0.0, unit="V")
    reads, drives = wb.layout(omega="rad/s"), wb.layout(v="V")

    def command(self, t, z, est, ref):
        return {"v": in_loop(lambda c: ca.fmin(c, 1.0), self.offset - self.K * est.omega)}


def test_rows_of_a_linear_loop_have_the_corners_within_loops():
    motor = wb.DCMotor()
    rest = operating_point(wb.open_loop(motor), {"v": 1.0}).x[0]
    linear = wb.linear_loop(wb.DigitalLoop(wb.ClosedLoop(motor, controller=Clipped()), 0.01))
    rows = linear.rows({"controller.offset": np.array([0.0, 0.5, 1.0 + 2.0 * rest, 1.5])})
    assert list(rows.reasons) == [2]
    assert "of fmin(...) in pass 1 of 3 of a loop" in rows.reasons[2]


@pytest.mark.heavy
def test_the_linear_loop_of_a_nonlinear_plan_at_rest_is_that_of_lqr():
    plant = wb.CartPole()
    model = wb.linearize(wb.open_loop(plant), t=0.0, x=np.zeros(4), at_rest=True)
    weights = np.diag([10.0, 1.0, 10.0, 1.0]), [[0.1]]
    design = wb.nonlinear_predictive_design(model, 0.02, *weights, 3, limits={"F": (-10.0, 10.0)})
    plan = wb.NonlinearPredictive.of(plant, design)
    laws = plan, wb.StateFeedback.of(plant, plan.K)
    loops = [wb.ClosedLoop(plant, observer=wb.FullState.of(plant), controller=law) for law in laws]
    answers = [wb.linear_loop(wb.DigitalLoop(loop, 0.02)).response([0.3, 3.0, 30.0], "L").values for loop in loops]
    # the law's own Runge-Kutta steps and its recursion over three stages, of numbers up to 1e3
    np.testing.assert_allclose(*answers, rtol=1e-9)

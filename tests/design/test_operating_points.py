"""A model knows its point: designs and laws made of it hold the nonlinear plant there, without being told again."""

import control
import numpy as np
import pytest

import workbench as wb
from workbench.design.linear import broken_loop, operating_point, poles, sensitivity
from workbench.design.matrices import DesignError


@wb.block
class BuckBoost(wb.Plant):
    """The averaged inverting converter: L i' = d V - (1 - d) v, C v' = (1 - d) i - v / R, with v counted downwards."""

    V: float = wb.parameter(default=12.0, unit="V", low=0)
    L: float = wb.parameter(default=1e-3, unit="H", low=0)
    C: float = wb.parameter(default=1e-3, unit="F", low=0)
    R: float = wb.parameter(default=10.0, unit="ohm", low=0)
    i: float = wb.initial(default=7.2, unit="A")
    v: float = wb.initial(default=23.5, unit="V")
    inputs, outputs = wb.layout(d="1"), wb.layout(i="A", v="V")

    def rate(self, t, x, u):
        return {
            "i": (u.d * self.V - (1 - u.d) * x.v) / self.L,
            "v": ((1 - u.d) * x.i - x.v / self.R) / self.C,
        }


@wb.block
class Boost(wb.Plant):
    """The averaged boost converter: L i' = V - (1 - d) v, C v' = (1 - d) i - v / R."""

    V: float = wb.parameter(default=12.0, unit="V", low=0)
    L: float = wb.parameter(default=1e-3, unit="H", low=0)
    C: float = wb.parameter(default=1.3e-4, unit="F", low=0)
    R: float = wb.parameter(default=10.0, unit="ohm", low=0)
    i: float = wb.initial(default=10.8, unit="A")
    v: float = wb.initial(default=36.0, unit="V")
    inputs, outputs = wb.layout(d="1"), wb.layout(v="V")

    def rate(self, t, x, u):
        return {"i": (self.V - (1 - u.d) * x.v) / self.L, "v": ((1 - u.d) * x.i - x.v / self.R) / self.C}


@wb.block
class Ball(wb.Plant):
    """A ball at a distance z below a magnet: m z'' = m g - c (i / z)^2."""

    m: float = wb.parameter(default=0.05, unit="kg", low=0)
    c: float = wb.parameter(default=4.9e-5, unit="N m^2/A^2", low=0)
    g: float = wb.parameter(default=9.8, unit="m/s^2")
    z: float = wb.initial(default=0.0105, unit="m")
    zd: float = wb.initial(default=0.0, unit="m/s")
    seen: tuple[str, ...] = ("z", "zd")
    inputs = wb.layout(i="A")

    @property
    def outputs(self):
        return wb.Layout(tuple(self.states[name] for name in self.seen))

    def rate(self, t, x, u):
        return {"z": x.zd, "zd": self.g - self.c / self.m * (u.i / x.z) ** 2}


def model(plant, wanted):
    ode = wb.open_loop(plant)
    point = operating_point(ode, wanted, u=[0.5])
    return wb.linearize(ode, 0.0, point.x, u=point.u, at_rest=True)


CONVERTER, BALL = BuckBoost(), Ball()
BUCKBOOST = model(CONVERTER, {"v": 24.0, "i": 7.2})
LEVITATED = model(BALL, {"z": 0.01, "zd": 0.0})
Q, R = np.diag([1.0, 1.0]), [[1e3]]
Qn, Rn = np.diag([1e2, 1e2]), 1e-2 * np.eye(2)


def test_a_linear_model_carries_its_point_with_names_and_units_and_is_a_system_of_python_control():
    assert isinstance(BUCKBOOST, control.StateSpace)
    np.testing.assert_allclose(BUCKBOOST.x0, [7.2, 24.0], rtol=1e-12)
    np.testing.assert_allclose(BUCKBOOST.u0, [2 / 3], rtol=1e-12)
    np.testing.assert_allclose(BUCKBOOST.y0, [7.2, 24.0], rtol=1e-12)
    point = BUCKBOOST.point
    assert [(e.name, e.unit) for e in point.states.entries] == [("i", "A"), ("v", "V")]
    assert [(e.name, e.unit) for e in point.inputs.entries] == [("d", "1")]
    assert np.isfinite(control.frequency_response(BUCKBOOST, [1.0, 10.0]).frdata).all()


@pytest.mark.parametrize(
    "convert",
    [
        lambda G: control.c2d(G, 1e-4),
        lambda G: G.sample(1e-4, "tustin"),
        lambda G: G[["i", "v"], "d"],
        lambda G: G[:, :],
    ],
)
def test_a_conversion_that_keeps_the_meaning_keeps_the_point(convert):
    np.testing.assert_array_equal(convert(BUCKBOOST).x0, BUCKBOOST.x0)
    np.testing.assert_array_equal(convert(BUCKBOOST).y0, BUCKBOOST.y0)


def test_a_part_of_a_model_has_its_part_of_the_point_and_a_product_has_none():
    part = BUCKBOOST["v", "d"]
    assert (part.y0, part.u0, part.output_labels) == (pytest.approx([24.0]), pytest.approx([2 / 3]), ["v"])
    assert part.point.outputs.names == ("v",)
    assert not hasattr(BUCKBOOST * control.tf([1.0], [1.0, 1.0]), "point")
    assert not hasattr(control.ss(BUCKBOOST), "point")


@pytest.mark.parametrize("period", [None, 1e-4])
def test_a_lqg_controller_as_it_stands_holds_the_converter_at_its_point(period):
    linear = BUCKBOOST if period is None else control.c2d(BUCKBOOST, period)
    loop = wb.ClosedLoop(CONVERTER, controller=wb.lqg(linear, Q, R, Qn, Rn).controller)
    step = wb.rk4(loop.ode(), 1e-5) if period is None else loop.digital(period).step(4)
    run = wb.simulate(step, until=0.2)
    # the nonlinear loop rests where it was linearised; 1e-6 is what is left of a start 0.5 V off
    assert run["v"][0, -1, 0] == pytest.approx(24.0, rel=1e-6)
    assert run["d"][0, -1, 0] == pytest.approx(2 / 3, rel=1e-6)


@pytest.mark.parametrize("order", [0, 1])
def test_a_controller_of_given_structure_holds_the_converter_at_its_point(order):
    G, none = BUCKBOOST, np.zeros((2, 1))
    plant = wb.synthesis.GeneralizedPlant(
        G.A, 10 * np.eye(2), G.B, [[0, 1], [0, 0]], G.C, np.zeros((2, 2)), [[0], [300.0]], np.zeros((2, 2)), none,
        measurements=tuple(G.output_labels), controls=tuple(G.input_labels), point=G.point,
    )  # fmt: skip
    structure = wb.structured_tuning.ControllerStructure(order)
    goals = (wb.structured_tuning.DesignGoal("h2"),)
    answer = wb.structured_tuning.structured_controller(plant, structure=structure, goals=goals, starts=1)
    loop = wb.ClosedLoop(CONVERTER, controller=answer.controller)
    run = wb.simulate(wb.rk4(loop.ode(), 1e-5), until=0.2)
    assert run["v"][0, -1, 0] == pytest.approx(24.0, rel=1e-6)
    assert run["d"][0, -1, 0] == pytest.approx(2 / 3, rel=1e-6)


def test_a_controller_about_the_point_rests_from_the_start_beside_a_plant_that_does():
    plant = BuckBoost(i=BUCKBOOST.x0[0], v=BUCKBOOST.x0[1])
    ode = wb.ClosedLoop(plant, controller=wb.lqg(BUCKBOOST, Q, R, Qn, Rn).controller).ode()
    assert np.abs(ode.rate_at(0.0, ode.states.default)).max() < 1e-8  # rounding of rates of 1e4


@pytest.mark.parametrize("design", [lambda G: wb.lqr(G, Q, R), lambda G: wb.place(G, [-300.0, -400.0])])
def test_a_regulator_of_a_design_holds_the_plant_at_the_point_of_the_design(design):
    loop = wb.ClosedLoop(CONVERTER, controller=wb.StateFeedback.of(CONVERTER, design(BUCKBOOST)))
    run = wb.simulate(wb.rk4(loop.ode(), 1e-5), until=0.2)
    assert run["v"][0, -1, 0] == pytest.approx(24.0, rel=1e-6)


def test_a_gain_alone_of_a_plant_that_does_not_rest_at_zero_is_refused_with_both_remedies():
    K = np.asarray(wb.lqr(BUCKBOOST, Q, R).K)  # a plain matrix, as one that was typed in
    for plant, gain in ((BALL, K), (Boost(), K)):
        with pytest.raises(ValueError, match=r"does not rest at x0 = 0 and u0 = 0: .*the design itself.*or x0=\.\.\."):
            wb.StateFeedback.of(plant, gain)
    assert wb.StateFeedback.of(Boost(), K, x0=[10.8, 36.0], u0=[2 / 3]).u0 == [2 / 3]
    assert wb.StateFeedback.of(wb.CartPole(), np.ones((1, 4))).u0 == [0.0]  # which rests there


def test_a_design_for_another_plant_or_for_no_rest_point_is_refused():
    with pytest.raises(ValueError, match="design made for the states i, v; this design is for z, zd"):
        wb.StateFeedback.of(CONVERTER, wb.lqr(LEVITATED, Q, R))
    moving = wb.linearize(wb.open_loop(CONVERTER), 0.0, [7.2, 20.0], u=[2 / 3])
    with pytest.raises(ValueError, match="design made at a rest point.*the rate of 'i' is"):
        wb.StateFeedback.of(CONVERTER, wb.lqr(moving, Q, R))
    with pytest.raises(ValueError, match=r"must be linear about a rest point.*control.ss\(system\)"):
        wb.LinearLaw(wb.lqg(moving, Q, R, Qn, Rn).controller)


def test_a_linear_plant_of_a_model_counts_from_the_point_of_the_model():
    plant = wb.LinearPlant(BUCKBOOST)
    np.testing.assert_allclose(plant.states.default, BUCKBOOST.x0)
    ode = wb.open_loop(plant)
    np.testing.assert_allclose(ode.rate_at(0.0, BUCKBOOST.x0, ode.parameters.pack({"d": 2 / 3})[0]), 0, atol=1e-9)
    assert ode.outputs_at(0.0, BUCKBOOST.x0)["v"] == pytest.approx(24.0)
    assert plant.outputs["v"].unit == "V"


def test_an_explicit_point_of_a_law_stands_in_the_place_of_its_own():
    C = wb.lqg(BUCKBOOST, Q, R, Qn, Rn).controller
    law = wb.LinearLaw(C, u0=[0.1], v0=[1.0, 2.0])
    assert (law.u0.tolist(), law.v0.tolist()) == ([0.1], [1.0, 2.0])
    assert wb.LinearLaw(C).u0 == pytest.approx([2 / 3])


def test_a_lead_for_a_model_commands_the_input_of_the_point_where_the_error_is_zero():
    buck = wb.BuckConverter(i=5.0, v=15.0)
    G = wb.linearize(wb.open_loop(buck), 0.0, [5.0, 15.0], u=[15 / 28], at_rest=True)
    C = wb.lead_lag(G, crossover=31_416.0, margin=50.0)
    for law in (C, control.c2d(C, 1e-6, "tustin")):
        assert wb.LinearLaw(law, error=True).u0 == pytest.approx([15 / 28])
        assert wb.LinearLaw(law, error=True).v0 is None
    loop = wb.ClosedLoop(buck, controller=wb.LinearLaw(C, error=True), reference=wb.Constant("v", "V", [15.0]))
    # the lead has no integral: only about its point does it hold 15 V without an error
    assert wb.simulate(wb.rk4(loop.ode(), 1e-6), until=5e-3)["v"][0, -1, 0] == pytest.approx(15.0, rel=1e-9)


def test_observers_of_a_design_start_at_its_point_and_know_it():
    ode = wb.open_loop(CONVERTER)
    flow = wb.steady_kalman(ode, Qn, Rn[:1, :1], ("v",), x=BUCKBOOST.x0, u=BUCKBOOST.u0)
    step = wb.steady_kalman(ode, Qn, Rn[:1, :1], ("v",), period=1e-4, x=BUCKBOOST.x0, u=BUCKBOOST.u0)
    observer = wb.LinearObserver.of(CONVERTER, flow)
    assert observer.reads.names == ("v",)
    np.testing.assert_array_equal(observer.memory.default, BUCKBOOST.x0)
    np.testing.assert_array_equal(wb.SteadyKalmanFilter.of(CONVERTER, step, 1e-4).memory.default, BUCKBOOST.x0)
    law = wb.StateFeedback.of(CONVERTER, wb.lqr(BUCKBOOST, Q, R))
    run = wb.simulate(wb.rk4(wb.ClosedLoop(CONVERTER, observer, law).ode(), 1e-5), until=0.2)
    assert run["v"][0, -1, 0] == pytest.approx(24.0, rel=1e-6)


PI = wb.PID(Boost().outputs, Boost().inputs, Kp=0.0025, Ki=5.0)
BOOSTED = wb.ClosedLoop(Boost(), controller=PI, reference=wb.Constant("v", "V", [36.0]))


def test_a_loop_is_cut_at_what_its_law_commands_there():
    ode, cut = BOOSTED.ode(), BOOSTED.cut()
    x = operating_point(ode, {"plant.i": 10.8, "plant.v": 36.0}).x
    closed = np.linalg.eigvals(np.array(ode.A(0.0, x, ode.parameters.default)))
    assert closed.real.max() > 1.0  # unstable
    ours = [pole.value for pole in poles(sensitivity(broken_loop(cut, 0.0, x)))]
    np.testing.assert_allclose(np.sort_complex(ours), np.sort_complex(closed), rtol=1e-8)
    at_zero = wb.linearize(cut, 0.0, x)  # with the duty cycle 0 in the place of 2/3, as the commit before had it
    other = sensitivity(control.ss(at_zero.A, at_zero.B, -at_zero.C, -at_zero.D))
    assert np.linalg.eigvals(other.A).real.max() < 0


def test_a_loop_that_does_not_rest_is_refused_unless_it_is_asked_for_as_frozen():
    cut = BOOSTED.cut()
    x = cut.states.default  # the integral is zero, so that the law commands d = 0
    with pytest.raises(ValueError, match=r"rests under what arrives at its cut; at t = 0 and d = 0 .*frozen=True"):
        broken_loop(cut, 0.0, x)
    assert "frozen at t = 0 s" in broken_loop(cut, 0.0, x, is_frozen=True).name
    with pytest.raises(ValueError, match=r"must be what arrives at the cut, or the loop does not rest: 0.5 acts"):
        broken_loop(cut, 0.0, x, u=[0.5])


def test_a_loop_in_a_computer_is_cut_at_what_its_law_commands_there():
    loop = wb.ClosedLoop(CONVERTER, controller=wb.StateFeedback.of(CONVERTER, wb.lqr(BUCKBOOST, Q, R)))
    cut = loop.digital(1e-4, at="d")
    x = cut.states.default.copy()
    x[cut.states.slice("plant.i")], x[cut.states.slice("plant.v")] = BUCKBOOST.x0
    for name in cut.states.names:  # what the computer holds there
        if name.startswith("hold."):
            x[cut.states.slice(name)] = {"hold.d": 2 / 3}.get(name, 0.0)
    L = broken_loop(cut, 0.0, x)
    K, sampled = wb.lqr(BUCKBOOST, Q, R).K, control.c2d(BUCKBOOST, 1e-4)
    z = np.exp(1j * 500.0 * 1e-4)
    wanted = K @ np.linalg.solve(z * np.eye(2) - sampled.A, sampled.B)
    assert L(z) == pytest.approx(wanted[0, 0], rel=1e-8)  # of the exact flow


@pytest.mark.parametrize("which", ["buck-boost", "ball"])
def test_a_plant_goes_from_linear_design_to_exported_code_with_its_point_named_once(which, tmp_path):
    if which == "buck-boost":
        plant, linear, period, weights = CONVERTER, BUCKBOOST, 1e-4, (Q, R)
        law = wb.lqg(control.c2d(linear, period), *weights, Qn, Rn).controller
    else:
        plant, linear, period, weights = BALL, LEVITATED, 2e-3, (np.diag([1e6, 1e2]), [[1.0]])
        law = wb.StateFeedback.of(plant, wb.lqr(control.c2d(linear, period), *weights))
    computer = wb.ClosedLoop(plant, controller=law).digital(period)
    run = wb.simulate(computer.step(10), until=1.0 if which == "ball" else 0.2)
    for name, value in zip(linear.output_labels, linear.y0, strict=True):
        assert run[name][0, -1, 0] == pytest.approx(value, rel=1e-6, abs=1e-9)
    wb.export(computer, "c", tmp_path / "law", name="law")
    assert (tmp_path / "law" / "law.c").exists()


def test_a_lead_is_refused_whose_loop_crosses_again_with_less_margin():
    G = wb.linearize(wb.open_loop(wb.BuckConverter()), 0.0, [5.0, 15.0], u=[15 / 28])
    with pytest.raises(DesignError, match=r"crosses a gain of one at 8829 rad/s, .* is 8.82 degrees, not 50"):
        wb.lead_lag(G, crossover=1265.0, margin=50.0)


def test_a_slow_pole_is_placed_to_its_own_size_beside_a_fast_one():
    system = control.ss(np.diag([1.0, -1.0, 3e5]), np.ones((3, 1)), np.eye(3), 0)
    wanted = [-1e-4, -2e8, -3e8]
    # a pole of 1e-4 beside one of 3e8 is lost in rounding, and could as well be unstable
    with pytest.raises(DesignError, match=r"has the pole .* in the place of -0.0001"):
        wb.place(system, wanted)


def test_a_gain_alone_knows_the_point_of_its_design():
    design = wb.lqr(BUCKBOOST, Q, R)
    for gain in (design.K, 1.1 * design.K, wb.place(BUCKBOOST, design.poles).K):
        law = wb.StateFeedback.of(CONVERTER, gain)
        np.testing.assert_array_equal(law.x0, BUCKBOOST.x0)
        np.testing.assert_array_equal(law.u0, BUCKBOOST.u0)
    assert repr(design.K).startswith("array")


def test_what_is_computed_from_a_gain_in_another_shape_has_no_point():
    K = wb.lqr(BUCKBOOST, Q, R).K
    for part in (K[0], K.T, BUCKBOOST.B @ K, np.asarray(K)):
        assert getattr(part, "point", None) is None

"""Metrics of the signals of any plant, in their units."""

import casadi as ca
import numpy as np
import pytest

from tests.support.timed_signals import TIME, measured, of_time
from workbench.arms.laws import ArmPID
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import ArmFullState
from workbench.arms.torque_metrics import peak_torque
from workbench.blocks.loop import AbstractController, AbstractPlant, AbstractReference, ClosedLoop, open_loop
from workbench.blocks.signals import Constant
from workbench.core import block, initial, layout, parameter
from workbench.engine.distributions import Uniform
from workbench.engine.factors import Factor
from workbench.engine.metrics import (
    effort,
    energy,
    iae,
    ise,
    itae,
    late_error,
    observer_error,
    overshoot,
    peak,
    peak_error,
    rmse,
    settling_time,
    total_variation,
    violation,
)
from workbench.study.case_runs import run
from workbench.study.compiled_sweep import compile_sweep
from workbench.study.evidence.law_tables import side_by_side
from workbench.study.run_and_sweep import Run, Sweep
from workbench.study.run_tables import to_csv
from workbench.study.study import Case, Study
from workbench.study.uncertainty import MonteCarlo


@block
class Cart(AbstractPlant):
    """A cart on a spring of a hinge: two signals of two units, driven by voltages of the arm's names."""

    q: float = initial(1.0, unit="m")
    phi: float = initial(2.0, unit="rad")
    inputs = layout(tau="V", v="V")
    outputs = layout(q="m", phi="rad")

    def rate(self, t, x, u):
        return {"q": u.tau, "phi": u.v}


@block
class Gain(AbstractController):
    """Each signal is driven to its reference at its own rate."""

    k: float = parameter(3.0, unit="1/s")
    reads = follows = layout(q="m", phi="rad")
    drives = layout(tau="V", v="V")

    def command(self, t, z, est, ref):
        return {"tau": self.k * (ref.q - est.q), "v": 2 * self.k * (ref.phi - est.phi)}


@block
class Levels(AbstractReference):
    """Both are wanted at one number each."""

    q: float = parameter(0.0, unit="m")
    phi: float = parameter(0.0, unit="rad")
    gives = layout(q="m", phi="rad")

    def at(self, t):
        return {"q": self.q, "phi": self.phi}


def cart(**wanted):
    return ClosedLoop(Cart(), controller=Gain(), reference=Levels(**wanted))


def arm():
    law = ArmPID(Kp=[60.0, 60.0], Ki=[0.0, 0.0], Kd=[10.0, 10.0])
    return ClosedLoop(Manipulator(paper_arm(), q=[0.0, 0.0]), ArmFullState(2), law, Constant("q", "rad", [1.0, 0.5]))


def test_a_metric_without_a_signal_is_of_all_that_the_loop_follows_each_in_its_unit():
    score = measured(cart().ode(), ise(), iae())["ISE"]
    exact = [1 * (1 - np.exp(-12)) / 6, 4 * (1 - np.exp(-24)) / 12]
    np.testing.assert_allclose(score.value, [exact], rtol=2e-9)  # RK4 of 1 ms on modes of 3 and 6 1/s
    assert score.metric.units == ("m^2 s", "rad^2 s")
    assert score.metric.labels == ("q", "phi")
    assert score.metric.about == "integral of (e_q, e_phi)^2"


def test_a_voltage_by_the_name_of_a_torque_is_printed_in_volts():
    found = measured(cart().ode(), effort(), peak_torque(), peak(), effort("v"), total_variation(0.1))
    assert {name: score.metric.unit for name, score in found.items()} == {
        "effort": "V",
        "peak torque": "V",
        "peak": "V",
        "effort of v": "V",
        "TV": "V/s",
    }
    np.testing.assert_allclose(found["peak"].value, [[3.0, 12.0]], rtol=1e-12)  # at t = 0, without an integral
    assert found["peak"].metric.labels == ("tau", "v")


def test_the_position_of_a_cart_is_in_metres():
    found = measured(
        cart().ode(), rmse("q"), peak_error("q"), late_error(1.0, "q"), itae("q"), observer_error("q_error")
    )
    assert [score.metric.unit for score in found.values()] == ["m", "m", "m", "m s^2", "m"]
    np.testing.assert_allclose(found["late error of q"].value, [[np.exp(-3)]], rtol=1e-9)  # RK4 of 1 ms


def test_a_signal_that_follows_a_reference_is_measured_from_it_and_another_from_zero():
    ode = cart(q=3.0).ode()
    found = measured(ode, peak_error("q"), peak_error("v"), rmse("e_q"))
    assert found["peak error of q"].value == pytest.approx(2.0, rel=1e-12)  # at t = 0
    assert found["peak error of q"].metric.about == "largest |e_q|"
    assert found["peak error of v"].value == pytest.approx(12.0, rel=1e-12)
    assert found["peak error of v"].metric.about == "largest |v|, which is from 0, as v follows nothing"
    assert found["RMSE of e_q"].metric.about == "root mean square of e_q"


def test_an_error_that_no_output_shows_is_the_difference():
    ode = of_time(x=TIME, x_ref=2 * TIME, e=ca.cos(TIME))
    score = measured(ode, peak_error("x"))["peak error of x"]
    assert score.value == pytest.approx(2.0, rel=1e-12)
    assert score.metric.about == "largest |x - x_ref|"


def test_an_output_called_e_is_no_error_of_what_is_followed_unless_it_is_one():
    assert measured(of_time(x=TIME, x_ref=2 * TIME, e=9 + TIME), peak_error())["peak error"].value == pytest.approx(2)
    assert measured(of_time(x=TIME, x_ref=2 * TIME, e=-TIME), peak_error())["peak error"].metric.labels == ("x",)


def test_a_step_response_is_that_of_each_signal_with_its_reference():
    found = measured(cart(q=2.0).ode(), settling_time("q"), settling_time(band=0.05), overshoot("phi"))
    assert found["settling time of q"].value == pytest.approx(np.log(50) / 3, abs=1e-3)  # a step
    np.testing.assert_allclose(found["settling time"].value, [[np.log(20) / 3, np.log(20) / 6]], atol=1e-3)
    assert found["overshoot of phi"].value == 0


def test_the_metrics_of_an_arm_have_the_names_units_and_numbers_that_they_had():
    names = {"RMSE": "rad", "IAE": "rad s", "ISE": "rad^2 s", "ITAE": "rad s^2", "effort": "N m", "energy": "J"}
    names |= {"peak error": "rad", "peak torque": "N m", "TV": "N m/s"}
    metrics = (rmse(), iae(), ise(), itae(), effort(), energy(), peak_error(), peak_torque(), total_variation(0.01))
    found = measured(arm().ode(), *metrics, until=0.5, h=0.01)
    assert {name: score.metric.unit for name, score in found.items()} == names
    assert {score.metric.labels for score in found.values()} == {("joint 1", "joint 2")}
    assert found["RMSE"].metric.about == "root mean square of e"


def test_a_violation_is_how_far_and_how_long_a_signal_leaves_its_limits():
    wave = of_time(phi=ca.sin(TIME))
    found = measured(wave, *violation("phi", -0.5, 0.8), until=2 * np.pi, h=np.pi / 2000)
    assert found["violation of phi"].value == pytest.approx(0.5, abs=1e-6)  # a crest between two steps
    above, below = np.pi - 2 * np.arcsin(0.8), np.pi - 2 * np.arcsin(0.5)
    assert found["time of violation of phi"].value == pytest.approx(above + below, abs=4 * np.pi / 2000)  # 4 edges
    assert found["time of violation of phi"].metric.unit == "s"
    inside = measured(wave, *violation("phi", high=1.5), until=7.0, h=0.1)
    assert inside["violation of phi"].value == inside["time of violation of phi"].value == 0


def test_each_number_of_a_vector_has_a_limit_of_its_own():
    far, _ = violation("x", [-1.0, -np.inf], [1.0, 5.0])
    found = measured(of_time(x=ca.vertcat(TIME, TIME)), far, until=6.0, h=0.5)["violation of x"]
    np.testing.assert_array_equal(found.value, [[5.0, 1.0]])
    assert found.metric.labels == ("x[0]", "x[1]")
    with pytest.raises(ValueError, match=r"must have shape \(3,\), one number for each of the signal; got \(2,\)"):
        measured(of_time(x=ca.vertcat(TIME, TIME, TIME)), far)


@pytest.mark.parametrize("limits", [(None, None), (1.0, -1.0), (-np.inf, np.inf), (np.nan, 1.0), (1.0, 1.0)])
def test_limits_that_are_none_are_refused(limits):
    with pytest.raises(ValueError, match=r"`violation\(low=..., high=...\)` must be numbers with room between them"):
        violation("x", *limits)


def test_limits_of_other_shapes_than_a_signal_has_are_refused():
    with pytest.raises(ValueError, match="one for all or one for each number of the signal"):
        violation("x", [-1.0, -1.0], [1.0, 1.0, 1.0])


def test_what_is_no_number_for_a_while_is_no_number_in_the_end():
    broken = ca.if_else(TIME < 0.5, TIME, ca.if_else(TIME < 0.6, ca.sqrt(TIME - 2), TIME))
    x, metrics = of_time(x=broken, x_ref=ca.SX(5.0)), (peak_error("x"), overshoot("x"), *violation("x", high=0.1))
    for metric in (*metrics, iae("x"), total_variation(0.05, "x")):
        (score,) = measured(x, metric, until=1.0, h=0.05).values()
        assert np.isnan(score.value).all(), metric.name


def test_a_metric_of_what_a_loop_has_not_names_what_it_has():
    with pytest.raises(LookupError, match=r"'RMSE of phy' needs the output 'phy', which .* Did you mean 'phi'\?"):
        measured(cart().ode(), rmse("phy"))
    with pytest.raises(LookupError, match=r"'RMSE' without a signal is of what a loop follows, and 'plant' follows"):
        measured(open_loop(Cart()), rmse())
    with pytest.raises(LookupError, match=r"'overshoot of v' needs the output 'v_ref'"):
        measured(cart().ode(), overshoot("v"))


def test_a_sampled_loop_follows_and_drives_what_the_loop_does():
    found = measured(cart().digital(0.01), rmse(), effort(), h=0.01)
    assert [score.metric.labels for score in found.values()] == [("q", "phi"), ("tau", "v")]


def test_a_study_of_a_plant_names_its_signals_and_their_units():
    case = Case("S", "law", Run(cart(), (rmse(), rmse("q")), 1.0, 0.1, 0.005))
    sweep = Sweep(
        "s", Run(cart(), (iae(),), 1.0, h=0.01), (Factor("k", ("controller.k",), Uniform(1, 2)),), MonteCarlo(1, 16)
    )
    results = run(Study("s", "t", "q", "m", sections=lambda r: (), cases=(case,)))
    frame = results.to_frame()
    assert list(frame.signal) == ["q", "phi", "q"]
    assert list(frame.unit) == ["m", "rad", "m"]
    tables = [side_by_side("t", "c", results.outcomes, ["RMSE"], place) for place in (0, 1)]
    assert [table.columns[1].unit for table in tables] == ["m", "rad"]
    made = compile_sweep(sweep)
    sample = made.sample([made.chunk(0, 16)])
    assert "error of IAE of phi at most" in sample.note_of("IAE", 1)
    assert sample.note_of("IAE", 1).endswith("rad s")
    assert to_csv(sample).startswith(b"run,k,IAE[q] [m s],IAE[q] (error) [m s],IAE[phi] [rad s],")


UNITS = [("rad", "rad s", "rad^2 s"), ("m/s", "m", "m^2/s"), ("", "s", "s"), ("1", "s", "s"), ("1/s", "", "1/s")]
UNITS += [("W/(m^2 K)", "W s/(m^2 K)", "W^2 s/(m^4 K^2)"), ("V/sqrt(Hz)", "V s/Hz^(1/2)", "V^2 s/Hz")]
UNITS += [("°C", "°C s", "°C^2 s"), ("?", "?", "?")]


@pytest.mark.parametrize(("unit", "of_size", "of_square"), UNITS)
def test_an_integral_over_time_is_in_the_unit_of_its_integrand_times_seconds(unit, of_size, of_square):
    assert (iae().measure(unit), ise().measure(unit)) == (of_size, of_square)

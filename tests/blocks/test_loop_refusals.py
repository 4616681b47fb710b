"""What a loop is refused for, and the remedies: each sentence names the blocks, and what to do that does help."""

import math
from pathlib import Path

import control
import numpy as np
import pytest

import workbench as wb
from tests.support.loop_refusals import refused
from workbench.blocks.loop import LinearLaw
from workbench.core import LinearSystem

MOTOR, CART, TANKS = wb.DCMotor(), wb.CartPole(phi=0.1), wb.QuadrupleTank()
SPEED = wb.Step("omega", "rad/s", 1.0)
LEAD = control.tf([50, 600, 1000], [1, 20, 0], inputs="omega", outputs="v", name="lead")
PERIOD = 0.01
README = (Path(__file__).parents[2] / "README.md").read_text("utf-8")


def observed(law, reference):
    """A cart whose states a filter estimates, under a law."""
    return wb.ClosedLoop(CART, wb.LinearObserver(CART, np.ones((4, 2))), law, reference)


# A reference that nobody follows


def test_a_compensator_of_python_control_is_not_given_y_where_the_error_is_meant():
    says = "`Step` gives 'omega', which `LinearLaw` does not follow", "LinearLaw(C, error=True)", "'omega_ref'"
    for law in (LEAD, LinearLaw(LEAD), control.ss(LEAD)):
        if not isinstance(law, LinearLaw):
            law.update_names(inputs="omega", outputs="v")
        refused(lambda law=law: wb.ClosedLoop(MOTOR, controller=law, reference=SPEED), *says, "without a reference")


def test_both_remedies_of_a_compensator_follow():
    says_y_and_wanted = control.ss([], [], [], [[50.0, -50.0]], inputs=["omega_ref", "omega"], outputs="v")
    for law in (LinearLaw(LEAD, error=True), says_y_and_wanted):
        assert wb.ClosedLoop(MOTOR, controller=law, reference=SPEED).follows == ("omega",)


def test_a_regulator_without_a_state_to_follow_takes_no_reference():
    law, wanted = wb.StateFeedback.of(CART, np.ones((1, 4))), wb.Step("x", "m", 0.2)
    refused(
        lambda: observed(law, wanted), "`Step` gives 'x'", "StateFeedback.of(..., follow=('x',))", "without a reference"
    )
    assert observed(wb.StateFeedback.of(CART, np.ones((1, 4)), follow=("x",)), wanted).follows == ("x",)
    assert observed(law, None).follows == ()


def test_what_is_wanted_of_an_output_is_followed_in_part_by_nobody():
    law = wb.Cascade(
        wb.PID(wb.layout(x="m"), wb.layout(phi="rad"), Kp=0.1),
        wb.PID(wb.layout(phi="rad"), wb.layout(F="N"), Kp=50.0),
    )
    both = wb.CombinedReference((wb.Step("x", "m", 0.2), wb.Constant("phi", "rad", [0.0])))
    refused(lambda: wb.ClosedLoop(CART, controller=law, reference=both), "gives 'phi'", "follows 'x'", "without 'phi'")
    assert wb.ClosedLoop(CART, controller=law, reference=wb.Step("x", "m", 0.2)).follows == ("x",)


def test_derivatives_that_a_reference_says_anyway_need_no_follower():
    assert "omegad" in SPEED.gives.names
    law = wb.PID(MOTOR.outputs, MOTOR.inputs, Kp=1.0)
    assert wb.ClosedLoop(MOTOR, controller=law, reference=SPEED).follows == ("omega",)


def test_a_law_may_follow_the_rate_of_what_is_wanted_alone():
    @wb.block
    class Feedforward(wb.Controller):
        k: float = wb.parameter(default=1.0, unit="V s^2/rad")
        reads, follows, drives = wb.layout(), wb.layout(omegad="rad/s^2"), wb.layout(v="V")

        def command(self, t, z, est, ref):
            return {"v": self.k * ref.omegad}

    wb.ClosedLoop(MOTOR, controller=Feedforward(), reference=SPEED).ode()


def test_a_reference_of_ones_own_that_says_derivatives_too_is_followed_by_a_law_of_its_value():
    @wb.block
    class Parabola(wb.Reference):
        a: float = wb.parameter(default=0.5, unit="rad/s^2")
        gives = wb.layout(omega="rad/s", omegad="rad/s^2")

        def at(self, t):
            return {"omega": self.a * t, "omegad": self.a}

    law = wb.PID(MOTOR.outputs, MOTOR.inputs, Kp=1.0)
    assert wb.ClosedLoop(MOTOR, controller=law, reference=Parabola()).follows == ("omega",)


def test_an_input_that_nothing_drives_is_refused():
    law = wb.PID(wb.layout(h_1="cm"), wb.layout(v_1="V"), Kp=1.0)
    make = lambda: wb.ClosedLoop(TANKS, controller=law, reference=wb.Step("h_1", "cm", 12.4))  # noqa: E731
    text = refused(
        make, "nothing drives 'v_2', as `PID` drives 'v_1'.", "a law that drives it", "a parameter of the plant"
    )
    assert "Did you mean" not in text


# The sign of a law as it stands


def compensators():
    plain = control.tf([2.0, 3.0], [1.0, 0.0], inputs="omega", outputs="v", name="pi")
    return plain, control.c2d(plain, PERIOD, "tustin")


def test_a_compensator_whose_sign_is_that_of_the_error_is_refused_without_a_reference_too():
    plain, sampled = compensators()
    says = "is unstable, and with the opposite sign it is stable", "LinearLaw(C, error=True)", "`LinearLaw(C)`"
    refused(lambda: wb.ClosedLoop(MOTOR, controller=plain), *says)
    refused(lambda: wb.ClosedLoop(MOTOR, controller=sampled).digital(PERIOD), *says)


def test_who_says_that_y_is_meant_is_believed():
    plain, sampled = compensators()
    assert wb.ClosedLoop(MOTOR, controller=LinearLaw(plain)).ode().drives == ("v",)
    assert wb.ClosedLoop(MOTOR, controller=LinearLaw(sampled)).digital(PERIOD).period == PERIOD


@pytest.mark.parametrize("plant", [MOTOR, wb.CartPole(), wb.TwoMasses()])
@pytest.mark.parametrize("period", [None, PERIOD])
def test_the_law_of_lqg_closes_a_loop_as_it_stands(plant, period):
    opened = wb.open_loop(plant)
    model = wb.linearize(opened, 0.0, np.zeros(opened.states.size))
    model = model if period is None else model.sample(period)
    n, ny = len(model.A), len(model.C)
    law = wb.lqg(model, np.eye(n), np.eye(model.ninputs), np.eye(n), 1e-3 * np.eye(ny)).controller
    loop = wb.ClosedLoop(plant, controller=law)
    assert (loop.ode() if period is None else loop.digital(period)).states.size >= 2 * n


def test_a_law_of_lqg_is_told_that_the_error_is_not_what_it_is_given():
    model = wb.linearize(wb.open_loop(MOTOR), 0.0, np.zeros(2))
    law = wb.lqg(model, np.eye(2), [[1.0]], np.eye(2), [[1e-3]]).controller
    refused(lambda: wb.ClosedLoop(MOTOR, controller=law, reference=SPEED), "as that of `lqg` is not")


# Remedies


def test_a_discrete_law_that_is_cut_open_is_sent_to_a_computer_that_is_cut_too():
    _, sampled = compensators()
    loop = wb.ClosedLoop(MOTOR, controller=LinearLaw(sampled))
    refused(loop.ode, "`ClosedLoop.digital(period)` in place of `ode()`")
    refused(loop.cut, "`ClosedLoop.digital(period, at=...)` in place of `cut()`")


def test_a_law_that_reads_a_state_is_sent_to_an_observer_and_not_to_another_name():
    law = wb.StateFeedback.of(CART, np.ones((1, 4)))
    text = refused(
        lambda: wb.ClosedLoop(CART, controller=law), "`StateFeedback` reads 'xd', where `CartPole` gives 'x', 'phi'."
    )
    assert "`ClosedLoop(observer=...)`" in text
    assert "`ExtendedKalmanFilter`, `SteadyKalmanFilter` or `LinearObserver`" in text
    assert "did you mean" not in text


def test_an_observer_of_manipulators_is_left_out_of_a_loop_of_a_motor():
    law = wb.PID(MOTOR.outputs, MOTOR.inputs, Kp=1.0)
    text = refused(
        lambda: wb.ClosedLoop(MOTOR, wb.ArmFullState(1), law, SPEED), "`ArmFullState` reads 'q'", "manipulators"
    )
    assert "Leave `observer` out where the law shall read 'omega'" in text


def test_a_law_of_manipulators_is_sent_to_those_of_any_plant():
    arm = wb.paper_arm()
    law = wb.SlidingMode(model=arm, Lambda=[6.0, 6.0], K=[40.0, 20.0], phi=0.1)
    refused(
        lambda: wb.ClosedLoop(MOTOR, controller=law, reference=SPEED),
        "`SlidingMode` reads 'q'",
        "manipulators",
        "`PID`",
    )


def test_a_system_whose_input_is_called_e_is_told_how_inputs_are_named():
    law = LinearSystem.of(LEAD, inputs="e")
    for each in (LinearLaw(law), LinearLaw(law, error=True)):
        refused(
            lambda each=each: wb.ClosedLoop(MOTOR, controller=each, reference=SPEED),
            "`LinearLaw` reads 'e', where `DCMotor` gives 'omega'.",
            "LinearLaw(C, error=True)",
            "'y_ref'",
        )


def test_a_loop_in_a_computer_without_inputs_is_not_sent_to_a_method_that_it_lacks():
    law = wb.PID(MOTOR.outputs, MOTOR.inputs, Kp=1.0)
    loop = wb.ClosedLoop(MOTOR, controller=law, reference=SPEED)
    sampled = loop.digital(PERIOD)
    assert not hasattr(sampled, "A")
    text = refused(lambda: wb.linearize(sampled, 0.0, sampled.states.default), "digital(period, inputs=True)")
    assert "ode.A" not in text
    opened = loop.digital(PERIOD, inputs=True)
    model = wb.linearize(opened, PERIOD, opened.states.default)  # the remedy helps
    assert model.input_labels == ["omega_ref", "v_load", "omega_noise"]
    refused(lambda: wb.linearize(loop.ode(), 0.0, loop.ode().states.default), "`ode.A(t, x, p)`", "ode(inputs=True)")


PORTS = {"states": ("x",), "inputs": ("u",)}
NOT_SYMBOLS = {
    "no parameters": (lambda t, x, u, p: [u[0] - p.R * x[0]], "p=layout(R=('ohm', 1.0))"),
    "no parameters, by place": (lambda t, x, u, par: [u[0] - par[0] * x[0]], "p=layout(R=('ohm', 1.0))"),
    "no parameters, as a number": (lambda t, x, u, p: [u[0] - p * x[0]], "p=layout(R=('ohm', 1.0))"),
    "no parameters, and m": (lambda t, x, u, p, m: [u[0] - p.R], "p=layout(R=('ohm', 1.0))"),
    "an index out of range": (lambda t, x, u: [u[0] - x[1]], "1 in x and 1 in u"),
    "a name that is not defined": (lambda t, x, u: [u[0] - missing], "name 'missing' is not defined"),  # noqa: F821
    "a division by zero": (lambda t, x, u: [u[0] * (1 / 0)], "division by zero"),
    "a function that m lacks": (lambda t, x, u, m: [u[0] - m.sinn(x[0])], "no attribute 'sinn'; did you mean 'sin'"),
    "a parameter that p lacks": (lambda t, x, u, p: [u[0] - p.r], "There is no 'r' among the 1 signals"),
}


@pytest.mark.parametrize(("function", "says"), NOT_SYMBOLS.values(), ids=NOT_SYMBOLS)
def test_a_function_that_fails_of_another_cause_is_not_sent_to_the_functions_of_m(function, says):
    p = wb.layout(R=("ohm", 1.0)) if "p lacks" in says or "'r'" in says else None
    text = refused(lambda: wb.OdePlant.of(function, **PORTS, p=p), says)
    assert "take `m.sin`" not in text


@pytest.mark.parametrize(
    "function",
    [
        lambda t, x, u: [u[0] - math.sin(x[0])],
        lambda t, x, u: [u[0] if x[0] > 0 else 0.0],
        lambda t, x, u: [u[0] - int(x[0])],
        lambda t, x, u: [u[0] - np.frexp(x[0])[0]],
    ],
)
def test_a_function_that_takes_a_symbol_for_a_number_is_sent_to_those_of_m(function):
    refused(lambda: wb.OdePlant.of(function, **PORTS), "take `m.sin`", "`m.where(c, a, b)`")


# What the error of an estimate is


def test_e_hat_is_estimate_minus_reference_and_the_error_of_an_observer_is_true_minus_estimated():
    law = wb.StateFeedback.of(CART, np.ones((1, 4)), follow=("x",))
    ode = observed(law, wb.Step("x", "m", 0.2)).ode()
    x = ode.states.default + np.linspace(0.1, 0.8, ode.states.size)
    out = ode.outputs_at(0.5, x)
    estimate = x[ode.states.slice("observer.x_hat")][0]
    assert out["e_x"] == out["x"] - out["x_ref"]
    assert out["e_hat_x"] == estimate - out["x_ref"]
    assert out["x_error"] == out["x"] - estimate
    for text in (wb.ClosedLoop.ode.__doc__, README):
        plain = " ".join(text.replace("`", "").split())
        assert "e_hat_x = x_hat - x_ref" in plain
        assert "x_error = x - x_hat, true minus estimated" in plain

"""What a loop is refused for, and the remedies: each sentence names the blocks, and what to do that does help."""

import math
from pathlib import Path

import control
import numpy as np
import pytest

import workbench as wb
from workbench.blocks.loop import LinearLaw
from workbench.core import Entry, Layout, LinearSystem, Ode

MOTOR, CART, TANKS = wb.DCMotor(), wb.CartPole(phi=0.1), wb.QuadrupleTank()
SPEED = wb.Step("omega", "rad/s", 1.0)
LEAD = control.tf([50, 600, 1000], [1, 20, 0], inputs="omega", outputs="v", name="lead")
PERIOD = 0.01
README = (Path(__file__).parents[2] / "README.md").read_text("utf-8")


def refused(make, *says, error=ValueError):
    """The one sentence or two of a refusal, with all that they must say."""
    with pytest.raises(error) as refusal:
        make()
    text = str(refusal.value)
    assert all(each in text for each in says), text
    assert "\n" not in text
    return text


def observed(law, reference):
    """A cart whose states a filter estimates, under a law."""
    return wb.ClosedLoop(CART, wb.LinearObserver(CART, np.ones((4, 2))), law, reference)


# A reference that nobody follows


def test_a_compensator_of_python_control_is_not_given_y_where_the_error_is_meant():
    says = "`Step` says 'omega', which `LinearLaw` does not follow", "LinearLaw(C, error=True)", "'omega_ref'"
    for law in (LEAD, LinearLaw(LEAD), control.ss(LEAD)):
        if not isinstance(law, LinearLaw):
            law.update_names(inputs="omega", outputs="v")
        refused(lambda law=law: wb.ClosedLoop(MOTOR, controller=law, reference=SPEED), *says, "without a reference")


def test_both_remedies_of_a_compensator_follow():
    says_y_and_wanted = control.ss([], [], [], [[50.0, -50.0]], inputs=["omega_ref", "omega"], outputs="v")
    for law in (LinearLaw(LEAD, error=True), says_y_and_wanted):
        assert wb.ClosedLoop(MOTOR, controller=law, reference=SPEED).follows == ("omega",)


def test_a_regulator_without_a_state_to_follow_takes_no_reference():
    law, wanted = wb.Regulator.of(CART, np.ones((1, 4))), wb.Step("x", "m", 0.2)
    refused(lambda: observed(law, wanted), "`Step` says 'x'", "Regulator.of(..., follow=('x',))", "without a reference")
    assert observed(wb.Regulator.of(CART, np.ones((1, 4)), follow=("x",)), wanted).follows == ("x",)
    assert observed(law, None).follows == ()


def test_what_is_wanted_of_an_output_is_followed_in_part_by_nobody():
    law = wb.Cascade(
        wb.PID2(wb.layout(x="m"), wb.layout(phi="rad"), Kp=0.1),
        wb.PID2(wb.layout(phi="rad"), wb.layout(F="N"), Kp=50.0),
    )
    both = wb.Together((wb.Step("x", "m", 0.2), wb.Hold([0.0], "phi", "rad")))
    refused(lambda: wb.ClosedLoop(CART, controller=law, reference=both), "says 'phi'", "follows 'x'", "without 'phi'")
    assert wb.ClosedLoop(CART, controller=law, reference=wb.Step("x", "m", 0.2)).follows == ("x",)


def test_derivatives_that_a_reference_says_anyway_need_no_follower():
    assert "omegad" in SPEED.says.names
    law = wb.PID2(MOTOR.outputs, MOTOR.inputs, Kp=1.0)
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
        says = wb.layout(omega="rad/s", omegad="rad/s^2")

        def at(self, t):
            return {"omega": self.a * t, "omegad": self.a}

    law = wb.PID2(MOTOR.outputs, MOTOR.inputs, Kp=1.0)
    assert wb.ClosedLoop(MOTOR, controller=law, reference=Parabola()).follows == ("omega",)


def test_an_input_that_nothing_drives_is_refused():
    law = wb.PID2(wb.layout(h_1="cm"), wb.layout(v_1="V"), Kp=1.0)
    make = lambda: wb.ClosedLoop(TANKS, controller=law, reference=wb.Step("h_1", "cm", 12.4))  # noqa: E731
    text = refused(
        make, "nothing drives 'v_2', as `PID2` drives 'v_1'.", "a law that drives it", "a parameter of the plant"
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


# One name for two things


def plant(inputs, outputs, start="m", **own):
    """A plant with the state x, and the parameter k."""
    fields = {
        "__annotations__": {"x": float, "k": float},
        "x": wb.initial(default=1.0, unit=start),
        "k": wb.parameter(default=1.0, unit="1/s"),
        "inputs": inputs,
        "outputs": outputs,
        "rate": lambda self, t, x, u: {"x": u[inputs.names[0]] - self.k * x.x},
    }
    return wb.block(type("Own", (wb.Plant,), {**fields, **own}))()


SHARED = {
    "a state and an input": (lambda: plant(wb.layout(x="m/s"), wb.layout(x="m")), "a state and an input 'x'"),
    "a state and an input of another output": (
        lambda: plant(wb.layout(x="m/s"), wb.layout(y="m"), measure=lambda self, t, x: {"y": x.x}),
        "a state and an input 'x'",
    ),
    "an input and a parameter": (lambda: plant(wb.layout(k="m/s"), wb.layout(x="m")), "an input and a parameter 'k'"),
    "a state and an output of another unit": (
        lambda: plant(wb.layout(v="m/s"), wb.layout(x="mm")),
        "gives 'x' in [mm], where `Own` has as a state it in [m]",
    ),
    "a state and a parameter": (
        lambda: plant(wb.layout(v="m/s"), wb.layout(x="m"), states=wb.layout(k="m", x="m")),
        "a state and a parameter 'k'",
    ),
}


@pytest.mark.parametrize(("make", "says"), SHARED.values(), ids=SHARED)
def test_a_name_that_means_two_things_in_a_plant_is_refused_at_every_door(make, says):
    own = make()
    law = wb.PID2(own.outputs, own.inputs, Kp=1.0)
    reference = wb.Step(own.outputs.names[0], own.outputs.entries[0].unit, 1.0)
    refused(lambda: wb.open_loop(own), says, "rename one of them")
    message = refused(lambda: wb.ClosedLoop(own, controller=law, reference=reference), "rename")
    assert says in message or "would stand for two of them" in message


def test_an_input_and_an_output_of_one_name_are_refused_at_every_door():
    own = plant(wb.layout(y="m/s"), wb.layout(y="m"), measure=lambda self, t, x: {"y": x.x})
    refused(lambda: wb.open_loop(own), "an input and an output 'y'")
    law = wb.PID2(own.outputs, own.inputs, Kp=1.0)
    refused(lambda: wb.ClosedLoop(own, controller=law, reference=wb.Step("y", "m", 1.0)), "'y' would stand for two")


def test_functions_whose_state_and_input_have_one_name_are_refused():
    refused(
        lambda: wb.OdePlant.of(lambda t, x, u: [u[0] - x[0]], states=("x",), inputs=("x",)),
        "'x' of 'plant' is a state and an input: rename one of them",
    )
    refused(
        lambda: wb.OdePlant.of(lambda t, x, u, p: [u[0] - x[0]], ("x",), ("v",), p=wb.layout(x="1")),
        "'x' of 'plant' is a state and a parameter",
    )


def test_an_equation_with_one_name_for_a_state_and_a_parameter_is_refused():
    import casadi as ca

    t, x, p = ca.SX.sym("t"), ca.SX.sym("x"), ca.SX.sym("x")
    port = Layout((Entry("x", np.array(0.0)),))
    refused(lambda: Ode("own", port, port, port, t, x, p, p - x, x), "'x' of 'own' is a state and a parameter")


def test_a_linear_plant_whose_state_and_input_have_one_name_is_refused():
    system = control.ss(-1.0, 1.0, 1.0, 0.0, states=["v"], inputs=["v"], outputs=["y"])
    refused(lambda: wb.open_loop(wb.LinearPlant(system)), "`LinearPlant` calls a state and an input 'v'")
    gain = control.ss([], [], [], [[-1.0]], inputs="y", outputs="v")
    refused(lambda: wb.ClosedLoop(system, controller=gain), "`LinearPlant` calls a state and an input 'v'")


def test_a_law_whose_state_has_the_name_of_its_parameter_is_refused():
    system = control.ss(-1.0, 1.0, -1.0, 0.0, states=["u0"], inputs="omega", outputs="v")
    law = LinearLaw(system, u0=[1.0])
    refused(lambda: wb.ClosedLoop(MOTOR, controller=law), "`LinearLaw` calls a state and a parameter 'u0'")
    wb.ClosedLoop(MOTOR, controller=LinearLaw(system)).ode()  # without the parameter there is one thing of that name


def test_an_estimate_in_another_unit_than_the_output_of_its_name_is_refused():
    @wb.block
    class Watcher(wb.Observer):
        reads, gives = wb.layout(omega="rad/s"), wb.layout(omega="deg/s")

        def estimate(self, t, z, y):
            return {"omega": y.omega * (180 / math.pi)}

    law = wb.PID2(wb.layout(omega="deg/s"), MOTOR.inputs, Kp=1.0)
    refused(
        lambda: wb.ClosedLoop(MOTOR, Watcher(), law, wb.Step("omega", "deg/s", 1.0)),
        "`Watcher` gives 'omega' in [deg/s], where `DCMotor` gives it in [rad/s].",
    )


def test_a_temperature_called_t_is_not_the_time():
    tank = wb.OdePlant.of(lambda t, x, u, m: [u[0] - m.where(x[0] > 5.0 + t, 2.0, 1.0) * x[0]], ("t:K",), ("q:K/s",))
    assert wb.linearize(wb.open_loop(tank), 0.0, [1.0]).A.item() == -1.0
    assert wb.linearize(wb.open_loop(tank), 0.0, [7.0]).A.item() == -2.0


# Remedies


def test_a_discrete_law_that_is_cut_open_is_sent_to_a_computer_that_is_cut_too():
    _, sampled = compensators()
    loop = wb.ClosedLoop(MOTOR, controller=LinearLaw(sampled))
    refused(loop.ode, "`ClosedLoop.digital(period)` in place of `ode()`")
    refused(loop.broken, "`ClosedLoop.digital(period, at=...)` in place of `broken()`")


def test_a_law_that_reads_a_state_is_sent_to_an_observer_and_not_to_another_name():
    law = wb.Regulator.of(CART, np.ones((1, 4)))
    text = refused(
        lambda: wb.ClosedLoop(CART, controller=law), "`Regulator` reads 'xd', where `CartPole` gives 'x', 'phi'."
    )
    assert "`ClosedLoop(observer=...)`" in text
    assert "`ExtendedKalmanFilter`, `SteadyKalmanFilter` or `LinearObserver`" in text
    assert "did you mean" not in text


def test_a_true_slip_of_the_pen_is_still_named():
    law = wb.PID2(wb.layout(omgea="rad/s"), MOTOR.inputs, Kp=1.0)
    refused(
        lambda: wb.ClosedLoop(MOTOR, controller=law, reference=wb.Step("omgea", "rad/s", 1.0)),
        "did you mean 'omega'?",
    )


@pytest.mark.parametrize("name", ["omegad", "omega_ref", "e_omega", "omega2"])
def test_a_signal_that_is_made_of_another_one_is_no_slip_of_the_pen(name):
    law = wb.PID2(wb.layout(**{name: "rad/s"}), MOTOR.inputs, Kp=1.0)
    text = refused(
        lambda: wb.ClosedLoop(MOTOR, controller=law, reference=wb.Step(name, "rad/s", 1.0)), f"reads '{name}'"
    )
    assert "did you mean" not in text


def test_an_observer_of_manipulators_is_left_out_of_a_loop_of_a_motor():
    law = wb.PID2(MOTOR.outputs, MOTOR.inputs, Kp=1.0)
    text = refused(lambda: wb.ClosedLoop(MOTOR, wb.FullState(1), law, SPEED), "`FullState` reads 'q'", "manipulators")
    assert "Leave `observer` out where the law shall read 'omega'" in text


def test_a_law_of_manipulators_is_sent_to_those_of_any_plant():
    arm = wb.paper_arm()
    law = wb.SlidingMode(model=arm, Lambda=[6.0, 6.0], K=[40.0, 20.0], phi=0.1)
    refused(
        lambda: wb.ClosedLoop(MOTOR, controller=law, reference=SPEED),
        "`SlidingMode` reads 'q'",
        "manipulators",
        "`PID2`",
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
    law = wb.PID2(MOTOR.outputs, MOTOR.inputs, Kp=1.0)
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
    law = wb.Regulator.of(CART, np.ones((1, 4)), follow=("x",))
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

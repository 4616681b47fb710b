"""A name means one thing in a loop: what has two meanings is refused, and a slip of the pen gets the nearest name."""

import math

import control
import numpy as np
import pytest

import workbench as wb
from tests.support.loop_refusals import plant, refused
from workbench.blocks.loop import LinearLaw
from workbench.core import Entry, Layout, Ode

MOTOR, CART, TANKS = wb.DCMotor(), wb.CartPole(phi=0.1), wb.QuadrupleTank()


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
    law = wb.PID(own.outputs, own.inputs, Kp=1.0)
    reference = wb.Step(own.outputs.names[0], own.outputs.entries[0].unit, 1.0)
    refused(lambda: wb.open_loop(own), says, "rename one of them")
    message = refused(lambda: wb.ClosedLoop(own, controller=law, reference=reference), "rename")
    assert says in message or "would stand for two of them" in message


def test_an_input_and_an_output_of_one_name_are_refused_at_every_door():
    own = plant(wb.layout(y="m/s"), wb.layout(y="m"), measure=lambda self, t, x: {"y": x.x})
    refused(lambda: wb.open_loop(own), "an input and an output 'y'")
    law = wb.PID(own.outputs, own.inputs, Kp=1.0)
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

    law = wb.PID(wb.layout(omega="deg/s"), MOTOR.inputs, Kp=1.0)
    refused(
        lambda: wb.ClosedLoop(MOTOR, Watcher(), law, wb.Step("omega", "deg/s", 1.0)),
        "`Watcher` gives 'omega' in [deg/s], where `DCMotor` gives it in [rad/s].",
    )


def test_a_temperature_called_t_is_not_the_time():
    tank = wb.OdePlant.of(lambda t, x, u, m: [u[0] - m.where(x[0] > 5.0 + t, 2.0, 1.0) * x[0]], ("t:K",), ("q:K/s",))
    assert wb.linearize(wb.open_loop(tank), 0.0, [1.0]).A.item() == -1.0
    assert wb.linearize(wb.open_loop(tank), 0.0, [7.0]).A.item() == -2.0


def test_a_true_slip_of_the_pen_is_still_named():
    law = wb.PID(wb.layout(omgea="rad/s"), MOTOR.inputs, Kp=1.0)
    refused(
        lambda: wb.ClosedLoop(MOTOR, controller=law, reference=wb.Step("omgea", "rad/s", 1.0)),
        "did you mean 'omega'?",
    )


@pytest.mark.parametrize("name", ["omegad", "omega_ref", "e_omega", "omega2"])
def test_a_signal_that_is_made_of_another_one_is_no_slip_of_the_pen(name):
    law = wb.PID(wb.layout(**{name: "rad/s"}), MOTOR.inputs, Kp=1.0)
    text = refused(
        lambda: wb.ClosedLoop(MOTOR, controller=law, reference=wb.Step(name, "rad/s", 1.0)), f"reads '{name}'"
    )
    assert "did you mean" not in text

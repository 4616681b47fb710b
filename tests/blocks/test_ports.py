"""Ports: what a block may ask of another, and what it must return; a loop of any plant."""

import copy
import math
import pickle
from concurrent.futures import ThreadPoolExecutor

import casadi as ca
import numpy as np
import pytest

from tests.support.motor_blocks import Motor, law, motor, plant
from workbench.arms.arm_contracts import AbstractArmController
from workbench.arms.laws import ArmPID
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.blocks.loop import (
    AbstractController,
    AbstractPlant,
    ClosedLoop,
    Instruments,
    open_loop,
)
from workbench.blocks.signals import Sines
from workbench.core import Entry, Layout, Signals, block, initial, layout, rk4
from workbench.engine import simulate

WANTED = Sines("q", "rad", [1.0, 1.0], [1.0, 1.0])


def test_a_motor_and_a_law_of_ones_own_make_a_loop():
    loop = motor()
    ode = loop.ode()
    assert ode.states.names == ("plant.i", "plant.omega", "controller.z")
    assert ode.outputs.names == ("omega", "omega_ref", "e_omega", "e_hat_omega", "v", "v_applied", "omega_error")
    assert [ode.outputs[name].unit for name in ("omega", "e_omega", "v")] == ["rad/s", "rad/s", "V"]
    assert (ode.follows, ode.drives) == (("omega",), ("v",))
    assert simulate(rk4(ode, 1e-3), until=4.0)["omega"][0, -1] == pytest.approx(1.0, abs=1e-6)  # integral action


def test_a_loop_in_a_computer_of_any_plant_has_noise_limits_and_a_delay():
    instruments = Instruments.of(Motor(), noise={"omega": 0.01}, limit={"v": (-40.0, 40.0)})
    digital = motor().digital(0.01, instruments, delay=True)
    assert digital.states.names[3:] == ("hold.next", "hold.v", "hold.omega_hat")
    assert digital.parameters["instruments.sensors[0].noise"].unit == "rad/s"
    assert digital.flow.states["hold.next"].unit == "V"
    run = simulate(digital.step(2), until=3.0, seed=1)
    assert np.abs(run["v"]).max() == 40.0
    assert run["v"][0, 0] == 0  # the first command waits
    assert run["omega"][0, -50:].mean() == pytest.approx(1.0, abs=0.1)


def test_a_loop_without_an_observer_reads_and_without_a_reference_follows_nothing():
    loop = ClosedLoop(Motor(omega=1.0), controller=law())
    assert loop.ode().outputs.names == ("omega", "v", "v_applied", "omega_error")
    assert loop.follows == ()
    assert not loop.observer.uses_truth


def test_the_open_plant_has_its_inputs_as_parameters():
    ode = open_loop(Motor())
    assert (ode.inputs, ode.outputs.names, ode.states.names) == (("v",), ("omega",), ("i", "omega"))
    np.testing.assert_allclose(ode.B(0.0, [0.0, 0.0], ode.parameters.default), [[2.0], [0.0]])


@block
class OneTorque(AbstractArmController):
    """One number for two motors."""

    joints: int = 2

    @property
    def dof(self):
        return self.joints

    def torque(self, t, z, est, ref):
        return ca.SX(1.0)


def test_a_law_that_returns_one_torque_for_two_joints_is_refused():
    """It was spread over both, and the RMSE of another law was reported without a word."""
    loop = ClosedLoop(
        Manipulator(paper_arm(), q=[0.1, 0.2]),
        controller=OneTorque(),
        reference=Sines("q", "rad", [1.0] * 2, [1.0] * 2),
    )
    with pytest.raises(
        ValueError, match=r"`OneTorque.command\(...\)` must return 'tau' in shape \(2, 1\); it returned"
    ):
        loop.ode()


def test_an_arm_needs_no_observer_either():
    arm = paper_arm()
    pid = ArmPID([9.0, 9.0], [1.0, 1.0], [3.0, 3.0], arm)
    loop = ClosedLoop(Manipulator(arm, q=[0.1, 0.2]), controller=pid, reference=WANTED)
    assert loop.ode().follows == ("q",)


def test_a_port_that_nobody_asks_for_costs_nothing():
    """Its output is watched by nobody, and no operation of the step is for it."""
    plain = rk4(open_loop(Motor()), 1e-3)

    @block
    class Told(AbstractPlant):
        motor: Motor = Motor()
        inputs = layout(v="V")
        outputs = layout(omega="rad/s", power="W", heat="W")

        @property
        def states(self):
            return self.motor.states

        def measure(self, t, x):
            return {"omega": x.omega, "power": ca.sin(x.omega * x.i), "heat": ca.exp(x.i**2)}

        def rate(self, t, x, u):
            return self.motor.rate(t, x, u)

    assert rk4(open_loop(Told()), 1e-3).operations == plain.operations


@block
class Counter(AbstractController):
    """v+ = v + 1: a recursion, which has no rate."""

    count: float = initial(0.0, unit="V")
    reads = layout()
    drives = layout(v="V")

    def command(self, t, z, est, ref):
        return {"v": z.count}

    def update(self, t, z, est, ref):
        return {"count": z.count + 1}


def test_a_recursion_moves_once_a_period_and_not_by_euler():
    loop = ClosedLoop(Motor(), controller=Counter())
    run = simulate(loop.digital(0.25).step(1), until=1.0)
    np.testing.assert_array_equal(run["v"][0, :, 0], [0, 1, 2, 3, 4])
    assert loop.digital(0.25).methods == ("memory of the controller: its own recursion in discrete time",)
    with pytest.raises(ValueError, match="`Counter` is a recursion in discrete time, which only a computer runs"):
        loop.ode()


def test_a_law_with_a_longer_period_is_held_between():
    slow = Counter().run_every(0.5)
    run = simulate(ClosedLoop(Motor(), controller=slow).digital(0.25).step(1), until=1.5)
    np.testing.assert_array_equal(run["v"][0, :, 0], [0, 0, 1, 1, 2, 2, 3])
    late = simulate(ClosedLoop(Motor(), controller=slow).digital(0.25, delay=True).step(1), until=1.5)
    np.testing.assert_array_equal(late["v"][0, :, 0], [0, 0, 0, 1, 1, 2, 2])
    with pytest.raises(ValueError, match=r"`Counter` runs once in 0.5 s, which is no whole multiple of 0.2 s"):
        ClosedLoop(Motor(), controller=slow).digital(0.2)


@block
class Shift(AbstractPlant):
    """x+ = x / 2 + u: a plant in discrete time."""

    x: float = initial(1.0, unit="m")
    inputs = layout(v="V")
    outputs = layout(x="m")
    period = 0.5

    def update(self, t, x, u):
        return {"x": x.x / 2 + u.v}


def test_equations_in_continuous_time_say_that_the_period_of_a_law_does_not_count():
    loop = motor(controller=motor().controller.run_every(0.2))
    assert loop.ode().notes == ("PI acts at every instant here; its period of 0.2 s applies only in a computer",)
    assert loop.digital(0.1).notes == motor().ode().notes == ()


def test_a_plant_in_discrete_time_moves_at_its_instants_by_the_command_that_was_held():
    run = simulate(ClosedLoop(Shift(), controller=Counter()).digital(0.5).step(1), until=2.0)
    x, expected = 1.0, []
    for k in range(5):
        expected.append(x)
        x = x / 2 + k
    np.testing.assert_array_equal(run["x"][0, :, 0], expected)
    with pytest.raises(ValueError, match="`Shift` is a recursion in discrete time"):
        ClosedLoop(Shift(), controller=law()).ode()
    with pytest.raises(ValueError, match="`Shift` moves in discrete time and has no rate"):
        open_loop(Shift())


def test_signals_are_read_by_item_and_attribute_and_cannot_be_changed():
    a, b = ca.SX.sym("a"), ca.SX.sym("b")
    both = Signals({"a": a}, b=b)
    assert both.a is a
    assert both["b"] is b
    assert ("a" in both, "c" in both, both.get("c")) == (True, False, None)
    assert list(both | {"c": a}) == ["a", "b", "c"]
    assert list(both.only(layout(b="m"))) == ["b"]
    with pytest.raises(AttributeError, match="There is no 'omgea' among the 1 signals. Did you mean 'omega'?"):
        _ = Signals(omega=a).omgea
    with pytest.raises(LookupError, match="There is no 'c' among the 2 signals"):
        _ = both["c"]
    with pytest.raises(AttributeError, match="Signals are read-only"):
        both.a = b
    assert repr(both) == "<Signals a, b>"
    assert list(copy.copy(both)) == ["a", "b"]
    assert list(pickle.loads(pickle.dumps(Signals(a=1.0)))) == ["a"]


@pytest.mark.parametrize("name", ["get", "items", "keys", "only", "values"])
def test_a_signal_is_not_called_as_a_method_is_which_its_attribute_would_be(name):
    with pytest.raises(ValueError, match=rf"`layout\({name}=...\)` must have another name, as `{name}` is a method"):
        layout(**{name: "m"})


def test_a_layout_names_units_and_starts():
    port = layout(q=("m, rad", [0.5, 1.0]), v="V")
    assert (port["q"].units, port["v"].units) == (("m", "rad"), ("V",))
    np.testing.assert_array_equal(port.default, [0.5, 1.0, 0.0])
    with pytest.raises(ValueError, match=r"`layout\(v=...\)` must be a unit, as 'rad/s' is, or a unit and the numbers"):
        layout(v=3.0)


def test_the_units_of_joints_that_slide_and_turn_are_matched_one_by_one():
    mixed = Layout((Entry("q", np.zeros(2), "m, rad"),))
    turning = plant(outputs=mixed, states=mixed, rate=lambda self, t, x, u: {"q": ca.SX.zeros(2)})
    with pytest.raises(ValueError, match=r"'q' in \[rad\], where `Tank` gives it in \[m, rad\]"):
        ClosedLoop(turning, controller=law(reads=layout(q=("rad", [0, 0]))))


def test_a_block_that_asks_for_a_signal_it_has_not_declared_is_told_so():
    blind = law(command=lambda self, t, z, est, ref: {"v": -est.omega})
    with pytest.raises(
        LookupError, match=r"`Own.command\(...\)` asks for a signal that its ports do not declare. There"
    ):
        ClosedLoop(Motor(), controller=blind).ode()
    blind = law(reads=layout(omega="rad/s"), command=lambda self, t, z, est, ref: {"v": -est["omgea"]})
    with pytest.raises(LookupError, match="There is no 'omgea' among the 1 signals. Did you mean 'omega'?"):
        ClosedLoop(Motor(), controller=blind).ode()


def test_blocks_asked_by_several_threads_leave_casadi_as_it_was():
    """Each thread put back what it had found, which could be what another had put there."""
    loop = motor()
    with ThreadPoolExecutor(4) as pool:
        made = list(pool.map(lambda _: loop.ode().fingerprint, range(40)))
    assert set(made) == {loop.ode().fingerprint}
    assert math.isnan(float(ca.SX.sym("x")))

"""Ports: what a block may ask of another, and what it must return; a loop of any plant."""

import copy
import math
import pickle
import warnings
from concurrent.futures import ThreadPoolExecutor

import casadi as ca
import numpy as np
import pytest

from workbench.arms.arm_contracts import AbstractArmController
from workbench.arms.laws import PID
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.blocks.loop import (
    AbstractController,
    AbstractObserver,
    AbstractPlant,
    AbstractReference,
    ClosedLoop,
    Instruments,
    open_loop,
)
from workbench.blocks.signals import Sines
from workbench.core import Entry, Layout, Signals, block, initial, layout, parameter, rk4
from workbench.engine import simulate

WANTED = Sines([1.0, 1.0], [1.0, 1.0])


@block
class Motor(AbstractPlant):
    """L i' = v - R i - K omega, J omega' = K i - b omega."""

    R: float = parameter(1.0, unit="ohm", low=0)
    L: float = parameter(0.5, unit="H", low=0, strict=True)
    K: float = parameter(0.01, unit="N m/A")
    J: float = parameter(0.01, unit="kg m^2", low=0, strict=True)
    b: float = parameter(0.1, unit="N m s/rad", low=0)
    i: float = initial(0.0, unit="A")
    omega: float = initial(0.0, unit="rad/s")

    inputs = layout(v="V")
    outputs = layout(omega="rad/s")

    def rate(self, t, x, u):
        return {
            "i": (u.v - self.R * x.i - self.K * x.omega) / self.L,
            "omega": (self.K * x.i - self.b * x.omega) / self.J,
        }


@block
class Level(AbstractReference):
    """omega_ref = level."""

    level: float = parameter(1.0, unit="rad/s")
    says = layout(omega="rad/s")

    def at(self, t):
        return {"omega": self.level}


@block
class PI(AbstractController):
    """v = kp e + ki z, z' = e, with e = omega_ref - omega."""

    kp: float = parameter(50.0, unit="V s/rad")
    ki: float = parameter(100.0, unit="V/rad")
    z: float = initial(0.0, unit="rad")

    reads = layout(omega="rad/s")
    follows = layout(omega="rad/s")
    drives = layout(v="V")

    def command(self, t, z, est, ref):
        return {"v": self.kp * (ref.omega - est.omega) + self.ki * z.z}

    def rate(self, t, z, est, ref):
        return {"z": ref.omega - est.omega}


def motor(**changes):
    return ClosedLoop(**{"plant": Motor(), "controller": PI(), "reference": Level(), **changes})


def law(**own):
    """A law of one's own with other ports or methods."""
    plain = {"reads": layout(), "drives": layout(v="V"), "command": lambda self, t, z, est, ref: {"v": 0}}
    return block(type("Own", (AbstractController,), {**plain, **own}))()


def plant(**own):
    plain = {
        "states": layout(x="m"),
        "inputs": layout(v="V"),
        "outputs": layout(x="m"),
        "rate": lambda self, t, x, u: {"x": u.v - x.x},
    }
    return block(type("Tank", (AbstractPlant,), {**plain, **own}))()


def observer(**own):
    plain = {
        "reads": layout(omega="rad/s"),
        "gives": layout(omega="rad/s"),
        "estimate": lambda self, t, z, y: {"omega": y.omega},
    }
    return block(type("Watcher", (AbstractObserver,), {**plain, **own}))()


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


MISFITS = [
    (
        lambda: motor(reference=None),
        "`PI` follows 'omega', and the loop has no reference: give `ClosedLoop(reference=...)` one that says it, as a "
        "`Step` does.",
    ),
    (lambda: motor(plant=plant()), "`PI` reads 'omega', where `Tank` gives 'x'."),
    (
        lambda: motor(observer=observer(gives=layout(omega="deg/s"))),
        "`PI` reads 'omega' in [rad/s], where `Watcher` gives it in [deg/s].",
    ),
    (
        lambda: motor(observer=observer(reads=layout(omega=("rad/s", [0, 0])))),
        "`Watcher` reads 'omega' as 2 numbers, where `Motor` gives it as one number.",
    ),
    (
        lambda: motor(observer=observer(reads=layout(omgea="rad/s"))),
        "`Watcher` reads 'omgea', where `Motor` gives 'omega'; did you mean 'omega'?",
    ),
    (
        lambda: motor(observer=observer(inputs=layout(u="V"))),
        "`Watcher` counts on 'u', where `Motor` has as inputs 'v'.",
    ),
    (
        lambda: motor(controller=law(drives=layout(v="V", brake="N m"))),
        "`Own` drives 'brake', where `Motor` has as inputs 'v'.",
    ),
    (
        lambda: motor(controller=law(drives=layout())),
        "Every input of `Motor` must be driven: nothing drives 'v', as `Own` drives nothing.",
    ),
    (
        lambda: motor(plant=plant(inputs=layout(v="V", w="V")), controller=law()),
        "nothing drives 'w', as `Own` drives 'v'.",
    ),
    (lambda: ClosedLoop(Motor()), "`ClosedLoop(controller=...)` must be an `AbstractController`; got None."),
    (
        lambda: motor(plant=plant(truths=layout(d="V")), observer=observer(reads=layout(d="V")), controller=law()),
        "`Watcher` reads 'd', which no instrument of `Tank` gives: read one of 'x', or declare `uses_truth = True`.",
    ),
    (
        lambda: ClosedLoop(plant(outputs=layout(v="m")), controller=law()),
        "here 'v' would stand for two of them: rename an input or an output of `Tank`.",
    ),
]


@pytest.mark.parametrize(("make", "says"), MISFITS)
def test_ports_that_do_not_fit_are_refused_with_both_blocks(make, says):
    with pytest.raises(ValueError) as error:
        make()
    assert says in str(error.value)


RETURNS = [
    ([1.0, 2.0], "`Own.command(...)` must return 'v'; it returned [1.0, 2.0]."),
    (None, "`Own.command(...)` must return 'v'; it returned None."),
    ({}, "`Own.command(...)` must return 'v'; it returned an empty mapping, without 'v'."),
    ({"v": 1.0, "w": 2.0}, "`Own.command(...)` must return 'v', and no more; it returned 'w' too."),
    ({"v": ca.SX.zeros(2)}, "`Own.command(...)` must return 'v' in shape (1, 1); it returned shape (2, 1)."),
    ({"v": "fast"}, "`Own.command(...)` must return 'v' as an expression of shape (1, 1); it returned 'fast'."),
]


@pytest.mark.parametrize(("returned", "says"), RETURNS)
@pytest.mark.parametrize("make", [lambda loop: loop.ode(), lambda loop: loop.digital(0.1)])
def test_a_law_that_returns_something_else_is_refused_by_class_and_method(returned, says, make):
    with pytest.raises(ValueError) as error:
        make(ClosedLoop(Motor(), controller=law(command=lambda self, t, z, est, ref: returned)))
    assert str(error.value).startswith(says)


@pytest.mark.parametrize(
    "command",
    [
        lambda self, t, z, est, ref: {"v": math.sin(est.omega)},
        lambda self, t, z, est, ref: {"v": float(t)},
        lambda self, t, z, est, ref: {"v": max(est.omega, 0.0)},
        lambda self, t, z, est, ref: {"v": 1.0 if est.omega > 0 else 2.0},
    ],
)
def test_a_law_that_takes_a_symbol_for_a_number_is_refused_and_gives_no_nan(command):
    """Python's `math` makes NaN of CasADi's symbols without a word: every run would have been called diverged."""
    loop = ClosedLoop(Motor(), controller=law(reads=layout(omega="rad/s"), command=command))
    says = r"`Own.command\(...\)` must compute with symbols .* is no number: take `ca.sin`.*`ca.if_else\(c, a, b\)`"
    for make in (lambda: loop.ode(), lambda: loop.digital(0.1)):
        with pytest.raises(ValueError, match=says):
            make()


def test_numpys_functions_serve_in_a_law_without_a_warning():
    own = law(reads=layout(omega="rad/s"), command=lambda self, t, z, est, ref: {"v": np.sin(est.omega)})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ode = ClosedLoop(Motor(), controller=own).ode()
    assert ode.outputs_at(0.0, [0.0, 0.5])["v"] == math.sin(0.5)


@pytest.mark.parametrize("port", ["reads", "follows", "drives", "memory"])
def test_a_port_that_is_no_layout_is_refused_by_its_name(port):
    with pytest.raises(ValueError, match=rf"`Own.{port}` must be a `Layout`, as .* of names and units; got 'v'\."):
        ClosedLoop(Motor(), controller=law(**{port: "v"}))


def test_a_plant_that_cannot_move_is_refused():
    with pytest.raises(ValueError, match=r"`Tank` must have a `rate`, or an `update` and a `period`"):
        open_loop(plant(rate=AbstractPlant.rate))


def test_each_method_of_each_block_is_held_to_its_port():
    def says(loop):
        with pytest.raises(ValueError) as error:
            loop.ode()
        return str(error.value)

    def odd(self, *given):
        return {"odd": 0}

    assert "`Tank.rate(...)` must return 'x'" in says(ClosedLoop(plant(rate=odd), controller=law()))
    assert "`Tank.measure(...)` must return 'x'" in says(ClosedLoop(plant(measure=odd), controller=law()))
    assert "`Tank.applied(...)` must return 'v'" in says(ClosedLoop(plant(applied=odd), controller=law()))
    assert "`Watcher.estimate(...)` must return 'omega'" in says(motor(observer=observer(estimate=odd)))
    assert "`Own.rate(...)` must return an empty mapping" in says(ClosedLoop(Motor(), controller=law(rate=odd)))
    assert "`Own.signals(...)` must return a mapping; it returned None" in says(
        ClosedLoop(Motor(), controller=law(signals=lambda self, z, est, ref: None))
    )


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
        Manipulator(paper_arm(), q=[0.1, 0.2]), controller=OneTorque(), reference=Sines([1.0] * 2, [1.0] * 2)
    )
    with pytest.raises(
        ValueError, match=r"`OneTorque.command\(...\)` must return 'tau' in shape \(2, 1\); it returned"
    ):
        loop.ode()


def test_an_arm_needs_no_observer_either():
    arm = paper_arm()
    pid = PID([9.0, 9.0], [1.0, 1.0], [3.0, 3.0], arm)
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
    assert loop.ode().notes == ("PI acts at every instant here: its period of 0.2 s is that of a computer",)
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

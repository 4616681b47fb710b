"""Disturbances of any plant: python-control's sensitivities, the arm's own torque, and truths with names."""

import control
import numpy as np
import pytest

from tests.support.plain_plants import SPEED, VOLTAGE, Counter, Motor
from workbench.arms.laws import ArmPID
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import ArmFullState
from workbench.blocks.laws import PID
from workbench.blocks.loop import ClosedLoop, open_loop
from workbench.blocks.plants import DisturbedPlant, EquippedPlant, OdePlant
from workbench.blocks.signals import CombinedReference, Constant, Sines, SineTorque, Step, Table
from workbench.core import layout, rk4
from workbench.engine import simulate

LAW = PID(SPEED, VOLTAGE, Kp=20.0, Ki=40.0)


def run_of(by):
    loop = ClosedLoop(DisturbedPlant(Motor(), by), controller=LAW, reference=Constant("omega", "rad/s", 0.0))
    return simulate(rk4(loop.ode(), 1e-3), until=2.0, every=0.02)


def sensitivity(name):
    s, m = control.tf("s"), Motor()
    P, C = m.K / ((m.J * s + m.b) * (m.L * s + m.R) + m.K**2), 20 + 40 / s
    return control.minreal({"v": P, "omega": 1}[name] / (1 + P * C), verbose=False)


@pytest.mark.parametrize(("name", "unit"), [("v", "V"), ("omega", "rad/s")])
def test_a_step_on_a_port_is_answered_by_its_sensitivity(name, unit):
    run = run_of(Step(name, unit, 1.0))
    _, y = control.step_response(sensitivity(name), run.t)
    np.testing.assert_allclose(run["omega"].ravel(), y, rtol=0, atol=1e-9)  # (10 h)^4 / 120
    np.testing.assert_array_equal(run[f"d_{name}"].ravel(), 1.0)


def test_disturbances_on_several_ports_add_up():
    parts = Step("v", "V", 1.0), Step("omega", "rad/s", 1.0)
    both = run_of(CombinedReference(parts))["omega"]
    np.testing.assert_allclose(both, sum(run_of(part)["omega"] for part in parts), rtol=0, atol=1e-12)  # linear


def test_a_disturbance_acts_behind_the_command():
    run = run_of(Step("v", "V", 2.0, time=1.0))
    added = np.where(run.t >= 1.0, 2.0, 0.0)
    np.testing.assert_allclose((run["v_applied"] - run["v"]).ravel(), added, rtol=0, atol=1e-13)


def test_a_disturbance_is_a_truth_and_its_numbers_are_parameters():
    plant = DisturbedPlant(Motor(), Step("v", "V", 1.0))
    assert plant.truths.names == ("d_v",)
    assert plant.truths["d_v"].unit == "V"
    assert {"by.level", "plant.K"} <= set(open_loop(plant).parameters.names)


def test_a_torque_on_an_arm_is_its_own_disturbance_with_the_other_sign():
    arm, q = paper_arm(), [0.1, 0.2]
    law, wanted = ArmPID([100.0, 100.0], [10.0, 10.0], [20.0, 20.0], arm), Sines("q", "rad", [0.5, 0.5], 1.0)
    added = DisturbedPlant(Manipulator(arm, q), Sines("tau", "N m", [2.0, 1.0], [3.0, 5.0]))
    own = Manipulator(arm, q, disturbance=SineTorque([-2.0, -1.0], [3.0, 5.0]))
    a, b = (
        simulate(rk4(ClosedLoop(plant, ArmFullState(2), law, wanted).ode(), 1e-3), until=1.0) for plant in (added, own)
    )
    np.testing.assert_allclose(a["e"], b["e"], rtol=0, atol=1e-13)  # rounding of tau + d and tau - (-d)
    np.testing.assert_allclose(a["d_tau"], -b["d"], rtol=0, atol=1e-14)


def test_a_plant_in_discrete_time_is_disturbed_at_its_instants():
    plant = DisturbedPlant(Counter(), CombinedReference((Step("v", "V", 1.0, time=0.25), Step("n", "V", 10.0))))
    law = PID(layout(n="V"), VOLTAGE, Kp=0.5)
    loop = ClosedLoop(plant, controller=law, reference=Constant("n", "V", 10.0))
    with pytest.raises(ValueError, match="`DisturbedPlant` is a recursion in discrete time"):
        loop.ode()
    run = simulate(loop.digital(0.1).step(), until=1.0)
    n = [0.0]
    for k in range(10):
        n.append(n[-1] - 0.5 * n[-1] + (k * 0.1 >= 0.25))
    np.testing.assert_allclose(run["n"].ravel() - 10, n, rtol=0, atol=1e-14)


def test_a_table_of_a_disturbance_ends_the_run_too():
    plant = DisturbedPlant(Motor(), CombinedReference((Table("v", "V", [0, 1], [0, 1]),)))
    assert ClosedLoop(plant, controller=LAW, reference=Constant("omega", "rad/s", 0.0)).ode().horizon == 1.0
    assert open_loop(plant).horizon == 1.0


@pytest.mark.parametrize(
    ("by", "says"),
    [
        (Step("omeg", "rad/s", 1.0), "adds 'omeg', where `Motor` has 'v', 'omega'; did you mean 'omega'?"),
        (Step("v", "A", 1.0), "adds 'v' in [A], where `Motor` has it in [V]."),
        (Step("v", "V", [1.0, 2.0]), "adds 'v' as 2 numbers, where `Motor` has it as one number."),
    ],
)
def test_a_disturbance_of_no_port_is_refused(by, says):
    with pytest.raises(ValueError) as error:
        DisturbedPlant(Motor(), by)
    assert says in str(error.value)


def test_equations_that_end_with_a_table_end_as_a_plant_too():
    pushed = OdePlant(open_loop(DisturbedPlant(Motor(), Table("v", "V", [0.0, 1.0], [0.0, 1.0]))))
    loop = ClosedLoop(EquippedPlant(pushed), controller=LAW, reference=Constant("omega", "rad/s", 0.0))
    assert (open_loop(pushed).horizon, loop.ode().horizon, loop.digital(0.1).flow.horizon) == (1.0, 1.0, 1.0)


def test_a_second_disturbance_of_one_signal_is_refused():
    once = DisturbedPlant(Motor(), Step("v", "V", 1.0))
    with pytest.raises(
        ValueError, match="must leave the name 'd_v' to `DisturbedPlant`.* add the two up in one signal"
    ):
        DisturbedPlant(once, Step("v", "V", 2.0))

"""The energy of a pair of signals, and of the pair that a plant declares."""

import casadi as ca
import numpy as np
import pytest

from tests.support.timed_signals import TIME, measured, of_time
from workbench.blocks.laws import PID
from workbench.blocks.loop import AbstractPlant, ClosedLoop
from workbench.blocks.plants import EquippedPlant
from workbench.blocks.signals import Step
from workbench.core import block, initial, layout
from workbench.engine.metrics import energy
from workbench.engine.metrics.energy import unit_of_work


@block
class Mass(AbstractPlant):
    """A mass of 2 kg on a plane, which declares the power that its force brings."""

    power = ("F", "v")
    v: float = initial(default=0.0, unit="m/s")

    @property
    def inputs(self):
        return layout(F="N")

    @property
    def outputs(self):
        return layout(v="m/s")

    def rate(self, t, x, u):
        return {"v": u["F"] / 2.0}


def test_the_energy_of_a_loop_is_of_the_power_that_its_plant_declares():
    law, wanted = PID(Mass().outputs, Mass().inputs, Kp=10.0), Step("v", "m/s", 1.0)
    for plant in (Mass(), EquippedPlant(Mass())):
        loop = ClosedLoop(plant, controller=law, reference=wanted)
        score = measured(loop.ode(), energy(), until=10.0, h=0.01)["energy"]
        assert score.metric.unit == "J"
        assert score.metric.about == "integral of |F_applied v|, nothing recovered"
        assert score.value == pytest.approx(1.0, rel=1e-6)  # 2 kg at 1 m/s; RK4 of 10 ms at 5 1/s
        assert loop.digital(0.01).flow.power == ("F_applied", "v")


def test_a_power_that_is_no_pair_of_the_signals_of_a_plant_is_refused():
    class Wrong(Mass):
        power = ("F", "x")

    law = PID(Mass().outputs, Mass().inputs, Kp=10.0)
    with pytest.raises(ValueError, match=r"`Wrong\.power` must be an input and an output .* Its inputs are F"):
        ClosedLoop(Wrong(), controller=law, reference=Step("v", "m/s", 1.0)).ode()


def test_the_energy_of_two_signals_is_the_integral_of_their_product():
    score = measured(of_time(u=ca.cos(TIME), i=2 * ca.cos(TIME)), energy(("u", "i")), until=2 * np.pi, h=np.pi / 500)
    assert score["energy of u i"].value == pytest.approx(2 * np.pi, rel=1e-9)  # Simpson's rule at a thousand points
    with pytest.raises(LookupError, match=r"'energy of u j' is of 'u' times 'j', .* has no 'j': name a pair"):
        measured(of_time(u=TIME), energy(("u", "j")))
    with pytest.raises(LookupError, match=r"'energy' without a pair .* 'of time' declares none: name a pair"):
        measured(of_time(u=TIME), energy())
    two = of_time(u=TIME, i=ca.vertcat(TIME, TIME))
    with pytest.raises(ValueError, match=r"number by number; 'u' has 1 and 'i' has 2: name two of one size"):
        measured(two, energy(("u", "i")))


POWERS = [("N m", "rad/s", "J"), ("V", "A", "J"), ("N", "m/s", "J"), ("Pa", "m^3/s", "J")]
POWERS += [("V", "rad/s", "V rad"), ("V", "?", "?"), ("mm N", "1/s", "mm N")]


@pytest.mark.parametrize(("effort_unit", "flow_unit", "printed"), POWERS)
def test_effort_times_flow_times_seconds_is_an_energy_where_it_is_one(effort_unit, flow_unit, printed):
    assert unit_of_work(effort_unit, flow_unit) == printed

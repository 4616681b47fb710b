"""A plant of any kind behind actuators and sensors."""

import casadi as ca
import numpy as np
import pytest
from scipy.linalg import expm

from tests.support.cases import heavy_but
from tests.support.compilers import needs_llvmlite
from tests.support.equipped_motor import Mixed, Motor
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.blocks.loop import AbstractController, ClosedLoop, Instruments, open_loop
from workbench.blocks.plants import (
    AbstractElement,
    Backlash,
    DeadZone,
    EquippedPlant,
    FirstOrder,
    PadeDelay,
    Quantiser,
    RateLimit,
    Saturation,
)
from workbench.blocks.plants.elements import pade
from workbench.core import Signals, block, initial, layout, parameter, rk4
from workbench.design.linear import linearize
from workbench.engine import simulate
from workbench.engine.reference import reference_run


@block
class Gain(AbstractController):
    """v = k (1 - omega)."""

    k: float = parameter(3.0, unit="V s/rad")
    reads = layout(omega="rad/s")
    drives = layout(v="V")

    def command(self, t, z, est, ref):
        return {"v": self.k * (1 - est.omega)}


def test_the_plant_keeps_its_names_and_an_element_has_that_of_its_signal():
    plant = EquippedPlant(
        Motor(),
        (Saturation("v", -12, 12), FirstOrder("v", 0.1), FirstOrder("v", 0.2), FirstOrder("v", 0.3)),
        (FirstOrder("omega", 0.01),),
    )
    ode = ClosedLoop(plant, controller=Gain()).ode()
    assert {entry.name: entry.unit for entry in ode.states.entries} == {
        "plant.omega": "rad/s",
        "plant.v.lag": "V",
        "plant.v.lag_2": "V",
        "plant.v.lag_3": "V",
        "plant.omega.lag": "rad/s",
    }
    units = {entry.name: entry.unit for entry in ode.parameters.entries}
    assert units["plant.plant.K"] == "rad/(V s)"
    assert units["plant.actuators[0].low"] == "V"
    assert units["plant.actuators[2].time_constant"] == "s"
    assert ode.outputs.names == ("omega", "v", "v_applied", "omega_true", "omega_error")


def test_a_sensor_hides_what_the_plant_does_and_the_truth_shows_it():
    loop = ClosedLoop(EquippedPlant(Motor(), (), (Saturation("omega", -1.0, 0.5),)), controller=Gain())
    run = simulate(rk4(loop.ode(), 0.01), until=1.0, every=0.1)
    np.testing.assert_array_equal(run["omega"], np.minimum(run["omega_true"], 0.5))
    assert np.abs(run["omega"] - run["omega_true"]).max() > 0.05
    np.testing.assert_allclose(run["v"], 3 * (1 - run["omega"]), rtol=1e-15)  # the law reads the sensor


def test_the_linear_model_is_that_of_the_chain():
    plant = EquippedPlant(Motor(), (FirstOrder("v", 0.1),), (FirstOrder("omega", 0.02),))
    linear = linearize(open_loop(plant), 0.0, [0.0, 0.0, 0.0])
    np.testing.assert_allclose(linear.A, [[-2, 4, 0], [0, -10, 0], [50, 0, -50]], rtol=1e-14)
    np.testing.assert_allclose(linear.B, [[0], [10], [0]], rtol=1e-14)
    np.testing.assert_array_equal(linear.C, [[0, 0, 1]])


@pytest.mark.parametrize("order", [1, 4, 7])
def test_the_frequency_response_with_a_delay_is_that_of_the_plant_times_that_of_the_approximant(order):
    plant = EquippedPlant(Motor(), (PadeDelay("v", 0.3, order),), (FirstOrder("omega", 0.025),))
    ode = open_loop(plant)
    linear = linearize(ode, 0.0, ode.states.default)
    A, B, C, D = pade(order)
    for omega in (0.5, 3.0, 20.0):
        s = 1j * omega
        late = C @ np.linalg.solve(0.3 * s * np.eye(order) - A, B) + D
        want = 2 / (0.5 * s + 1) * late / (0.025 * s + 1)
        assert complex(linear(s)) == pytest.approx(want, rel=1e-12)


EVERYTHING = EquippedPlant(
    Motor(),
    (
        Saturation("v", -2, 2),
        RateLimit("v", -30, 20, 0.01),
        FirstOrder("v", 0.05),
        PadeDelay("v", 0.05, 3),
        DeadZone("v", -0.01, 0.02),
        Backlash("v", 0.1, 0.01),
    ),
    (FirstOrder("omega", 0.02), Saturation("omega", -0.5, 0.55), Quantiser("omega", 0.01, "toward zero")),
)


@needs_llvmlite
@pytest.mark.parametrize("arithmetic", heavy_but(["fused", "portable"], "fused"))
def test_every_element_has_the_same_bits_in_the_compiled_march_and_in_numpy(arithmetic):
    loop = ClosedLoop(EVERYTHING, controller=Gain())
    for step in (rk4(loop.ode(), 2e-3), loop.digital(0.01, Instruments.of(EVERYTHING, noise={"omega": 0.01})).step(3)):
        p = step.parameters.pack({"plant.actuators[1].high": np.linspace(10.0, 30.0, 5)})
        runs = [simulate(step, p, until=0.3, every=0.01, engine=e, arithmetic=arithmetic) for e in ("native", "numpy")]
        assert np.isfinite(runs[0].x).all()
        assert runs[0]["omega_true"].max() > 0.55  # beyond the range of the sensor, as the command is beyond its own
        np.testing.assert_array_equal(*(run.x.view(np.uint64) for run in runs))


def test_a_batch_agrees_with_the_reference_that_locates_every_corner():
    plant = EquippedPlant(Motor(), EVERYTHING.actuators, EVERYTHING.sensors[:1])
    ode = ClosedLoop(plant, controller=Gain(20.0)).ode()
    exact = reference_run(ode, times=[0.0, 0.25, 0.5, 1.0])
    assert len(exact.events) > 10
    run = simulate(rk4(ode, 2.5e-5), until=1.0, every=0.25)
    # a step over a corner errs by the square of its length, a dozen of them by less than 1e-6
    np.testing.assert_allclose(run.x[0, [0, 1, 2, 4]], exact.x, atol=1e-6)


def test_a_limit_is_a_number_that_a_batch_varies():
    ode = ClosedLoop(EquippedPlant(Motor(), (Saturation("v", -1, 1),)), controller=Gain()).ode()
    p = ode.parameters.pack({"plant.actuators[0].high": [0.1, 0.2, 0.4]})
    run = simulate(rk4(ode, 0.01), p, until=5.0, every=5.0)
    # at rest omega = K v, which the limit holds below k / (1 + K k); ten time constants leave 5e-5
    np.testing.assert_allclose(run["omega"][:, -1].ravel(), [0.2, 0.4, 0.8], rtol=1e-4)


def test_in_a_computer_the_lag_flows_between_the_instants():
    T, k, period = 0.05, 3.0, 0.02
    step = ClosedLoop(EquippedPlant(Motor(), (FirstOrder("v", T),)), controller=Gain(k)).digital(period).step(20)
    run = simulate(step, until=0.4)
    # the plant and its lag, driven by a command that is held: an exponential of one matrix
    whole = expm(period * np.array([[-2, 4, 0], [0, -1 / T, 1 / T], [0, 0, 0]]))
    x = np.zeros(2)
    for n in range(21):
        # Runge-Kutta with lambda h = 0.02 leaves 1e-10 a step
        assert run["omega"][0, n] == pytest.approx(x[0], abs=1e-8)
        x = (whole @ [*x, k * (1 - x[0])])[:2]


def test_an_arm_may_have_a_number_for_each_joint():
    plant = EquippedPlant(Manipulator(paper_arm(), q=[0.1, 0.2]), (Saturation("tau", [-1.0, -2.0], 3.0),))
    assert plant.labels["e_q"] == "e"
    tau = plant.applied_inputs(
        ca.SX(0), plant.states.view(ca.DM(plant.states.default)), Signals(tau=ca.SX([-5.0, -5.0]))
    )
    np.testing.assert_array_equal(np.array(ca.evalf(tau.tau)).ravel(), [-1, -2])
    assert open_loop(EquippedPlant(plant.plant, (PadeDelay("tau", 0.1, 3),))).states["tau.delayed"].shape == (3, 2)


def test_a_number_for_each_of_two_units_has_these_units():
    parameters = open_loop(EquippedPlant(Mixed(), (RateLimit("tau", [-1, -2], [1, 2], 0.01),))).parameters
    assert parameters["actuators[0].low"].units == ("N/s", "N m/s")
    delayed = open_loop(EquippedPlant(Mixed(), (PadeDelay("tau", 0.1, 2),))).states["tau.delayed"]
    assert delayed.units == ("N", "N", "N m", "N m")


def test_an_element_of_ones_own_has_a_memory_and_numbers_of_any_shape():
    @block
    class Filter(AbstractElement):
        """Two states behind a matrix."""

        A: np.ndarray = parameter(unit="1/s", shape=("2", "2"))
        first: float = initial(0.0, unit="{unit}")
        second: float = initial(1.0, unit="{unit}")

        def output(self, z, v):
            return z["first"]

        def rate(self, z, v):
            moved = self.A @ ca.vertcat(z["first"], z["second"])
            return {"first": moved[0] + v, "second": moved[1]}

    ode = open_loop(EquippedPlant(Motor(), (Filter("v", [[-1.0, 2.0], [0.0, -3.0]]),)))
    np.testing.assert_array_equal(ode.states.default, [0, 0, 1])
    linear = linearize(ode, 0.0, ode.states.default)
    np.testing.assert_array_equal(linear.A, [[-2, 4, 0], [0, -1, 2], [0, 0, -3]])


def test_a_plant_without_elements_costs_nothing():
    bare, equipped = (
        rk4(ClosedLoop(plant, controller=Gain()).ode(), 0.01) for plant in (Motor(), EquippedPlant(Motor()))
    )
    assert equipped.operations == bare.operations
    np.testing.assert_array_equal(simulate(equipped, until=1.0).x, simulate(bare, until=1.0).x)

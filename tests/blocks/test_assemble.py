"""Once round the loop: blocks in their sockets become one Ode."""

import casadi as ca
import numpy as np
import pytest

from workbench.arms.arm_contracts import AbstractArmController, AbstractArmObserver
from workbench.arms.manipulator import DirectDrive, FirstOrderLag, Manipulator
from workbench.arms.mechanics import PlanarArm, paper_arm, robot
from workbench.blocks.loop import ClosedLoop, open_loop
from workbench.blocks.signals import Constant, Sines, SineTorque
from workbench.core import Entry, Layout, Signals, block, initial, parameter
from workbench.core.block import Vector


@block
class Watcher(AbstractArmObserver):
    """Positions and velocities as they are; the disturbance only where it may be seen."""

    joints: int = 2
    truth: bool = False

    @property
    def dof(self):
        return self.joints

    @property
    def uses_truth(self):
        return self.truth

    @property
    def measured_signals(self):
        return ("q", "qd", "d") if self.truth else ("q", "qd")

    @property
    def memory(self):
        return Layout((Entry("age", np.array(0.0), "s"),))

    def estimate(self, t, z, y):
        return Signals(q=y.q, qd=y.qd, d=y["d"] if "d" in y else ca.SX.zeros(self.joints))

    def rate(self, t, z, y, est, u):
        return {"age": ca.SX(1)}


@block
class Gains(AbstractArmController):
    """tau = G(q) of the model - K e - Kd ed + d_hat, and an integral of e that is only watched."""

    estimates = ("q", "qd", "d")

    model: PlanarArm
    K: Vector = parameter(unit="N m/rad", low=0, shape=("n",))
    Kd: Vector = parameter(unit="N m s/rad", low=0, shape=("n",))
    start: Vector = initial(0.0, unit="rad s", shape=("n",))

    @property
    def dof(self):
        return self.model.dof

    @property
    def memory(self):
        return Layout((Entry("sum", self.start, "rad s"),))

    def torque(self, t, z, est, ref):
        return self.model.gravity_vector(est.q) - self.K * (est.q - ref.q) - self.Kd * (est.qd - ref.qd) + est.d

    def rate(self, t, z, est, ref):
        return {"sum": est.q - ref.q}

    def signals(self, z, est, ref):
        return {"s": est.qd - ref.qd}


def loop(**changes) -> ClosedLoop:
    arm = paper_arm()
    blocks = {
        "plant": Manipulator(arm, [0.3, -0.2], [0.1, 0.0], disturbance=SineTorque([1.0, 2.0], [3.0, 4.0])),
        "observer": Watcher(),
        "controller": Gains(arm, [50.0, 40.0], [10.0, 8.0]),
        "reference": Sines("q", "rad", [1.0, 0.5], [1.0, 2.0]),
    }
    return ClosedLoop(**{**blocks, **changes})


def test_states_and_parameters_are_named_by_socket():
    ode = loop().ode("my loop")
    assert ode.name == "my loop"
    assert ode.states.names == ("plant.q", "plant.qd", "observer.age", "controller.sum")
    assert {"plant.arm.links[0].mass", "controller.model.links[0].mass", "controller.K", "reference.amplitude"} <= set(
        ode.parameters.names
    )
    assert ode.parameters["plant.disturbance.amplitude"].unit == "N m"


def test_the_outputs_are_the_signals_of_the_loop():
    ode = loop().ode()
    t, x = 0.4, ode.states.default
    y = ode.outputs_at(t, x)
    ref = np.array([np.sin(0.4), 0.5 * np.sin(0.8)])
    np.testing.assert_allclose(y["q"], [0.3, -0.2])
    np.testing.assert_allclose(y["q_ref"], ref, rtol=1e-14)
    np.testing.assert_allclose(y["e"], [0.3, -0.2] - ref, rtol=1e-14)
    np.testing.assert_allclose(y["ed"], y["qd"] - y["qd_ref"], rtol=1e-14)
    np.testing.assert_allclose(y["s"], y["ed"], rtol=1e-14)
    np.testing.assert_allclose(y["d"], [np.sin(1.2), 2 * np.sin(1.6)], rtol=1e-14)
    np.testing.assert_array_equal(y["q_error"], 0)
    np.testing.assert_allclose(y["d_error"], y["d"])  # nothing is known of it
    np.testing.assert_array_equal(y["tau"], y["tau_applied"])
    assert ode.outputs["tau"].unit == "N m"


def test_the_torque_drives_the_plant_as_commanded():
    ode = loop().ode()
    x = ode.states.default
    rate = ode.states.unpack(ode.rate_at(0.4, x))
    y = ode.outputs_at(0.4, x)
    plant = Manipulator(paper_arm(), [0.3, -0.2], [0.1, 0.0], disturbance=SineTorque([1.0, 2.0], [3.0, 4.0]))
    z = {"q": ca.SX([0.3, -0.2]), "qd": ca.SX([0.1, 0.0])}
    alone = plant.rate(ca.SX(0.4), z, Signals(tau=ca.SX(y["tau"])))
    np.testing.assert_allclose(rate["plant.qd"], np.array(ca.evalf(alone["qd"])).ravel(), rtol=1e-12)
    np.testing.assert_array_equal(rate["plant.q"], [0.1, 0.0])
    np.testing.assert_allclose(rate["controller.sum"], y["e"], rtol=1e-14)
    assert rate["observer.age"] == 1


def test_a_loop_cut_at_the_torque_and_driven_by_it_is_the_loop():
    whole, cut = loop().ode(), loop().cut()
    assert (cut.inputs, cut.outputs.names) == (("drive",), ("tau",))
    assert cut.parameters["drive"].unit == "N m"
    x = whole.states.default
    tau = whole.outputs_at(0.4, x)["tau"]
    np.testing.assert_array_equal(cut.outputs_at(0.4, x)["tau"], tau)
    driven = cut.parameters.pack({"drive": tau})[0]
    np.testing.assert_array_equal(cut.rate_at(0.4, x, driven), whole.rate_at(0.4, x))
    # without a torque the plant falls as it would alone; what the law commands does not change
    still = whole.states.unpack(cut.rate_at(0.4, x))
    alone = open_loop(loop().plant)
    np.testing.assert_array_equal(still["plant.qd"], alone.rate_at(0.4, alone.states.default)[2:])


def test_a_mismatch_of_model_and_arm_needs_no_code():
    ode = loop().ode()
    heavy = ode.parameters.pack({"plant.arm.links[1].mass": 2.0})[0]
    x = ode.states.default
    np.testing.assert_array_equal(ode.outputs_at(0.4, x, heavy)["tau"], ode.outputs_at(0.4, x)["tau"])
    assert not np.allclose(ode.rate_at(0.4, x, heavy), ode.rate_at(0.4, x))


def test_a_limit_of_the_drive_shows_in_the_applied_torque_only():
    plant = Manipulator(paper_arm(), [3.0, -3.0], actuator=DirectDrive([5.0, 5.0]))
    ode = loop(plant=plant).ode()
    y = ode.outputs_at(0.0, ode.states.default)
    assert np.abs(y["tau"]).max() > 5
    np.testing.assert_array_equal(y["tau_applied"], np.clip(y["tau"], -5, 5))


def test_a_lag_adds_its_memory_to_the_states():
    plant = Manipulator(paper_arm(), [0.3, -0.2], actuator=FirstOrderLag(0.1))
    assert "plant.tau_m" in loop(plant=plant).ode().states.names


def test_an_estimate_sees_the_truth_only_where_that_is_declared():
    honest, oracle = loop(), loop(observer=Watcher(truth=True))
    x = honest.ode().states.default
    # `Watcher` passes on any disturbance that it is shown: it was shown none
    truth = [np.sin(1.2), 2 * np.sin(1.6)]
    np.testing.assert_allclose(honest.ode().outputs_at(0.4, x)["d_error"], truth, rtol=1e-14)
    np.testing.assert_array_equal(oracle.ode().outputs_at(0.4, x)["d_error"], [0, 0])
    assert not honest.observer.uses_truth
    assert honest.ode().notes == ()
    assert oracle.observer.uses_truth
    assert any("the true signal d" in note for note in oracle.ode().notes)


@pytest.mark.parametrize(
    ("socket", "odd"),
    [
        ("plant", Manipulator(robot("planar-3r"), np.zeros(3))),
        ("observer", Watcher(joints=3)),
        ("controller", Gains(robot("planar-3r"), np.ones(3), np.ones(3))),
        ("reference", Constant("q", "rad", [0.0, 0.0, 0.0])),
    ],
)
def test_blocks_of_different_sizes_are_refused_by_socket(socket, odd):
    with pytest.raises(
        ValueError, match=r"`\w+` (reads|follows) 'q' as (2|3) numbers, where `\w+` (gives|says) it as (2|3) n"
    ):
        loop(**{socket: odd})


def test_the_equations_know_no_start_and_no_gain():
    other = loop(controller=Gains(paper_arm(), [1.0, 1.0], [1.0, 1.0], [3.0, 3.0]))
    assert other.ode().fingerprint == loop().ode().fingerprint

"""PID against a hand-written loop, and where its integral comes to rest."""

import numpy as np
import pytest

from tests.support.oracles import closed_loop, integrate, pid, worst_difference
from workbench.arms.laws import ArmPID
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm, robot
from workbench.arms.observers import ArmFullState
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Constant, Sines, SineTorque
from workbench.core import rk4
from workbench.engine import simulate

GAINS = {"Kp": [60.0, 30.0], "Ki": [20.0, 15.0], "Kd": [15.0, 6.0]}


def loop(controller, reference=None, disturbance=None):
    return ClosedLoop(
        plant=Manipulator(paper_arm(), q=[0.6, -0.8], disturbance=disturbance),
        observer=ArmFullState(2),
        controller=controller,
        reference=reference or Sines("q", "rad", amplitude=[1.0, 0.5], frequency=[2.0, 3.0]),
    )


def shaken(controller):
    return loop(controller, disturbance=SineTorque(amplitude=[0.5, 0.4], frequency=[3.0, 4.0], phase=[0.0, np.pi / 2]))


@pytest.mark.parametrize("model", [None, paper_arm()], ids=["without gravity", "with gravity"])
def test_the_loop_is_the_one_written_by_hand(model):
    ode = shaken(ArmPID(**GAINS, model=model)).ode()
    rates = closed_loop(pid(gravity=model is not None))
    assert worst_difference(ode, rates, np.random.default_rng(1)) < 1e-12  # rounding


def test_the_motion_is_that_of_another_integrator():
    ode = shaken(ArmPID(**GAINS, model=paper_arm())).ode()
    ours = simulate(rk4(ode, 5e-5), until=0.5, every=0.5).x[0, -1]
    # RK4 at 0.05 ms on modes of about 60 1/s: (h lambda)^4 is 1e-10, and the error a fraction of it
    np.testing.assert_allclose(ours, integrate(ode, closed_loop(pid(gravity=True)), 0.5), rtol=0, atol=1e-10)


def test_with_gravity_in_the_law_the_arm_rests_where_it_is_told():
    """At q = q_ref nothing moves: the feedback is zero and G(q) carries the arm."""
    ode = loop(ArmPID(**GAINS, model=paper_arm()), reference=Constant("q", "rad", [0.6, -0.8])).ode()
    np.testing.assert_allclose(ode.rate_at(0.0, ode.states.default), 0, atol=1e-14)  # rounding of G - G


def test_without_gravity_the_integral_comes_to_carry_the_arm():
    ode = loop(
        ArmPID(Kp=[60.0, 30.0], Ki=[60.0, 40.0], Kd=[15.0, 6.0]), reference=Constant("q", "rad", [0.6, -0.8])
    ).ode()
    run = simulate(rk4(ode, 2e-3), until=40.0, every=1.0)
    G = np.array([19.62 * np.sin(0.6) + 9.81 * np.sin(-0.2), 9.81 * np.sin(-0.2)])
    np.testing.assert_allclose(run["e"][0, -1], 0, atol=1e-9)  # the slowest mode has decayed for 40 s
    np.testing.assert_allclose(-np.array([60.0, 40.0]) * run["controller.integral"][0, -1], G, atol=1e-7)


def test_gains_for_different_numbers_of_joints_are_refused():
    with pytest.raises(ValueError, match=r"`ArmPID\(Ki=...\)` must be an array of shape \(n = 2\); got shape \(3,\)"):
        ArmPID(Kp=[1.0, 1.0], Ki=[0.0, 0.0, 0.0], Kd=[1.0, 1.0])


def test_a_model_of_another_arm_is_refused():
    with pytest.raises(ValueError, match="a model of 3 joints and 2 gains"):
        ArmPID(**GAINS, model=robot("planar-3r"))


def test_one_number_for_all_joints_is_refused_as_nothing_says_how_many_there_are():
    with pytest.raises(ValueError, match=r"`ArmPID\(Kp=...\)` must be an array of shape \(n\)"):
        ArmPID(Kp=1.0, Ki=[0.0], Kd=[1.0])

"""The instruments are believed."""

import numpy as np
import pytest

from workbench.arms.laws import ArmPID
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm, robot
from workbench.arms.observers import ArmFullState
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Constant, SineTorque


def loop(arm, q):
    n = len(q)
    return ClosedLoop(
        plant=Manipulator(arm, q=q, disturbance=SineTorque(amplitude=np.ones(n), frequency=np.ones(n))),
        observer=ArmFullState(n),
        controller=ArmPID(Kp=np.ones(n), Ki=np.zeros(n), Kd=np.ones(n)),
        reference=Constant("q", "rad", np.zeros(n)),
    )


def test_the_state_is_estimated_without_error_and_the_disturbance_as_zero():
    y = loop(paper_arm(), [0.6, -0.8]).ode().outputs_at(1.0, np.array([0.1, 0.2, 0.3, 0.4, 0.0, 0.0]))
    np.testing.assert_array_equal(y["q_error"], 0)
    np.testing.assert_array_equal(y["qd_error"], 0)
    np.testing.assert_array_equal(y["d_error"], y["d"])


def test_it_serves_arms_of_any_number_of_joints():
    assert loop(robot("planar-4r"), [0.1, 0.2, 0.3, 0.4]).ode().states.size == 12


def test_it_does_not_use_the_truth():
    assert not ArmFullState(2).uses_truth
    assert loop(paper_arm(), [0.0, 0.0]).ode().notes == ()


@pytest.mark.parametrize("joints", [0, -1, 1.5, True])
def test_what_is_no_number_of_joints_is_refused(joints):
    with pytest.raises(ValueError, match=r"`ArmFullState\(joints=...\)` must be a whole number"):
        ArmFullState(joints)

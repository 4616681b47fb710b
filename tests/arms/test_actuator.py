"""From the torque that is commanded to the torque that acts."""

import casadi as ca
import numpy as np
import pytest

from workbench.arms.manipulator import DirectDrive, FirstOrderLag, Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.blocks.loop import open_loop
from workbench.core import rk4


def applied(drive, tau):
    return np.array(ca.evalf(ca.SX(drive.applied_torque({}, ca.SX(tau))))).ravel()


def test_a_direct_drive_gives_what_is_commanded():
    np.testing.assert_array_equal(applied(DirectDrive(), [50.0, -70.0]), [50, -70])


def test_a_limited_drive_gives_no_more_than_its_limit_to_either_side():
    drive = DirectDrive(limit=[10.0, 20.0])
    np.testing.assert_array_equal(applied(drive, [50.0, -70.0]), [10, -20])
    np.testing.assert_array_equal(applied(drive, [9.5, -19.5]), [9.5, -19.5])


def test_a_lag_reaches_63_percent_of_a_step_after_its_time_constant():
    plant = Manipulator(paper_arm(), q=[0.0, 0.0], actuator=FirstOrderLag(0.05))
    ode = open_loop(plant)
    p = ode.parameters.pack({"tau": [2.0, -1.0]})[0]
    F, x = rk4(ode, 0.0005).F, ode.states.default
    for k in range(100):
        x = F(k, x, p, [])
    held = ode.states.unpack(np.array(x).ravel())["tau_m"]
    # closed form at t = T; RK4 at h / T = 0.01 leaves 1e-10
    np.testing.assert_allclose(held, np.array([2.0, -1.0]) * (1 - np.exp(-1)), rtol=1e-9)


def test_the_command_of_a_lag_is_limited_before_it_is_followed():
    lag = FirstOrderLag(0.05, limit=[1.0, 1.0])
    rate = lag.rate({"tau_m": ca.SX([0.0, 0.5])}, ca.SX([10.0, -10.0]))["tau_m"]
    np.testing.assert_allclose(np.array(ca.evalf(rate)).ravel(), [20.0, -30.0], rtol=1e-14)


def test_the_torque_of_a_lag_is_what_it_holds_now():
    np.testing.assert_array_equal(
        np.array(ca.evalf(FirstOrderLag(0.05).applied_torque({"tau_m": ca.SX([1.0, 2.0])}, ca.SX([9.0, 9.0])))).ravel(),
        [1.0, 2.0],
    )


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: FirstOrderLag(0.0), r"`FirstOrderLag\(time_constant=...\)` must be finite, with 0 < value \[s\]"),
        (lambda: DirectDrive(limit=[0.0, 1.0]), r"`DirectDrive\(limit=...\)`"),
        (lambda: DirectDrive(limit=5.0), "must be an array of shape"),
    ],
)
def test_a_drive_that_cannot_be_is_refused(make, says):
    with pytest.raises(ValueError, match=says):
        make()

"""Laws of the gallery, of a motor, of a cart-pole and of an arm, each in its computer."""

from functools import cache

import numpy as np

import workbench as wb
from docs import loops
from studies.paper.laws import rival
from workbench.core import SampledSystem


def gallery():
    """The names of the loops of the gallery."""
    return (*loops.ARMS, *loops.PLANTS)


def digital(name, delay=True):
    """A loop of the gallery in a computer, and its law with the truths that its observer uses as inputs."""
    shown = loops.gallery_loop(name)
    loop = shown.loop
    if isinstance(loop, SampledSystem):
        return loop, loop.law()
    arm = "tau" in loop.plant.inputs
    sampled = loop.digital(1e-3 if arm else 4 * shown.h, delay=delay)
    return sampled, sampled.law(truths=tuple(name for name in loop.plant.truths.names if name in loop.observer.reads))


@cache
def motor_law(**numbers):
    """The law of a motor within limits."""
    motor = wb.DCMotor()
    gains = {"Kp": 100.0, "Ki": 200.0, "Kd": 10.0, "low": -24.0, "high": 24.0} | numbers
    law = wb.PID(motor.outputs, motor.inputs, **gains)
    return wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0)).digital(0.01)


@cache
def kalman_law(observer=wb.ExtendedKalmanFilter):
    """The README's law of a cart-pole, behind a Kalman filter for equations that are not linear."""
    plant, period = wb.CartPole(phi=0.1), 0.01
    upright = wb.linearize(wb.open_loop(plant), t=0.0, x=np.zeros(4), at_rest=True)
    gain = wb.lqr(upright, Q=np.diag([5000.0, 0.0, 100.0, 0.0]), R=[[1.0]]).K
    W, V = np.diag([0.0, 1e-2, 0.0, 1e-2]), 1e-6 * np.eye(2)
    filter_ = observer(plant, W, V, P=1e-2 * np.eye(4), period=period)
    loop = wb.ClosedLoop(
        plant, filter_, wb.StateFeedback.of(plant, gain, follow=("x",)), wb.Step("x", "m", 0.2, time=2.0)
    )
    noise = wb.Instruments.of(plant, noise={"x": 1e-3, "phi": 1e-3}, limit={"F": (-10.0, 10.0)})
    return loop.digital(period, noise, delay=True)


def arm_law():
    """A sliding mode law of an arm, behind instruments that are noisy and coarse."""
    loop = rival("FS", "SMC")
    gauges = wb.Instruments.of(loop.plant, noise={"q": 1e-4}, quantum={"q": 1e-4}, limit={"tau": (-80.0, 80.0)})
    return loop.digital(1e-3, gauges, delay=True)

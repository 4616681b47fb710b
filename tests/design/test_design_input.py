"""What the design room is given by mistake is refused in one sentence that names it."""

import numpy as np
import pytest

from workbench.arms.dynamics import Dynamics
from workbench.arms.laws import ArmPID
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observer_gains import Gains, certify, high_gain
from workbench.arms.observers import ArmFullState
from workbench.blocks.loop import ClosedLoop, open_loop
from workbench.blocks.signals import Constant
from workbench.design import linearize
from workbench.design.chattering import Relay
from workbench.design.linear import broken_loop, controllability
from workbench.design.riccati import dare

ARM = paper_arm()
ODE = open_loop(Manipulator(ARM, q=[0.0, 0.0]))
REST = np.zeros(4)
BOX = {"q": (-1.0, 1.0), "qd": (-1.0, 1.0)}


def cut():
    loop = ClosedLoop(
        Manipulator(ARM, q=[0.0, 0.0]),
        ArmFullState(2),
        ArmPID([50.0, 50.0], [0.0, 0.0], [10.0, 10.0]),
        Constant("q", "rad", [0.0, 0.0]),
    )
    ode = loop.cut()
    return broken_loop(ode, 0.0, ode.states.default)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (
            lambda: controllability(linearize(ODE, 0.0, REST), "tight"),
            r"tolerance=\.\.\.\)` must be a number; got 'tight'",
        ),
        (lambda: dare(object(), 1, 1, 1), r"`dare\(A, B, Q, R\)`: A must be a matrix of real numbers; got an `object`"),
        (lambda: Relay(5.0).gain(0.0), r"`gain\(a=...\)` must be a finite number beyond zero, at least 1e-100"),
        (lambda: high_gain(-1, 3.0, 2.0, 0.1), "must be a whole number of joints from 1 to 1000; got -1"),
        (
            lambda: certify(Dynamics.of(ARM), Gains(np.eye(2), np.eye(2)), None, 1.0),
            r"certify\(region=\.\.\.\)` must be a `Region`; got None",
        ),
    ],
)
def test_a_mistake_is_named(call, words):
    with pytest.raises((ValueError, LookupError), match=words):
        call()

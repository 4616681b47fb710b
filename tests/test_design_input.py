"""What the design room is given by mistake is refused in one sentence that names it."""

import numpy as np
import pytest

from workbench.controllers import PID
from workbench.core import Dynamics
from workbench.design import linearize, to_control
from workbench.design.linear import broken_loop, controllability, equilibria, one_loop, operating_point
from workbench.design.observer_gains import Gains, by_poles, certify, high_gain
from workbench.loop import ClosedLoop, open_loop
from workbench.observers import FullState
from workbench.plants import Manipulator
from workbench.robots import paper_arm
from workbench.signals import Hold

ARM = paper_arm()
ODE = open_loop(Manipulator(ARM, q=[0.0, 0.0]))
REST = np.zeros(4)
BOX = {"q": (-1.0, 1.0), "qd": (-1.0, 1.0)}


def cut():
    loop = ClosedLoop(
        Manipulator(ARM, q=[0.0, 0.0]), FullState(2), PID([50.0, 50.0], [0.0, 0.0], [10.0, 10.0]), Hold([0.0, 0.0])
    )
    ode = loop.broken()
    return broken_loop(ode, 0.0, ode.states.default)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: to_control(None), "`ode` must be an `Ode`; got None"),
        (lambda: linearize("arm", 0.0, REST), "`ode` must be an `Ode`; got 'arm'"),
        (lambda: equilibria(None, BOX), "`ode` must be an `Ode`"),
        (lambda: equilibria(ODE, BOX, boxes="a"), r"boxes=\.\.\.\)` must be a whole number of boxes.*got 'a'"),
        (lambda: operating_point(ODE, None), r"wanted=\.\.\.\)` must be a `Mapping`; got None"),
        (lambda: controllability(linearize(ODE, 0.0, REST), "tight"), "must be between rounding.*got 'tight'"),
        (lambda: one_loop(cut(), 0.0), r"counts from 0 to 1; got 0\.0"),
        (lambda: by_poles(2.5, -3.0, -3.0), r"must be a positive whole number of joints; got 2\.5"),
        (lambda: by_poles(2, "a", -3.0), "needs two real poles or a conjugate pair; got 'a'"),
        (lambda: high_gain(-1, 3.0, 2.0, 0.1), "must be a positive whole number of joints; got -1"),
        (
            lambda: certify(Dynamics.of(ARM), Gains(np.eye(2), np.eye(2)), None, 1.0),
            r"certify\(region=\.\.\.\)` must be a `Region`; got None",
        ),
    ],
)
def test_a_mistake_is_named(call, words):
    with pytest.raises((ValueError, LookupError), match=words):
        call()

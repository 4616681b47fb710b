"""What the design room is given by mistake is refused in one sentence that names it."""

import numpy as np
import pytest

from workbench.arms.dynamics import Dynamics
from workbench.arms.laws import PID
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observer_gains import Gains, by_poles, certify, high_gain
from workbench.arms.observers import FullState
from workbench.blocks.loop import ClosedLoop, open_loop
from workbench.blocks.signals import Hold
from workbench.design import linearize, to_control
from workbench.design.chattering import BoundaryLayer, Relay
from workbench.design.linear import broken_loop, controllability, equilibria, freeze, one_loop, operating_point
from workbench.design.riccati import dare, lqe, lqr

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
        (lambda: to_control(None), r"`to_control\(ode=...\)` must be an `Ode`; got None"),
        (lambda: linearize("arm", 0.0, REST), r"`linearize\(ode=...\)` must be an `Ode` or a `Sampled`; got 'arm'"),
        (lambda: equilibria(None, BOX), r"`equilibria\(ode=...\)` must be an `Ode`"),
        (lambda: equilibria(ODE, BOX, boxes="a"), r"boxes=\.\.\.\)` must be a whole number; got 'a'"),
        (lambda: operating_point(ODE, None), r"wanted=\.\.\.\)` must be a mapping .*; got None"),
        (
            lambda: controllability(linearize(ODE, 0.0, REST), "tight"),
            r"tolerance=\.\.\.\)` must be a number; got 'tight'",
        ),
        (lambda: one_loop(cut(), 0.0), r"place=\.\.\.\)` must be a whole number; got 0\.0"),
        (lambda: by_poles(2.5, -3.0, -3.0), r"joints=\.\.\.\)` must be a whole number; got 2\.5"),
        (lambda: by_poles(2, "a", -3.0), r"first=\.\.\.\)` must be a number or a `complex`; got 'a'"),
        (lambda: freeze("arm", ("q",)), r"`freeze\(ode=...\)` must be an `Ode`; got 'arm'"),
        (lambda: lqr(1, 1, 1, 1, discrete=np.nan), r"`lqr\(discrete=...\)` must be True or False; got nan"),
        (lambda: lqe(1, 1, 1, 1, 1, discrete="no"), r"`lqe\(discrete=...\)` must be True or False; got 'no'"),
        (lambda: dare(object(), 1, 1, 1), r"`dare\(A, B, Q, R\)`: A must be a matrix of real numbers; got an `object`"),
        (lambda: Relay(5.0).gain(0.0), r"`gain\(a=...\)` must be a finite number beyond zero, at least 1e-100"),
        (lambda: BoundaryLayer(5.0, 0.1).slope("x"), r"slope\(a=...\)` must be a number; got 'x'"),
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

"""The equations that a2 asks: the observer alone, the filter (24) alone, and the loops of the laws."""

from dataclasses import replace
from functools import cache
from typing import Any

import casadi as ca
import numpy as np

from studies.paper.card import CARD
from studies.paper.laws import ARM, paper_observer, plant, proposed_as_printed, proposed_repaired, rival
from workbench.controllers import PID
from workbench.core import AbstractArm, Ode, Signals, lift
from workbench.loop import AbstractObserver, ClosedLoop
from workbench.observers import FullState, Luenberger, OracleFilter, PrintedFilter, WithDisturbance
from workbench.plants import Manipulator
from workbench.signals import Hold, SineTorque

I = np.eye(2)
CONSTANT_D = (0.5, 0.4)  # N m, the amplitudes of section 5, held


def beside_rest(L1: Any, L2: Any, zero: str = "down") -> Ode:
    """Observer (10) beside the arm at rest at q = 0, hanging (`down`) or upright (`up`), where no torque is needed."""
    observer = Luenberger(replace(ARM, zero=zero), L1, L2, q_hat=np.zeros(2))
    lifted, states = lift(observer), observer.memory
    t, x = ca.SX.sym("t"), states.symbols()
    z, zero_q = states.view(x), ca.SX.zeros(2)
    y = Signals(q=zero_q, qd=zero_q)
    rates = lifted.block.rate(t, z, y, lifted.block.estimate(t, z, y), Signals(tau=ca.SX.zeros(2)))
    errors = {"q_error": -z["q_hat"], "qd_error": -z["qd_hat"]}
    return Ode.of("observer (10) beside the arm at rest", states, lifted.layout, (t, x, lifted.symbols), rates, errors)


@cache
def free_arm() -> Ode:
    """The arm without torque and disturbance, watched by (10) with the gains of section 5."""
    rest = np.zeros(2)
    loop = ClosedLoop(Manipulator(ARM, q=rest), paper_observer(), PID(rest, rest, rest), Hold(rest))
    return loop.ode("arm without torque, watched by (10)")


def filter_24(kind: type[PrintedFilter] | type[OracleFilter]) -> Ode:
    """(24) alone, as printed or repaired, fed by D = delta sin(omega t + theta) with the numbers of FS."""
    block, D = kind(2, CARD["l"]), plant("FS").disturbance
    filter_, torque = lift(block), lift(D, "disturbance.")
    t, x = ca.SX.sym("t"), block.memory.symbols()
    z, zero = block.memory.view(x), ca.SX.zeros(2)
    d = torque.block.at(t)
    y, est = Signals(q=zero, qd=zero, d=d), Signals(q=zero, qd=zero, d=zero)
    d_hat = filter_.block.estimate(t, z, y, est)
    return Ode.of(
        f"(24), {kind.__name__}",
        block.memory,
        filter_.layout + torque.layout,
        (t, x, ca.vertcat(filter_.symbols, torque.symbols)),
        filter_.block.rate(t, z, y, est, Signals()),
        {"d": d, "d_hat": d_hat, "d_error": d - d_hat},
    )


def observed(disturbance: AbstractObserver) -> Ode:
    """SMC in the first scenario, beside the true state and an observer of D that starts at D_hat = 0."""
    observer = WithDisturbance(FullState(2), disturbance)
    return replace(rival("FS", "SMC"), observer=observer).ode("SMC, first scenario")


def regulation() -> ClosedLoop:
    """The repaired law at a constant reference, under a constant disturbance: as plain as Assumption 4 allows."""
    D = SineTorque(CONSTANT_D, np.zeros(2), np.full(2, np.pi / 2))
    at_rest = Manipulator(ARM, q=np.zeros(2), disturbance=D)
    return replace(proposed_repaired("FS"), plant=at_rest, reference=Hold(np.zeros(2)))


def printed_but_for_c() -> ClosedLoop:
    """The law as printed in the first scenario on the derived arm, whose C obeys Assumption 3, in law and observer."""
    loop = proposed_as_printed("FS")
    state = replace(loop.observer.state, model=ARM)
    return replace(loop, controller=replace(loop.controller, model=ARM), observer=replace(loop.observer, state=state))


def on_path() -> ClosedLoop:
    """The law as printed but for C where its estimates obey (35) and start on the desired path of the first scenario.

    (35) is (1) with the estimates for q and qd, so that is the arm itself, known exactly.
    """
    loop = printed_but_for_c()
    arm = replace(loop.plant, q=np.zeros(2), qd=np.array([2.0, 1.5]))  # q_d(0), qd_d(0)
    return replace(loop, plant=arm, observer=replace(loop.observer, state=FullState(2)))


def with_weights(loop: ClosedLoop, Q: float, R: float) -> ClosedLoop:
    """The same loop with the weights Q I and R I in (34)."""
    return replace(loop, controller=replace(loop.controller, Q=Q * I, R=R * I))


def observer_rate(model: AbstractArm, q: ca.SX, qd_hat: ca.SX, tau: ca.SX) -> ca.SX:
    """qd_hat' of the observer (10), with the gains of section 5, where its position is right: q_hat = q."""
    observer, t = replace(paper_observer(), model=model), ca.SX(0)
    z, y = {"q_hat": q, "qd_hat": qd_hat}, Signals(q=q, qd=ca.SX.zeros(2))
    return observer.rate(t, z, y, observer.estimate(t, z, y), Signals(tau=tau))["qd_hat"]

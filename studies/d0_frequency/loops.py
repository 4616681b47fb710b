"""The paper's arm at rest under six laws: its poses, its computers, and its linear loops there."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

import workbench as wb
from studies.paper.card import CARD as PAPER
from studies.paper.card import LAWS, PROPOSED_LAW
from studies.paper.linearization import HELD_STATES, LEVEL, POSES, holding_torque, still

CARD = wb.provenance.Card(
    (
        wb.provenance.assumed_entry(
            "short period", 2.5e-4, "s", "the period at which report b4 exports the law", 1e-4, 5e-4
        ),
        wb.provenance.assumed_entry(
            "long period", 1e-3, "s", "a usual rate of robot controllers, 1 kHz, as in a9", 5e-4, 4e-3
        ),
        wb.provenance.assumed_entry(
            "delay", "one period", "", "the torque is computed while the one before acts, as in a9"
        ),
        wb.provenance.assumed_entry(
            "small start", 1e-5, "rad", "s = 60 µrad/s, far within the layer of 0.01 rad/s", 1e-7, 1e-3
        ),
        wb.provenance.assumed_entry("large start", 0.3, "rad", "s = 1.8 rad/s, far outside of the layer", 0.01, 1.0),
    )
)
ARM_POSES: dict[str, tuple[float, ...]] = {
    "hanging": POSES["hanging"],
    LEVEL: POSES[LEVEL],
    "end of FS": tuple(PAPER["FS: reference amplitude"]),
    "start of FS": tuple(PAPER["FS: q(0)"]),
    "extended": (np.pi / 2, 0.0),
    "upright": POSES["upright"],
}
SHORT, LONG = float(CARD["short period"]), float(CARD["long period"])
COMPUTERS = {f"{1e3 * T:g} ms": T for T in (SHORT, LONG)}
CONTINUOUS = "continuous time"
SUBSTEP = 2.5e-3  # s, the longest step of the plant between two instants of a computer, as in a9
DRAWN_LAWS = (PROPOSED_LAW, "RBF-ASMC", "PID", "SMC")
ALIKE = ("ASMC", "Fuzzy-ASMC")  # with the first gain held they have the linear part of SMC
LAYER_LAWS = tuple(law for law in LAWS if law != "PID")


@dataclass(frozen=True)
class AtPose:
    """A law at one of the poses."""

    law: str
    pose: str


EVERY = tuple(AtPose(law, pose) for law in LAWS for pose in ARM_POSES)
RUN_POSES = (LEVEL, "start of FS", "extended")  # M of all others is that of one of these, or near to it
RUNS = tuple(AtPose(law, pose) for law in LAWS for pose in RUN_POSES)


def substeps(period: float) -> int:
    """The number of Runge-Kutta steps of the plant in a period in s."""
    return int(np.ceil(period / SUBSTEP - 1e-9))


def loop_at_rest(one: AtPose) -> wb.ClosedLoop:
    """The loop of a law that holds a pose, undisturbed, started where it rests."""
    return still(one.law, ARM_POSES[one.pose])


def digital(one: AtPose, period: float) -> wb.DigitalLoop:
    """The same in a computer whose torque acts one period late; the torque that rest needs waits already."""
    return wb.DigitalLoop(
        loop_at_rest(one), period, delay=True, initial_commands={"tau": holding_torque(ARM_POSES[one.pose])}
    )


def linear(
    one: AtPose, period: float | None = None, at: str | None = None, K: wb.Array | None = None
) -> wb.linear_loops.LinearLoop:
    """The linear loop at rest, its adapting gains held: at K(0), or at K; in continuous time or in a computer."""
    loop: Any = loop_at_rest(one) if period is None else digital(one, period)
    values = None if K is None else {"controller.K": K}
    steps = None if period is None else substeps(period)
    return wb.linear_loop(loop, at, values, freeze=HELD_STATES.get(one.law, ()), substeps=steps)


def start_states(equation: wb.Ode | wb.SampledSystem, one: AtPose, offsets: wb.Array) -> wb.Array:
    """States (N, nx) at rest, but for the positions of both joints, which are off by each of `offsets` (N,) in rad.

    An observer starts with the true positions. The integral of PID holds the arm.
    """
    layout = equation.states
    x = np.tile(layout.default, (len(offsets), 1))
    for name in ("plant.q", "observer.state.q_hat"):
        if name in layout:
            x[:, layout.slice(name)] += offsets[:, np.newaxis]
    if one.law == "PID":
        x[:, layout.slice("controller.integral")] = -holding_torque(ARM_POSES[one.pose]) / PAPER["PID: Ki"]
    return x


def step_of_reference(law: str, size: float) -> wb.ClosedLoop:
    """The loop of a law that hangs at rest and is to hold both joints at `size` rad from t = 0 on."""
    loop = still(law, (size, size))
    plant: Any = loop.plant
    loop = replace(loop, plant=replace(plant, q=np.zeros(2)))
    if law == PROPOSED_LAW:
        observer: Any = loop.observer
        loop = replace(loop, observer=replace(observer, state=replace(observer.state, q_hat=np.zeros(2))))
    return loop

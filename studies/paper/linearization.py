"""The linearization of each law's loop, cut at the torque: at rest, and along the first scenario."""

from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import casadi as ca
import numpy as np

import workbench as wb
from studies.paper.card import CARD, LAWS, PROPOSED_LAW
from studies.paper.laws import ARM, proposed_repaired, rival

SEVEN = (*LAWS, "super-twisting")
HELD_STATES: dict[str, tuple[str, ...]] = {
    **dict.fromkeys(("ASMC", "Fuzzy-ASMC", "RBF-ASMC"), ("controller.K",)),
    PROPOSED_LAW: ("controller.K", "controller.P"),
}
POSES = {
    "hanging": (0.0, 0.0),
    "folded down": (0.0, np.pi),
    "folded up": (np.pi, np.pi),
    "upright": (np.pi, 0.0),
    "level of SS": tuple(CARD["SS: a1, a2"]),
}
LEVEL = "level of SS"
SLOW = 1e-3  # rad/s
FINE, COARSE = 10, 100  # every which kept state, of one in 10 ms, has its poles taken, and its margin


@dataclass(frozen=True, eq=False)
class AtRest:
    """A loop at rest: A, B and Cy of L, the poles once closed, and the margins; None with the reason if there are none.

    `slow_gain` is the largest singular value of S at the frequency `SLOW`.
    """

    A: wb.Array
    B: wb.Array
    Cy: wb.Array
    poles: tuple[wb.linear.Pole, ...]
    slow_gain: float
    channels: tuple[wb.linear.LoopMargins, ...] = ()
    disk: wb.linear.DiskMargin | None = None
    why: str = ""

    @property
    def alpha(self) -> float:
        """The disk margin; 0 where there is none."""
        return self.disk.alpha if self.disk else 0.0

    @property
    def delay(self) -> float:
        """The delay that the loop stands at either torque, in ms."""
        return 1e3 * min((m.delay for m in self.channels), default=0.0)


@cache
def loop_of(law: str, scenario: str = "FS") -> wb.ClosedLoop:
    """The loop of a law as in a1."""
    return proposed_repaired(scenario) if law == PROPOSED_LAW else rival(scenario, law)


def still(law: str, pose: tuple[float, ...]) -> wb.ClosedLoop:
    """The same loop at rest at a pose that it holds, undisturbed."""
    loop, q = loop_of(law), np.array(pose)
    loop = replace(loop, plant=wb.Manipulator(ARM, q=q, qd=np.zeros(2)), reference=wb.Constant("q", "rad", q))
    if law == PROPOSED_LAW:
        state = wb.arms.observers.Luenberger(ARM, CARD["L1"], CARD["L2"], q, np.zeros(2))
        loop = replace(loop, observer=replace(loop.observer, state=state))
    return loop


def cut(loop: wb.ClosedLoop, law: str) -> wb.Ode:
    """The loop cut at the torque, with the gains that adapt held."""
    ode = loop.cut(law)
    return wb.linear.freeze(ode, HELD_STATES[law]) if law in HELD_STATES else ode


def loop_at_rest(law: str, pose: str = LEVEL, K: tuple[float, ...] | None = None, stiffer: float = 1.0) -> Any:
    """L at rest at a pose, a `StateSpace`: the adaptive gain at K(0) or at K, L2 of the observer so much stiffer."""
    ode = cut(still(law, POSES[pose]), law)
    values: dict[str, Any] = {"drive": holding_torque(POSES[pose])}
    if K is not None:
        values["controller.K"] = np.reshape(K, ode.parameters["controller.K"].shape)
    if stiffer != 1.0:
        values["observer.state.L2"] = stiffer * CARD["L2"]
    x = ode.states.default.copy()
    if law == "PID":  # its integral holds the arm
        x[ode.states.slice("controller.integral")] = -values["drive"] / CARD["PID: Ki"]
    return wb.linear.broken_loop(ode, 0.0, x, ode.parameters.pack(values)[0])


def at_rest(law: str, pose: str = LEVEL, K: tuple[float, ...] | None = None, stiffer: float = 1.0) -> AtRest:
    """The poles and margins of `loop_at_rest`."""
    loop = loop_at_rest(law, pose, K, stiffer)
    S = wb.linear.sensitivity(loop)
    slow_gain = float(np.linalg.norm(np.asarray(S(1j * SLOW)), 2))
    found = AtRest(loop.A, loop.B, loop.C, wb.linear.poles(S), slow_gain)
    try:
        return replace(found, channels=wb.linear.loop_margins(loop), disk=wb.linear.disk_margin(loop))
    except ValueError as none:
        return replace(found, why=str(none))


def holding_torque(pose: tuple[float, ...]) -> wb.Array:
    """The torque that holds the arm at a pose, (n,), in N m."""
    return np.array(ca.DM(ARM.gravity_vector(ca.SX(ca.DM(pose))))).ravel()


@dataclass(frozen=True, eq=False)
class Motion:
    """The states (N, nx) and torques (N, 2) of a law along its run in the first scenario, at times t (N,).

    `inside` (N,) is True within the layer, where all |s_i| < phi, and always for PID, which has none.
    """

    law: str
    t: wb.Array
    x: wb.Array
    tau: wb.Array
    inside: wb.Array


def motion(outcome: wb.study.Outcome) -> Motion:
    """The run of an outcome."""
    law, run = outcome.case.law, outcome.measurement.trajectories
    inside = np.ones(len(run.t), dtype=bool) if law == "PID" else (np.abs(run["s"][0]) < CARD["phi"]).all(axis=1)
    ode = outcome.ode
    if not isinstance(ode, wb.Ode):
        raise TypeError("The motion of a law is that of its loop in continuous time.")
    return Motion(law, run.t, states(outcome, ode), run["tau"][0], inside)


@dataclass(frozen=True, eq=False)
class OnPath:
    """The frozen poles of a whole loop along its run: their `largest` and `least` real parts at times t, in 1/s.

    At `sparse` times there is the disk margin `alpha`, NaN outside of the layer and where the loop has none. Of all
    times `share` is the part within the layer, and `within` the largest real part of a pole there.
    """

    t: wb.Array
    largest: wb.Array
    least: wb.Array
    sparse: wb.Array
    alpha: wb.Array
    share: float
    within: float


def on_path(run: Motion) -> OnPath:
    """The linear models of a loop along its run.

    A disk margin is asked for within the layer: outside of it the slope of the saturation is zero.
    """
    ode, t, inside = loop_of(run.law).ode(), run.t, run.inside
    chosen = np.flatnonzero(inside & (np.arange(len(t)) % COARSE == 0))
    alpha = np.full(len(t), np.nan)
    alpha[chosen] = _margins(cut(loop_of(run.law), run.law), ode, t[chosen], run.x[chosen], run.tau[chosen])
    real = wb.linear.along(ode, t[::FINE], run.x[::FINE]).eigenvalues().real
    largest = real.max(axis=1)
    return OnPath(
        *(t[::FINE], largest, real.min(axis=1), t[::COARSE], alpha[::COARSE]),
        *(float(inside.mean()), float(largest[inside[::FINE]].max())),
    )


def _margins(broken: wb.Ode, ode: wb.Ode, t: wb.Array, x: wb.Array, tau: wb.Array) -> wb.Array:
    """The disk margins of the loop frozen at each time; NaN where it is unstable."""
    values = ode.states.unpack(x) | {"drive": tau}
    rows = broken.parameters.pack({name: value for name, value in values.items() if name in broken.parameters})
    left = [ode.states.slice(entry.name) for entry in broken.states.entries]
    path = wb.linear.along(broken, t, np.concatenate([x[:, place] for place in left], axis=1), rows)
    alphas = []
    for loop in wb.linear.broken_loops(path):
        try:
            alphas.append(wb.linear.disk_margin(loop).alpha)
        except ValueError:
            alphas.append(np.nan)
    return np.array(alphas)


def states(outcome: wb.study.Outcome, ode: wb.Ode) -> wb.Array:
    """The states (N, nx) of a run, as its equation orders them."""
    run = outcome.measurement.trajectories
    parts = (run[entry.name][0] for entry in ode.states.entries)
    return np.concatenate([np.swapaxes(part, -1, 1).reshape(len(run.t), -1) for part in parts], axis=1)

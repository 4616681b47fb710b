"""The six loops of b4, each with the computer that its law is handed to: period, delay, instruments and limits."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import casadi as ca
import numpy as np

from studies.paper.card import CARD as PAPER
from studies.paper.card import PROPOSED
from studies.paper.laws import ARM, plant, proposed_repaired, rival
from workbench.controllers import LinearLaw, Regulator
from workbench.core import LinearSystem, Sampled
from workbench.design.linear import linearize, operating_point
from workbench.design.riccati import lqg, lqr
from workbench.loop import ClosedLoop, DigitalLoop, Instruments, open_loop
from workbench.metrics import AbstractMetric, total_variation
from workbench.metrics.contract import Integral
from workbench.metrics.signal_choice import Choice
from workbench.observers import ExtendedKalmanFilter, FullState, MomentumObserver, WithDisturbance
from workbench.plants import CartPole, Manipulator
from workbench.signals import Hold, Sines
from workbench.study.provenance import Card, assumed

CARD = Card(
    (
        assumed(
            "period of sliding laws", 2.5e-4, "s", "4 kHz: a9 finds SMC quiet to 0.33 ms, a period late", 1e-4, 1e-3
        ),
        assumed("period of the arm", 1e-3, "s", "1 kHz, a usual rate of robot controllers, as in a9", 2.5e-4, 4e-3),
        assumed("period of the cart", 1e-2, "s", "100 Hz, as in the README", 2e-3, 2e-2),
        assumed("steps of q", 2 * np.pi / 2**16, "rad", "an encoder of 16 bits on each joint, as in a9", 1e-6, 1e-3),
        assumed("steps of qd", 1e-3, "rad/s", "a filtered difference, in fixed point, as in a9", 0.0, 1e-2),
        assumed("steps of x", 1e-4, "m", "an encoder of 0.1 mm", 1e-6, 1e-3),
        assumed("steps of phi", 2 * np.pi / 2**14, "rad", "an encoder of 14 bits", 1e-6, 1e-2),
        assumed("limit of tau", 150.0, "N m", "above what any law asks for after the first instants", 50.0, 500.0),
        assumed("limit of F", 10.0, "N", "as in the README", 5.0, 50.0),
    )
)
PERIODS = 10_000  # of a replay; set it to a million for the figures that a release states
SETTLED = 0.25  # the part of a run after which errors count, so that they are none of the approach
ERROR, TV = "RMSE, settled", "TV"
SMC, TWISTING, PID, LQG, EKF = "SMC", "super-twisting", "PID", "LQG", "EKF and LQR"
POSE = (0.5, -0.5)  # rad, where LQG holds the arm
SEED = 29


def settled_rmse(signal: str | None, start: float) -> Integral:
    """sqrt(1 / (T - start) integral of e^2 dt), from `start` in s to the horizon T."""

    def g(t: ca.SX, e: ca.SX) -> ca.SX:
        return ca.if_else(t >= start, e**2, 0)

    def root(integral: Any, horizon: float) -> Any:
        return np.sqrt(np.maximum(integral, 0) / (horizon - start))

    about = f"the root of the mean square from {start:g} s on"
    return Integral(ERROR, "", about, g, root, signal=Choice("error", signal), measure=str)


@dataclass(frozen=True, eq=False)
class Handed:
    """A loop and its computer; `made` gives the loop for a period in s, as filters know theirs."""

    name: str
    made: Callable[[float], ClosedLoop]
    period: float
    until: float  # s
    quantum: Mapping[str, float]
    limit: Mapping[str, tuple[float, float]]
    follows: str  # the output whose error counts
    given: str  # to the law, in words

    @property
    def key(self) -> str:
        """The name in lower case with underscores."""
        return "".join(c if c.isalnum() else "_" for c in self.name.lower())

    @property
    def metrics(self) -> tuple[AbstractMetric, ...]:
        """The error after the approach, and the total variation of the commands at the instants of the computer."""
        return (settled_rmse(self.follows, SETTLED * self.until), total_variation(self.period))

    def instruments(self, quantum: Mapping[str, float] | None = None) -> Instruments:
        """Its instruments, with steps of their own if told."""
        loop = self.made(self.period)
        return Instruments.of(loop.plant, quantum=self.quantum if quantum is None else quantum, limit=self.limit)

    def computed(self, period: float | None = None, delay: float = 1, *, exact: bool = False) -> DigitalLoop:
        """The loop in its computer, or in one with another period and delay, or with exact readings."""
        length = self.period if period is None else period
        return DigitalLoop(self.made(length), length, self.instruments({} if exact else None), delay)

    def digital(self, *, exact: bool = False) -> Sampled:
        """The loop as its computer runs it, or one with exact readings."""
        return self.computed(exact=exact).ode(self.name)


def arm(name: str, made: Callable[[float], ClosedLoop], given: str, period: str = "period of the arm") -> Handed:
    """A law of the arm in its computer."""
    most = float(CARD["limit of tau"])
    steps = {name: float(CARD[f"steps of {name}"]) for name in ("q", "qd")}
    return Handed(name, made, float(CARD[period]), 10.0, steps, {"tau": (-most, most)}, "q", given)


def on_reference(loop: ClosedLoop) -> ClosedLoop:
    """The loop of the first scenario whose arm starts where it is wanted, as a machine is driven there before."""
    speed = np.multiply(PAPER["FS: reference amplitude"], PAPER["FS: reference frequency"])
    return replace(loop, plant=replace(loop.plant, q=np.zeros(2), qd=speed))


def rival_of(law: str) -> Callable[[float], ClosedLoop]:
    """A law of the paper by its name."""
    return lambda period: on_reference(rival("FS", law))


def proposed(period: float) -> ClosedLoop:
    """AOSMC-RGS, repaired, on readings of q and qd; an observer of the momentum stands for the true disturbance."""
    observer = WithDisturbance(FullState(2), MomentumObserver(ARM, PAPER["l"]))
    return on_reference(proposed_repaired("FS", observer))


def arm_lqg(period: float) -> ClosedLoop:
    """LQG that holds the arm at a pose under the disturbance of the first scenario, designed for the period."""
    opened = open_loop(Manipulator(ARM, q=POSE))
    point = operating_point(opened, {"q": POSE, "qd": (0.0, 0.0)})
    model = linearize(opened, 0.0, point.x, u=point.u, at_rest=True).sample(period)
    costs = np.diag([1 / 0.05**2] * 2 + [0.0] * 2), np.diag([1 / 20.0**2] * 2)
    driven, heard = 0.5**2 * np.eye(2), np.diag([1e-4**2] * 2 + [1e-3**2] * 2)
    design = lqg(model, *costs, driven, heard, G=model.B)
    names = {"inputs": model.output_labels, "outputs": model.input_labels}
    turned = LinearSystem.of(-design.controller, **names)  # it is given the error, and has its own sign for y inside
    law = LinearLaw(turned, error=True, u0=point.u)
    body = Manipulator(ARM, q=np.add(POSE, 0.1), qd=(0.0, 0.0), disturbance=plant("FS").disturbance)
    return ClosedLoop(body, FullState(2), law, Hold(POSE))


def cart_pole(period: float) -> ClosedLoop:
    """The cart-pole of the README behind its extended Kalman filter; the cart follows a sine."""
    body = CartPole(phi=0.1)
    upright = linearize(open_loop(body), 0.0, np.zeros(4), at_rest=True)
    gain = lqr(upright, np.diag([5000.0, 0.0, 100.0, 0.0]), [[1.0]]).K
    W, V = np.diag([0.0, 1e-2, 0.0, 1e-2]), 1e-6 * np.eye(2)
    kalman = ExtendedKalmanFilter(body, W, V, P=1e-2 * np.eye(4), period=period)
    sine = Sines([0.2], [1.0], signal="x", unit="m")
    return ClosedLoop(body, kalman, Regulator.of(body, gain, follow=("x",)), sine)


def by_key(key: str) -> Handed:
    """The loop of a key."""
    return next(one for one in handed() if one.key == key)


@cache
def handed() -> tuple[Handed, ...]:
    """The six of them."""
    both, fast = "positions and velocities", "period of sliding laws"
    cart = Handed(
        EKF,
        cart_pole,
        float(CARD["period of the cart"]),
        20.0,
        {name: float(CARD[f"steps of {name}"]) for name in ("x", "phi")},
        {"F": (-float(CARD["limit of F"]), float(CARD["limit of F"]))},
        "x",
        "position and angle, exact model",
    )
    return (
        arm(PROPOSED, proposed, f"{both}, exact model, D by an observer", fast),
        arm(SMC, rival_of(SMC), f"{both}, exact model", fast),
        arm(TWISTING, rival_of(TWISTING), f"{both}, exact model"),
        arm(PID, rival_of(PID), f"{both}, no model"),
        arm(LQG, arm_lqg, f"{both}, the linear model at the pose"),
        cart,
    )

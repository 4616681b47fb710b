"""The six loops of b4, each with the computer that its law is handed to: period, delay, instruments and limits."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Any

import casadi as ca
import numpy as np

import workbench as wb
from studies.paper.card import PROPOSED_LAW
from studies.paper.laws import ARM, plant, rival
from studies.paper.quiet_periods import HANDED_OVER, momentum_loop, on_reference

CARD = wb.provenance.Card(
    (
        wb.provenance.assumed_entry(
            "period of sliding laws",
            HANDED_OVER,
            "s",
            "4 kHz: shorter than the longest quiet period of a9 from the near start, with commands a period late",
            1e-4,
            1e-3,
        ),
        wb.provenance.assumed_entry(
            "period of the arm", 1e-3, "s", "1 kHz, a usual rate of robot controllers, as in a9", 2.5e-4, 4e-3
        ),
        wb.provenance.assumed_entry("period of the cart", 1e-2, "s", "100 Hz, as in the README", 2e-3, 2e-2),
        wb.provenance.assumed_entry(
            "steps of q", 2 * np.pi / 2**16, "rad", "an encoder of 16 bits on each joint, as in a9", 1e-6, 1e-3
        ),
        wb.provenance.assumed_entry(
            "steps of qd", 1e-3, "rad/s", "a filtered difference, in fixed point, as in a9", 0.0, 1e-2
        ),
        wb.provenance.assumed_entry("steps of x", 1e-4, "m", "an encoder of 0.1 mm", 1e-6, 1e-3),
        wb.provenance.assumed_entry("steps of phi", 2 * np.pi / 2**14, "rad", "an encoder of 14 bits", 1e-6, 1e-2),
        wb.provenance.assumed_entry(
            "limit of tau", 150.0, "N m", "above what any law asks for after the first instants", 50.0, 500.0
        ),
        wb.provenance.assumed_entry("limit of F", 10.0, "N", "as in the README", 5.0, 50.0),
    )
)
PERIODS = 10_000  # of a replay; set it to a million for the figures that a release states
TRANSIENT_SHARE = 0.25  # the part of a run after which the settled errors count, so that they leave out the approach
ERROR, SIZE, WHOLE, TV = "settled RMSE", "settled mean |e|", "RMSE of the whole run", "TV"
STATISTICS = (ERROR, SIZE, WHOLE)
NEAR_START, FAR_START = "near", "far"
SMC, TWISTING, PID, LQG, EKF = "SMC", "super-twisting", "PID", "LQG", "EKF + LQR"
POSE = (0.5, -0.5)  # rad, where LQG holds the arm
FAR_POSE, FAR_ANGLE = 0.5, 0.2  # rad, of the far starts
SEED = 29


def settled_rmse(signal: str | None, start: float, name: str = ERROR) -> wb.metrics.Integral:
    """sqrt(1 / (T - start) integral of e^2 dt), from `start` in s to the horizon T."""

    def g(t: ca.SX, e: ca.SX) -> ca.SX:
        return ca.if_else(t >= start, e**2, 0)

    def root(integral: Any, horizon: float) -> Any:
        return np.sqrt(np.maximum(integral, 0) / (horizon - start))

    about = f"the root of the mean square from {start:g} s on"
    return wb.metrics.Integral(name, "", about, g, root, signal=wb.metrics.SignalChoice("error", signal), measure=str)


def settled_size(signal: str | None, start: float) -> wb.metrics.Integral:
    """1 / (T - start) integral of |e| dt, from `start` in s to the horizon T."""

    def g(t: ca.SX, e: ca.SX) -> ca.SX:
        return ca.if_else(t >= start, ca.fabs(e), 0)

    def mean(integral: Any, horizon: float) -> Any:
        return integral / (horizon - start)

    about = f"the mean size from {start:g} s on"
    return wb.metrics.Integral(SIZE, "", about, g, mean, signal=wb.metrics.SignalChoice("error", signal), measure=str)


def shown_card() -> wb.provenance.Card:
    """The card, with the period of the two laws that have it by their names: super-twisting slides, too, but slower."""
    shared = "period of sliding laws"
    label = f"period of {PROPOSED_LAW} and {SMC}"
    return wb.provenance.Card(tuple(replace(one, label=label) if one.name == shared else one for one in CARD))


@dataclass(frozen=True, eq=False)
class HandoverLoop:
    """A loop and its computer; `near` makes the loop for a period in s, since filters are designed for their period.

    `far` makes the same loop from the far start, and `starts` describes both starts in words.
    """

    name: str
    near: Callable[[float], wb.ClosedLoop]
    far: Callable[[float], wb.ClosedLoop]
    starts: tuple[str, str]
    period: float
    until: float  # s
    quantum: Mapping[str, float]
    limit: Mapping[str, tuple[float, float]]
    follows: str  # the output whose error counts
    information: str  # to the law, in words

    @property
    def key(self) -> str:
        """The name in lower case with underscores, a plus as "and"."""
        return "".join(c if c.isalnum() else "_" for c in self.name.lower().replace("+", "and"))

    @property
    def metrics(self) -> tuple[wb.metrics.AbstractMetric, ...]:
        """The error by three statistics, and the total variation of the commands at the instants of the computer."""
        late = TRANSIENT_SHARE * self.until
        errors = (settled_rmse(self.follows, late), settled_size(self.follows, late))
        return (*errors, settled_rmse(self.follows, 0.0, WHOLE), wb.total_variation(self.period))

    def computer_loop(
        self, period: float | None = None, delay: float = 1, *, exact: bool = False, start: str = NEAR_START
    ) -> wb.DigitalLoop:
        """The loop in its computer, or in one with another period and delay, with exact readings, or another start."""
        length = self.period if period is None else period
        loop = (self.near if start == NEAR_START else self.far)(length)
        instruments = wb.Instruments.of(loop.plant, quantum={} if exact else self.quantum, limit=self.limit)
        return wb.DigitalLoop(loop, length, instruments, delay)

    def digital(self, *, exact: bool = False, start: str = NEAR_START) -> wb.SampledSystem:
        """The loop as its computer runs it, or one with exact readings or another start."""
        return digital_of(self, exact, start)


@cache
def digital_of(one: HandoverLoop, exact: bool, start: str) -> wb.SampledSystem:
    """The loop as its computer runs it, built once for all sweeps that vary it."""
    return one.computer_loop(exact=exact, start=start).ode(one.name)


LoopMaker = Callable[[float], wb.ClosedLoop]


def arm(
    name: str, makers: tuple[LoopMaker, LoopMaker], information: str, starts: tuple[str, str], period: str
) -> HandoverLoop:
    """A law of the arm in its computer, with its loop from the near start and from the far one."""
    most = float(CARD["limit of tau"])
    steps = {name: float(CARD[f"steps of {name}"]) for name in ("q", "qd")}
    return HandoverLoop(
        name, *makers, starts, float(CARD[period]), 10.0, steps, {"tau": (-most, most)}, "q", information
    )


def rival_of(law: str) -> tuple[LoopMaker, LoopMaker]:
    """A law of the paper by its name, from a start on the reference and from the paper's."""
    return (lambda period: on_reference(rival("FS", law)), lambda period: rival("FS", law))


def proposed_law() -> tuple[LoopMaker, LoopMaker]:
    """AOSMC-RGS with an observer of the momentum, from a start on the reference and from the paper's."""
    return (lambda period: on_reference(momentum_loop()), lambda period: momentum_loop())


@cache
def arm_lqg(period: float, off: float = 0.1) -> wb.ClosedLoop:
    """LQG that holds the arm at a pose under the disturbance of the first scenario, designed for the period.

    Both joints start `off` rad from the pose.
    """
    opened = wb.open_loop(wb.Manipulator(ARM, q=POSE))
    point = wb.linear.operating_point(opened, {"q": POSE, "qd": (0.0, 0.0)})
    model = wb.linearize(opened, 0.0, point.x, u=point.u, at_rest=True).sample(period)
    costs = np.diag([1 / 0.05**2] * 2 + [0.0] * 2), np.diag([1 / 20.0**2] * 2)
    driven, heard = 0.5**2 * np.eye(2), np.diag([1e-4**2] * 2 + [1e-3**2] * 2)
    design = wb.lqg(model, *costs, driven, heard, G=model.B)
    names = {"inputs": model.output_labels, "outputs": model.input_labels}
    turned = wb.core.LinearSystem.of(
        -design.controller, **names
    )  # it is given the error, and has its own sign for y inside
    law = wb.LinearLaw(turned, error=True, u0=point.u)
    body = wb.Manipulator(ARM, q=np.add(POSE, off), qd=(0.0, 0.0), disturbance=plant("FS").disturbance)
    return wb.ClosedLoop(body, wb.ArmFullState(2), law, wb.Constant("q", "rad", POSE))


@cache
def cart_pole(period: float, phi: float = 0.1) -> wb.ClosedLoop:
    """The cart-pole of the README behind its extended Kalman filter; the cart follows a sine from a pole at `phi`."""
    body = wb.CartPole(phi=phi)
    upright = wb.linearize(wb.open_loop(body), 0.0, np.zeros(4), at_rest=True)
    gain = wb.lqr(upright, np.diag([5000.0, 0.0, 100.0, 0.0]), [[1.0]]).K
    W, V = np.diag([0.0, 1e-2, 0.0, 1e-2]), 1e-6 * np.eye(2)
    kalman = wb.ExtendedKalmanFilter(body, W, V, P=1e-2 * np.eye(4), period=period)
    sine = wb.Sines("x", "m", [0.2], [1.0])
    return wb.ClosedLoop(body, kalman, wb.StateFeedback.of(body, gain, follow=("x",)), sine)


def by_key(key: str) -> HandoverLoop:
    """The loop of a key."""
    return next(one for one in handover_loops() if one.key == key)


@cache
def handover_loops() -> tuple[HandoverLoop, ...]:
    """The six of them."""
    both, fast, slow = "positions and velocities", "period of sliding laws", "period of the arm"
    path = ("on the reference of the first scenario", "at the start that the paper states")
    pose = ("0.1 rad off the pose", f"{FAR_POSE:g} rad off the pose")
    cart = HandoverLoop(
        EKF,
        cart_pole,
        partial(cart_pole, phi=FAR_ANGLE),
        ("pole at 0.1 rad", f"pole at {FAR_ANGLE:g} rad"),
        float(CARD["period of the cart"]),
        20.0,
        {name: float(CARD[f"steps of {name}"]) for name in ("x", "phi")},
        {"F": (-float(CARD["limit of F"]), float(CARD["limit of F"]))},
        "x",
        "position and angle, exact model",
    )
    return (
        arm(PROPOSED_LAW, proposed_law(), f"{both}, exact model, D by an observer", path, fast),
        arm(SMC, rival_of(SMC), f"{both}, exact model", path, fast),
        arm(TWISTING, rival_of(TWISTING), f"{both}, exact model", path, slow),
        arm(PID, rival_of(PID), f"{both}, no model", path, slow),
        arm(LQG, (arm_lqg, partial(arm_lqg, off=FAR_POSE)), f"{both}, the linear model at the pose", pose, slow),
        cart,
    )

"""The laws of the comparison: which numbers each may choose, and the block for a choice."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

import workbench as wb
from studies.d2_planning.own_laws import ClippedRegulator, GovernedRegulator, IntegralRegulator
from studies.d2_planning.predictive import MANY_SWEEPS, converged_law, predictive_law
from studies.d2_planning.problems import Knobs, Problem, linear_model, target_of, weights
from studies.paper.card import CARD
from studies.paper.laws import ARM

MOST_KNOBS = 5  # of a law
SETTLED = 1.0  # gain of the back-calculation in multiples of the inverse of Ki


@dataclass(frozen=True)
class Knob:
    """A number that a law may choose, with its range; logarithmic unless the range begins at zero."""

    name: str
    low: float
    high: float

    def at(self, share: float) -> float:
        """The value at a share of the range."""
        if self.low <= 0:
            return self.low + share * (self.high - self.low)
        return float(self.low * (self.high / self.low) ** share)


@dataclass(frozen=True)
class Law:
    """A law of the comparison, with its knobs and the fields of its block that they change."""

    key: str
    name: str
    knobs: tuple[Knob, ...]
    fields: tuple[str, ...]
    block: Callable[[Problem, Knobs], wb.Controller]
    style: int
    only: str = ""  # the one problem that it is for

    def choice(self, shares: wb.Array) -> Knobs:
        """The knobs at some shares of their ranges; a law takes as many as it has."""
        return {knob.name: knob.at(float(share)) for knob, share in zip(self.knobs, shares, strict=False)}


def clipped_regulator(problem: Problem, knobs: Knobs) -> ClippedRegulator:
    """LQR about the rest, clipped."""
    model = linear_model(problem.key)
    K = wb.lqr(model.A, model.B, *weights(problem, knobs), discrete=True).K
    return ClippedRegulator(target_of(problem), np.asarray(K))


def integral(problem: Problem, knobs: Knobs, share: float = SETTLED) -> IntegralRegulator:
    """LQR with integrals and back-calculation; without it for a share of zero."""
    model = linear_model(problem.key)
    n, m = model.B.shape
    A = np.block([[model.A, np.zeros((n, m))], [model.C, np.eye(m)]])
    B = np.vstack([model.B, np.zeros((m, m))])
    Q, R = weights(problem, knobs)
    both = np.block([[Q, np.zeros((n, m))], [np.zeros((m, n)), knobs["integrals"] * np.eye(m)]])
    K = np.asarray(wb.lqr(A, B, both, R, discrete=True).K)
    M = -share * knobs.get("unwinding", 1.0) * np.linalg.inv(K[:, n:])
    law = IntegralRegulator(target_of(problem), K[:, :n], K[:, n:], np.asarray(M, dtype=float), model.C)
    return law.run_every(problem.period)


def winding(problem: Problem, knobs: Knobs) -> IntegralRegulator:
    """LQR with integrals that wind up."""
    return integral(problem, knobs, 0.0)


def governed_regulator(problem: Problem, knobs: Knobs) -> GovernedRegulator:
    """LQR behind a scalar reference governor."""
    model, K = linear_model(problem.key), clipped_regulator(problem, knobs).K
    rows, closed = [K], model.A - model.B @ K
    for _ in range(problem.stages - 1):
        rows.append(rows[-1] @ closed)
    law = GovernedRegulator(target_of(problem), K, model.C, np.vstack(rows), knobs["margin"])
    return law.run_every(problem.period)


def computed_torque(problem: Problem, knobs: Knobs) -> wb.Controller:
    """Computed torque with the estimate of the disturbance."""
    omega, zeta = knobs["frequency"], knobs["damping"]
    return wb.arms.laws.ComputedTorque(ARM, np.full(2, omega**2), np.full(2, 2 * zeta * omega))


def sliding_mode(problem: Problem, knobs: Knobs) -> wb.Controller:
    """Sliding mode control with the estimate of the disturbance."""
    gains = knobs["gain"] * np.array(CARD["SMC: K"])
    law = wb.SlidingMode(ARM, np.full(2, knobs["slope"]), gains, knobs["layer"])
    return wb.arms.laws.DisturbanceCompensation(law)


def proposed_law(problem: Problem, knobs: Knobs) -> wb.Controller:
    """AOSMC-RGS with the four repairs of report a1."""
    return wb.arms.laws.AosmcRgs(
        ARM,
        np.full(2, knobs["slope"]),
        knobs["layer"],
        K=knobs["gain"] * np.array(CARD["K(0)"]),
        P=CARD["P(0)"],
        Q=CARD["Q"],
        R=CARD["R"],
        velocity="reference",
        gain_sign="raised",
        gain_shape=CARD["reading of (33)"],
        integrator="cayley",
    )


LOAD = Knob("load", 0.1, 10.0)  # of the observer: how fast the disturbance is assumed to change
INPUTS, RATES = Knob("inputs", 1e-3, 10.0), Knob("rates", 1e-3, 1.0)
LAWS = (
    Law("mpc", "MPC", (LOAD, INPUTS, RATES), (), predictive_law, 0),
    Law(
        "governor",
        "LQR + governor",
        (LOAD, INPUTS, RATES, Knob("margin", 0.0, 0.1)),
        ("K", "Phi", "margin"),
        governed_regulator,
        1,
    ),
    Law("lqr", "clipped LQR", (LOAD, INPUTS, RATES), ("K",), clipped_regulator, 2),
    Law(
        "lqi",
        "LQI + anti-windup",
        (LOAD, INPUTS, RATES, Knob("integrals", 1e-5, 1e-1), Knob("unwinding", 0.0, 1.0)),
        ("K", "Ki", "M"),
        integral,
        3,
    ),
    Law(
        "winding",
        "LQI, clipped",
        (LOAD, INPUTS, RATES, Knob("integrals", 1e-5, 1e-1)),
        ("K", "Ki"),
        winding,
        4,
    ),
    Law(
        "ct",
        "computed torque",
        (LOAD, Knob("frequency", 2.0, 30.0), Knob("damping", 0.5, 2.0)),
        ("Kp", "Kd"),
        computed_torque,
        5,
        "arm",
    ),
    Law(
        "smc",
        "SMC",
        (LOAD, Knob("slope", 1.0, 20.0), Knob("gain", 1.0, 300.0), Knob("layer", 0.1, 30.0)),
        ("law.Lambda", "law.K", "law.phi"),
        sliding_mode,
        6,
        "arm",
    ),
    Law(
        "aosmc",
        "AOSMC-RGS",
        (LOAD, Knob("slope", 1.0, 20.0), Knob("gain", 0.1, 10.0), Knob("layer", 0.03, 3.0)),
        ("Lambda", "K", "phi"),
        proposed_law,
        7,
        "arm",
    ),
)
CONVERGED = Law(
    "mpc",
    f"MPC of {MANY_SWEEPS} sweeps",
    (LOAD, INPUTS, RATES),
    ("law.K", "law.S", "law.sigma", "law.W", "law.L", "law.Y"),
    converged_law,
    0,
)
BY_KEY = {law.key: law for law in LAWS}
TUNED = BY_KEY | {
    CONVERGED.key: CONVERGED
}  # MPC is tuned with many sweeps, so that no weights are preferred for theirs


def laws_of(problem: Problem) -> tuple[Law, ...]:
    """The laws that are compared on a problem."""
    return tuple(law for law in LAWS if law.only in ("", problem.key))

"""The laws of a8, each with the numbers that are tuned and the ranges in which their search begins."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from studies.paper.card import CARD
from studies.paper.laws import ARM, RULES
from workbench.controllers import (
    PID,
    AdaptiveSlidingMode,
    AosmcRgs,
    ComputedTorque,
    FuzzyAsmc,
    NonsingularTerminalSlidingMode,
    RbfAsmc,
    Rise,
    SlidingMode,
    StateFeedback,
    SuperTwisting,
)
from workbench.loop import AbstractController
from workbench.study.uncertainty.distributions import LogUniform
from workbench.study.uncertainty.factors import Factor

PROPOSED = "AOSMC-RGS"
FARTHER = 1e3  # times a range: as far as a search may go beyond where it begins
I = np.eye(2)
Numbers = Mapping[str, float]


@dataclass(frozen=True)
class Sought:
    """A number that is tuned.

    Attributes
    ----------
    low, high
        Where the search begins, on a scale of logarithms.
    card
        The number that a1 assumes, or a usual one where a1 has no such law.
    ends, why
        Physical limits with their reason in words, where there are any.
    """

    name: str
    paths: tuple[str, ...]
    low: float
    high: float
    card: float
    unit: str
    ends: tuple[float, float] | None = None
    why: str = ""

    @property
    def limits(self) -> tuple[float, float]:
        """How far a search may go."""
        return self.ends or (self.low / FARTHER, self.high * FARTHER)

    @property
    def factor(self) -> Factor:
        """What a tuning varies."""
        return Factor(self.name, self.paths, LogUniform(*self.limits))


@dataclass(frozen=True)
class Law:
    """A law and its numbers.

    Attributes
    ----------
    make
        From these numbers by name to the law.
    counts_on_d
        Whether it adds an estimated disturbance to its torque by itself.
    """

    name: str
    make: Callable[[Numbers], AbstractController]
    tuned: tuple[Sought, ...]
    counts_on_d: bool = False


def joints(name: str, field: str, low: float, high: float, card: tuple[float, ...], unit: str) -> tuple[Sought, ...]:
    """One number for each joint."""
    return tuple(Sought(f"{name}_{j + 1}", (f"controller.{field}[{j}]",), low, high, card[j], unit) for j in (0, 1))


def diagonals(name: str, field: str, low: float, high: float, card: tuple[float, ...], unit: str) -> tuple[Sought, ...]:
    """One number for each joint, on the diagonal of a matrix."""
    return tuple(Sought(f"{name}_{j + 1}", (f"controller.{field}[{j},{j}]",), low, high, card[j], unit) for j in (0, 1))


def one(
    name: str,
    field: str,
    low: float,
    high: float,
    card: float,
    unit: str,
    ends: tuple[float, float] | None = None,
    why: str = "",
) -> Sought:
    """One number of the law."""
    return Sought(name, (f"controller.{field}",), low, high, card, unit, ends, why)


def shared(name: str, field: str, low: float, high: float, card: float, unit: str) -> Sought:
    """One number for both joints."""
    return Sought(name, tuple(f"controller.{field}[{j}]" for j in (0, 1)), low, high, card, unit)


def both(x: Numbers, name: str) -> tuple[float, float]:
    """The numbers of both joints."""
    return x[f"{name}_1"], x[f"{name}_2"]


def diagonal(path: str) -> tuple[str, str]:
    """The paths of the diagonal of a matrix."""
    return f"{path}[0,0]", f"{path}[1,1]"


LAMBDA = joints("Lambda", "Lambda", 1.0, 40.0, CARD["Lambda"], "1/s")
LAYER = (1e-5, 100.0), "s stays within so wide a layer, where the gain over phi alone counts"
LAG = (5e-6, 500.0), "with so long a lag the gain follows no rule, and with so short a one it follows at once"
PHI = one("phi", "phi", 0.01, 10.0, CARD["phi"], "rad/s", *LAYER)
SURFACE = (*LAMBDA, PHI)
GAIN = (1.0, 500.0)  # N m, of a switching torque
LEARNED = (
    *SURFACE,
    one("K(0)", "K", *GAIN, 5.0, "N m"),
    one("gamma", "gamma", 0.1, 100.0, CARD["ASMC: gamma"], "N m/rad"),
)
OF_PROPOSED = (
    *SURFACE,
    Sought("K(0)", diagonal("controller.K"), *GAIN, 5.0, "N m"),
    Sought("P(0)", diagonal("controller.P"), 0.1, 1000.0, 10.0, "N m/rad"),
    Sought("Q", diagonal("controller.Q"), 0.01, 1000.0, 599.0, "N m/(rad s)"),
    Sought("R", diagonal("controller.R"), 0.001, 1000.0, 6.43, "N m/(rad s)"),
)
OF_RISE = (
    *SURFACE,
    shared("ks", "ks", 1.0, 300.0, 20.0, "N m s/rad"),
    shared("alpha", "alpha", 0.01, 40.0, 2.0, "1/s"),
    shared("beta", "beta", 0.1, 1000.0, 10.0, "N m/s"),
)
OF_TERMINAL = (
    shared("beta", "beta", 1.0, 200.0, 10.0, "rad^(gamma-1)/s^gamma"),
    one("gamma", "gamma", 1.1, 1.9, 5 / 3, "", (1.01, 1.99), "the law asks for 1 < gamma < 2"),
    shared("k1", "k1", 1.0, 1000.0, 50.0, "1/s^2"),
    shared("k2", "k2", 1.0, 1000.0, 50.0, "rad^(1/2)/s^2"),
    one("phi", "phi", 0.001, 1.0, 0.05, "rad"),
)
STIFF, DAMPED = (5.0, 2000.0), (0.5, 200.0)  # N m/rad, N m s/rad
OF_PID = (
    *joints("Kp", "Kp", *STIFF, CARD["PID: Kp"], "N m/rad"),
    *joints("Ki", "Ki", 5.0, 5000.0, CARD["PID: Ki"], "N m/(rad s)"),
    *joints("Kd", "Kd", *DAMPED, CARD["PID: Kd"], "N m s/rad"),
)


def surface(x: Numbers) -> dict[str, object]:
    """What all sliding laws take."""
    return {"model": ARM, "Lambda": both(x, "Lambda"), "phi": x["phi"]}


def learning(x: Numbers) -> dict[str, object]:
    """What all laws take whose gain learns."""
    return surface(x) | {"gamma": x["gamma"], "K": (x["K(0)"], x["K(0)"])}


def rbf(x: Numbers) -> RbfAsmc:
    """The network with the nodes of the card."""
    centres, widths = np.outer(CARD["RBF-ASMC: centres"], np.ones(4)), CARD["RBF-ASMC: widths"]
    nodes = {"centres": centres, "widths": widths, "integrator": "exact"}
    return RbfAsmc(**learning(x), Gamma=x["Gamma"], sigma=x["sigma"], **nodes)


def aosmc(x: Numbers) -> AosmcRgs:
    """The paper's law with the four repairs of a1, with (34) in Cayley steps."""
    return AosmcRgs(
        **surface(x),
        K=x["K(0)"] * I,
        P=x["P(0)"] * I,
        Q=x["Q"] * I,
        R=x["R"] * I,
        velocity="reference",
        gain_sign="raised",
        gain_shape=CARD["reading of (33)"],
        integrator="cayley",
    )


def rise(x: Numbers) -> Rise:
    """With the torque of the reference by the model, and one integral for both joints."""
    ks, alpha, beta = (x[name] for name in ("ks", "alpha", "beta"))
    return Rise(both(x, "Lambda"), (alpha, alpha), (ks, ks), (beta, beta), x["phi"], model=ARM)


def terminal(x: Numbers) -> NonsingularTerminalSlidingMode:
    """The continuous reaching law, with the root of |s|."""
    beta, k1, k2 = ((x[name], x[name]) for name in ("beta", "k1", "k2"))
    return NonsingularTerminalSlidingMode(ARM, beta, x["gamma"], k1, k2, 0.5, x["phi"])


LAWS = (
    Law(PROPOSED, aosmc, OF_PROPOSED, counts_on_d=True),
    Law("ASMC", lambda x: AdaptiveSlidingMode(**learning(x)), LEARNED),
    Law(
        "Fuzzy-ASMC",
        lambda x: FuzzyAsmc(**learning(x), lag=x["lag"], rules=RULES),
        (*LEARNED, one("lag", "lag", 0.005, 0.5, CARD["Fuzzy-ASMC: lag"], "s", *LAG)),
    ),
    Law(
        "RBF-ASMC",
        rbf,
        (
            *LEARNED,
            one("Gamma", "Gamma", 0.1, 1000.0, CARD["RBF-ASMC: Gamma"], "N m/rad"),
            one("sigma", "sigma", 0.01, 10.0, CARD["RBF-ASMC: sigma"], "1/s"),
        ),
    ),
    Law("PID", lambda x: PID(both(x, "Kp"), both(x, "Ki"), both(x, "Kd")), OF_PID),
    Law("PID + gravity", lambda x: PID(both(x, "Kp"), both(x, "Ki"), both(x, "Kd"), ARM), OF_PID),
    Law(
        "SMC",
        lambda x: SlidingMode(**surface(x), K=both(x, "K")),
        (*SURFACE, *joints("K", "K", *GAIN, CARD["SMC: K"], "N m")),
    ),
    Law(
        "super-twisting",
        lambda x: SuperTwisting(**surface(x), k1=(x["k1"], x["k1"]), k2=(x["k2"], x["k2"])),
        (
            *SURFACE,
            one("k1", "k1", 1.0, 100.0, CARD["super-twisting: k1"][0], "(rad/s^3)^(1/2)"),
            one("k2", "k2", 1.0, 1000.0, CARD["super-twisting: k2"][0], "rad/s^3"),
        ),
    ),
    Law(
        "feedforward + PD",
        lambda x: StateFeedback(ARM, np.diag(both(x, "Kp")), np.diag(both(x, "Kd"))),
        (
            *diagonals("Kp", "Kp", *STIFF, CARD["PID: Kp"], "N m/rad"),
            *diagonals("Kd", "Kd", *DAMPED, CARD["PID: Kd"], "N m s/rad"),
        ),
    ),
    Law(
        "computed torque",
        lambda x: ComputedTorque(ARM, both(x, "Kp"), both(x, "Kd")),
        (
            *joints("Kp", "Kp", 10.0, 2000.0, (36.0, 36.0), "1/s^2"),
            *joints("Kd", "Kd", 2.0, 200.0, (12.0, 12.0), "1/s"),
        ),
        counts_on_d=True,
    ),
    Law("RISE", rise, OF_RISE),
    Law("terminal SMC", terminal, OF_TERMINAL),
)

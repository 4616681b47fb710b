"""The laws of a8, each with the numbers that are tuned and the ranges in which they are sought."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from fair_conditions import Computed, Scenario
from paper_card import CARD
from paper_laws import ARM, RULES

from workbench.controllers import (
    PID,
    AdaptiveSlidingMode,
    AosmcRgs,
    FuzzyAsmc,
    RbfAsmc,
    SlidingMode,
    StateFeedback,
    SuperTwisting,
    WithCompensation,
)
from workbench.loop import AbstractController, AbstractObserver
from workbench.observers import FullState, Luenberger, MomentumObserver, OracleFilter, WithDisturbance
from workbench.study.distributions import LogUniform
from workbench.study.factors import Factor

PROPOSED, TOLD = "AOSMC-RGS", "AOSMC-RGS told D"
I = np.eye(2)
Numbers = Mapping[str, float]


@dataclass(frozen=True)
class Sought:
    """A number that is sought: its paths in a loop, its range, and what the card has."""

    name: str
    paths: tuple[str, ...]
    low: float
    high: float
    card: float
    unit: str


@dataclass(frozen=True)
class Entrant:
    """A law with the numbers that are tuned.

    Attributes
    ----------
    make
        From these numbers by name to the observer and the law, the observer's first estimate at a position.
    """

    name: str
    make: Callable[[Numbers, tuple[float, float]], tuple[AbstractObserver, AbstractController]]
    tuned: tuple[Sought, ...]

    @property
    def key(self) -> str:
        """The name as part of a file's."""
        return "".join(c if c.isalnum() else "_" for c in self.name.lower())

    @property
    def card(self) -> dict[str, float]:
        """The numbers of the card."""
        return {one.name: one.card for one in self.tuned}

    @property
    def factors(self) -> tuple[Factor, ...]:
        """The numbers, to be sought on a scale of logarithms."""
        return tuple(Factor(one.name, one.paths, LogUniform(one.low, one.high)) for one in self.tuned)

    def loop(self, scenario: Scenario, numbers: Numbers) -> Computed:
        """The law with these numbers in a scenario."""
        return scenario.loop(*self.make(numbers, scenario.start))


def joints(name: str, field: str, low: float, high: float, card: tuple[float, ...], unit: str) -> tuple[Sought, ...]:
    """One number for each joint."""
    return tuple(Sought(f"{name}_{j + 1}", (f"controller.{field}[{j}]",), low, high, card[j], unit) for j in (0, 1))


LAMBDA = joints("Lambda", "Lambda", 1.0, 40.0, CARD["Lambda"], "1/s")
PHI = Sought("phi", ("controller.phi",), 0.01, 10.0, CARD["phi"], "rad/s")
SURFACE = (*LAMBDA, PHI)
GAIN = (1.0, 500.0)  # N m, of a switching torque
LEARNED = (
    *SURFACE,
    Sought("K(0)", ("controller.K",), *GAIN, 5.0, "N m"),
    Sought("gamma", ("controller.gamma",), 0.1, 100.0, CARD["ASMC: gamma"], "N m/rad"),
)


def pair(x: Numbers, name: str) -> tuple[float, float]:
    """The numbers of both joints."""
    return x[f"{name}_1"], x[f"{name}_2"]


def surface(x: Numbers) -> dict[str, object]:
    """What all sliding laws take."""
    return {"model": ARM, "Lambda": pair(x, "Lambda"), "phi": x["phi"]}


def learning(x: Numbers) -> dict[str, object]:
    """What all laws take whose gain learns."""
    return surface(x) | {"gamma": x["gamma"], "K": (x["K(0)"], x["K(0)"])}


def rbf(x: Numbers) -> RbfAsmc:
    """The network with the nodes of the card."""
    centres, widths = np.outer(CARD["RBF-ASMC: centres"], np.ones(4)), CARD["RBF-ASMC: widths"]
    return RbfAsmc(**learning(x), Gamma=x["Gamma"], sigma=x["sigma"], centres=centres, widths=widths)


def aosmc(x: Numbers) -> AosmcRgs:
    """The smallest repair of the paper's law, as in a1."""
    return AosmcRgs(
        **surface(x),
        K=x["K(0)"] * I,
        P=x["P(0)"] * I,
        Q=x["Q"] * I,
        R=x["R"] * I,
        velocity="reference",
        gain_sign="raised",
        gain_shape=CARD["reading of (33)"],
    )


def observed(x: Numbers, start: tuple[float, float], *, told: bool) -> WithDisturbance:
    """(10), with an observer of the momentum in place of (24), or with the D of (24) told."""
    state = Luenberger(ARM, x["L1"] * I, x["L2"] * I, q_hat=start)
    return WithDisturbance(state, OracleFilter(2, x["l"]) if told else MomentumObserver(ARM, x["l"]))


def diagonal(name: str) -> tuple[str, str]:
    """The paths of the diagonal of a matrix."""
    return f"{name}[0,0]", f"{name}[1,1]"


OF_OBSERVERS = (
    Sought("L1", diagonal("observer.state.L1"), 1.0, 400.0, 30.0, "1/s"),
    Sought("L2", diagonal("observer.state.L2"), 50.0, 40000.0, 50.0, "1/s^2"),
    Sought("l", ("observer.disturbance.l",), 1.0, 100.0, CARD["l"], "1/s"),
)
OF_PROPOSED = (
    *SURFACE,
    Sought("K(0)", diagonal("controller.K"), *GAIN, 5.0, "N m"),
    Sought("P(0)", diagonal("controller.P"), 0.1, 1000.0, 10.0, "N m/rad"),
    Sought("Q", diagonal("controller.Q"), 0.01, 1000.0, 599.0, "N m/(rad s)"),
    Sought("R", diagonal("controller.R"), 0.001, 1000.0, 6.43, "N m/(rad s)"),
    *OF_OBSERVERS,
)


def measured(
    law: Callable[[Numbers], AbstractController],
) -> Callable[..., tuple[AbstractObserver, AbstractController]]:
    """A law on what the instruments say."""
    return lambda x, start: (FullState(2), law(x))


def behind_observers(entrant: Entrant) -> Entrant:
    """A law behind the observers of AOSMC-RGS, with D_hat added to its torque."""

    def make(x: Numbers, start: tuple[float, float]) -> tuple[AbstractObserver, AbstractController]:
        return observed(x, start, told=False), WithCompensation(entrant.make(x, start)[1])

    own = tuple(
        replace(one, paths=tuple(path.replace("controller.", "controller.law.") for path in one.paths))
        for one in entrant.tuned
    )
    return Entrant(f"{entrant.name} + observers", make, (*own, *OF_OBSERVERS))


PROPOSALS = tuple(
    Entrant(name, lambda x, start, told=told: (observed(x, start, told=told), aosmc(x)), OF_PROPOSED)
    for name, told in ((PROPOSED, False), (TOLD, True))
)
RIVALS = (
    Entrant("ASMC", measured(lambda x: AdaptiveSlidingMode(**learning(x))), LEARNED),
    Entrant(
        "Fuzzy-ASMC",
        measured(lambda x: FuzzyAsmc(**learning(x), lag=x["lag"], rules=RULES)),
        (*LEARNED, Sought("lag", ("controller.lag",), 0.005, 0.5, CARD["Fuzzy-ASMC: lag"], "s")),
    ),
    Entrant(
        "RBF-ASMC",
        measured(rbf),
        (
            *LEARNED,
            Sought("Gamma", ("controller.Gamma",), 0.1, 1000.0, CARD["RBF-ASMC: Gamma"], "N m/rad"),
            Sought("sigma", ("controller.sigma",), 0.01, 10.0, CARD["RBF-ASMC: sigma"], "1/s"),
        ),
    ),
    Entrant(
        "PID",
        measured(lambda x: PID(pair(x, "Kp"), pair(x, "Ki"), pair(x, "Kd"))),
        (
            *joints("Kp", "Kp", 5.0, 2000.0, CARD["PID: Kp"], "N m/rad"),
            *joints("Ki", "Ki", 5.0, 5000.0, CARD["PID: Ki"], "N m/(rad s)"),
            *joints("Kd", "Kd", 0.5, 200.0, CARD["PID: Kd"], "N m s/rad"),
        ),
    ),
    Entrant(
        "SMC",
        measured(lambda x: SlidingMode(**surface(x), K=pair(x, "K"))),
        (*SURFACE, *joints("K", "K", *GAIN, CARD["SMC: K"], "N m")),
    ),
    Entrant(
        "super-twisting",
        measured(lambda x: SuperTwisting(**surface(x), k1=(x["k1"], x["k1"]), k2=(x["k2"], x["k2"]))),
        (
            *SURFACE,
            Sought("k1", ("controller.k1",), 1.0, 100.0, CARD["super-twisting: k1"][0], "(rad/s^3)^(1/2)"),
            Sought("k2", ("controller.k2",), 1.0, 1000.0, CARD["super-twisting: k2"][0], "rad/s^3"),
        ),
    ),
    Entrant(
        "feedforward + PD",
        measured(lambda x: StateFeedback(ARM, np.diag(pair(x, "Kp")), np.diag(pair(x, "Kd")))),
        (
            Sought("Kp_1", ("controller.Kp[0,0]",), 5.0, 2000.0, CARD["PID: Kp"][0], "N m/rad"),
            Sought("Kp_2", ("controller.Kp[1,1]",), 5.0, 2000.0, CARD["PID: Kp"][1], "N m/rad"),
            Sought("Kd_1", ("controller.Kd[0,0]",), 0.5, 200.0, CARD["PID: Kd"][0], "N m s/rad"),
            Sought("Kd_2", ("controller.Kd[1,1]",), 0.5, 200.0, CARD["PID: Kd"][1], "N m s/rad"),
        ),
    ),
)
OBSERVED = tuple(behind_observers(one) for one in RIVALS if one.name in ("SMC", "feedforward + PD"))
MAIN = (PROPOSALS[0], *RIVALS)
ENTRANTS = (*MAIN, *OBSERVED, PROPOSALS[1])

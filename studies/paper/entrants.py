"""The laws of a8 with the numbers that are tuned, and their measurements: laws with the same ones are compared."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

import workbench as wb
from studies.paper.card import CARD
from studies.paper.laws import ARM, arm_law
from studies.paper.scenarios import Scenario, first_estimates

PROPOSED_LAW = "AOSMC-RGS"
FARTHER = 1e3  # times a range: as far as a search may go beyond where it begins
EACH, DIAGONAL = ("[0]", "[1]"), ("[0,0]", "[1,1]")  # the places of both joints in a vector and a matrix


@dataclass(frozen=True)
class TunedNumber:
    """A number that is tuned."""

    name: str
    paths: tuple[str, ...]
    low: float  # the ends between which the search begins, on a scale of logarithms
    high: float
    unit: str
    ends: tuple[float, float] | None = None  # physical limits, where there are any
    why: str = ""  # their reason in words

    @property
    def factor(self) -> wb.Factor:
        """The factor of a tuning, to its far limits."""
        return wb.Factor(
            self.name, self.paths, wb.LogUniform(*(self.ends or (self.low / FARTHER, self.high * FARTHER)))
        )


@dataclass(frozen=True)
class Law:
    """A law, the numbers of it that are tuned, and whether it adds an estimated disturbance to its torque by itself."""

    name: str
    block: wb.arms.AbstractArmController
    tuned_numbers: tuple[TunedNumber, ...]
    counts_on_d: bool = False


def one(
    path: str, low: float, high: float, unit: str, at: tuple[str, ...] = ("",), name: str = "", **physical: Any
) -> TunedNumber:
    """One number of a loop, at one or several places of a field."""
    return TunedNumber(
        name or path.split(".")[-1], tuple(f"{path}{place}" for place in at), low, high, unit, **physical
    )


def two(field: str, low: float, high: float, unit: str, at: tuple[str, str] = EACH) -> tuple[TunedNumber, ...]:
    """A number of a law for each joint."""
    return tuple(one(f"controller.{field}", low, high, unit, (at[j],), f"{field}_{j + 1}") for j in (0, 1))


LAYER = "s stays within such a wide layer, where only the ratio of gain and phi counts"
LAG = "with the longest lag the gain does not follow its rules, and with the shortest it follows them at once"
ORDER = "the law asks for 1 < gamma < 2"
GAIN = (1.0, 500.0)  # N m, of a switching torque
STIFFNESS_RANGE, DAMPING_RANGE = (5.0, 2000.0), (0.5, 200.0)  # N m/rad, N m s/rad
SURFACE = (
    *two("Lambda", 1.0, 40.0, "1/s"),
    one("controller.phi", 0.01, 10.0, "rad/s", ends=(1e-5, 100.0), why=LAYER),
)
OF_PROPOSED = (
    *SURFACE,
    one("controller.K", *GAIN, "N m", DIAGONAL, "K(0)"),
    one("controller.P", 0.1, 1000.0, "N m/rad", DIAGONAL, "P(0)"),
    one("controller.Q", 0.01, 1000.0, "N m/(rad s)", DIAGONAL),
    one("controller.R", 0.001, 1000.0, "N m/(rad s)", DIAGONAL),
)
ADAPTIVE_NUMBERS = (
    *SURFACE,
    one("controller.K", *GAIN, "N m", name="K(0)"),
    one("controller.gamma", 0.1, 100.0, "N m/rad"),
)
OF_FUZZY = (
    *ADAPTIVE_NUMBERS,
    one("controller.lag", 0.005, 0.5, "s", ends=(5e-6, 500.0), why=LAG),
)
OF_RBF = (
    *ADAPTIVE_NUMBERS,
    one("controller.Gamma", 0.1, 1000.0, "N m/rad"),
    one("controller.sigma", 0.01, 10.0, "1/s"),
)
OF_PID = (
    *two("Kp", *STIFFNESS_RANGE, "N m/rad"),
    *two("Ki", 5.0, 5000.0, "N m/(rad s)"),
    *two("Kd", *DAMPING_RANGE, "N m s/rad"),
)
OF_SMC = (*SURFACE, *two("K", *GAIN, "N m"))
OF_SUPER_TWISTING = (
    *SURFACE,
    one("controller.k1", 1.0, 100.0, "(rad/s^3)^(1/2)"),
    one("controller.k2", 1.0, 1000.0, "rad/s^3"),
)
OF_FEEDFORWARD = (
    *two("Kp", *STIFFNESS_RANGE, "N m/rad", DIAGONAL),
    *two("Kd", *DAMPING_RANGE, "N m s/rad", DIAGONAL),
)
OF_COMPUTED_TORQUE = (
    *two("Kp", 10.0, 2000.0, "1/s^2"),
    *two("Kd", 2.0, 200.0, "1/s"),
)
OF_RISE = (
    *SURFACE,
    one("controller.ks", 1.0, 300.0, "N m s/rad", EACH),
    one("controller.alpha", 0.01, 40.0, "1/s", EACH),
    one("controller.beta", 0.1, 1000.0, "N m/s", EACH),
)
OF_TERMINAL = (
    one("controller.beta", 1.0, 200.0, "rad^(gamma-1)/s^gamma", EACH),
    one("controller.gamma", 1.1, 1.9, "", ends=(1.01, 1.99), why=ORDER),
    one("controller.k1", 1.0, 1000.0, "1/s^2", EACH),
    one("controller.k2", 1.0, 1000.0, "rad^(1/2)/s^2", EACH),
    one("controller.phi", 0.001, 1.0, "rad"),
)

I = np.eye(2)
LAMBDA = CARD["Lambda"]
AOSMC = wb.arms.laws.AosmcRgs(  # with the four repairs of a1, and (34) in Cayley steps
    *(ARM, LAMBDA, CARD["phi"], 5.0 * I, 10.0 * I, 599.0 * I, 6.43 * I),
    velocity="reference",
    gain_sign="raised",
    gain_shape=CARD["reading of (33)"],
    integrator="cayley",
)
LAWS = (
    Law(PROPOSED_LAW, AOSMC, OF_PROPOSED, counts_on_d=True),
    Law("ASMC", arm_law("ASMC"), ADAPTIVE_NUMBERS),
    Law("Fuzzy-ASMC", arm_law("Fuzzy-ASMC"), OF_FUZZY),
    Law("RBF-ASMC", replace(arm_law("RBF-ASMC"), integrator="exact"), OF_RBF),
    Law("PID", arm_law("PID"), OF_PID),
    Law("PID + gravity", wb.ArmPID(CARD["PID: Kp"], CARD["PID: Ki"], CARD["PID: Kd"], ARM), OF_PID),
    Law("SMC", arm_law("SMC"), OF_SMC),
    Law("super-twisting", arm_law("super-twisting"), OF_SUPER_TWISTING),
    Law(
        "feedforward + PD", wb.ArmStateFeedback(ARM, np.diag(CARD["PID: Kp"]), np.diag(CARD["PID: Kd"])), OF_FEEDFORWARD
    ),
    Law(
        "computed torque",
        wb.arms.laws.ComputedTorque(ARM, (36.0, 36.0), (12.0, 12.0)),
        OF_COMPUTED_TORQUE,
        counts_on_d=True,
    ),
    Law("RISE", wb.arms.laws.Rise(LAMBDA, (2.0, 2.0), (20.0, 20.0), (10.0, 10.0), CARD["phi"], model=ARM), OF_RISE),
    Law(
        "terminal SMC",
        wb.arms.laws.NonsingularTerminalSlidingMode(ARM, (10.0, 10.0), 5 / 3, (50.0, 50.0), (50.0, 50.0), 0.5, 0.05),
        OF_TERMINAL,
    ),
)


T = TypeVar("T", bound=wb.Observer | wb.Controller)


@dataclass(frozen=True)
class Information:
    """All that stands between the instruments and a law: in files by its `key`, in columns by its `name`."""

    key: str
    name: str
    words: str
    observer: wb.Observer
    tuned_numbers: tuple[TunedNumber, ...] = ()


def gains(path: str) -> tuple[TunedNumber, TunedNumber]:
    return (
        one(f"{path}.L1", 1.0, 400.0, "1/s", DIAGONAL),
        one(f"{path}.L2", 50.0, 40000.0, "1/s^2", DIAGONAL),
    )


PASSES = "the filter passes its input on"
LUENBERGER = wb.arms.observers.Luenberger(ARM, CARD["L1"], CARD["L2"], q_hat=(0.0, 0.0), integrator="cayley")
ALL_GAINS = (*gains("observer.state"), one("observer.disturbance.l", 1.0, 100.0, "1/s"))
READINGS = Information("readings", "raw readings", "positions and velocities as read", wb.ArmFullState(2))
FILTER = Information(
    "filter",
    "filtered velocity",
    "positions as read, and velocities through a filter of first order",
    wb.arms.observers.VelocityFilter(2, 200.0),
    (one("observer.omega", 10.0, 1000.0, "rad/s", ends=(0.01, 10000.0), why=PASSES),),
)
OBSERVER = Information(
    "observer", "observer (10)", "positions as read, and observer (10) for the state", LUENBERGER, gains("observer")
)
BOTH = Information(
    "both",
    "observer (10) and D_hat",
    "positions as read, observer (10) for the state, and an observer of the momentum for D",
    wb.arms.observers.StateAndDisturbanceObserver(LUENBERGER, wb.arms.observers.MomentumObserver(ARM, CARD["l"])),
    ALL_GAINS,
)
ALL_INFORMATION = (READINGS, FILTER, OBSERVER, BOTH)  # from what an instrument gives


@dataclass(frozen=True)
class Entrant:
    """A law behind what it is given, with all numbers that are tuned."""

    law: Law
    information: Information

    @property
    def name(self) -> str:
        """The name of the law: within a table all laws have the same measurements."""
        return self.law.name

    @property
    def key(self) -> str:
        return f"{''.join(c if c.isalnum() else '_' for c in self.law.name.lower())}_{self.information.key}"

    @property
    def has_compensation(self) -> bool:
        """True if D_hat is estimated, and added to the torque of the law from outside."""
        return (
            isinstance(self.information.observer, wb.arms.observers.StateAndDisturbanceObserver)
            and not self.law.counts_on_d
        )

    @property
    def tuned_numbers(self) -> tuple[TunedNumber, ...]:
        """The numbers of the law, then those of what stands before it."""
        inside = "controller.law." if self.has_compensation else "controller."
        own = (
            replace(sought, paths=tuple(path.replace("controller.", inside) for path in sought.paths))
            for sought in self.law.tuned_numbers
        )
        return (*own, *self.information.tuned_numbers)

    def _numbers_by_path(self, numbers: Mapping[str, float]) -> Iterator[tuple[str, float]]:
        for sought in self.tuned_numbers if numbers else ():
            yield from ((path, numbers[sought.name]) for path in sought.paths)

    def loop(self, scenario: Scenario, numbers: Mapping[str, float] | None = None) -> wb.DigitalLoop:
        """The law with these numbers in a scenario, or with those that a1 assumes."""
        law = wb.arms.laws.DisturbanceCompensation(self.law.block) if self.has_compensation else self.law.block
        observer = self.information.observer
        for path in first_estimates(observer):
            observer = with_number(observer, path, scenario.start)
        blocks: dict[str, Any] = {"controller": law, "observer": observer}
        for path, number in self._numbers_by_path(numbers or {}):
            block, _, inside = path.partition(".")
            blocks[block] = with_number(blocks[block], inside, number)
        return scenario.loop(**blocks)


def with_number(block: T, path: str, value: float | tuple[float, ...]) -> T:
    """A block with another number at a path such as `law.K[0,1]`, or at all places of its field."""
    head, _, rest = path.partition(".")
    name, *index = re.findall(r"\w+", head)
    old = getattr(block, name)
    if rest:
        return replace(block, **{name: with_number(old, rest, value)})
    new = np.array(old, dtype=float)
    new[tuple(map(int, index)) or ...] = value
    return replace(block, **{name: new if new.shape else float(new)})


ENTRANTS = {given.key: tuple(Entrant(law, given) for law in LAWS) for given in ALL_INFORMATION}
PROPOSAL = next(entrant for entrant in ENTRANTS[BOTH.key] if entrant.name == PROPOSED_LAW)
ALL = tuple(entrant for entrants in ENTRANTS.values() for entrant in entrants)

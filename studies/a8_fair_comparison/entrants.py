"""What a law is given in a8, and each law behind it: laws are compared where they are given the same."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from studies.a8_fair_comparison.conditions import Computed, Scenario
from studies.a8_fair_comparison.laws import LAWS, PROPOSED, I, Law, Numbers, Sought, diagonal
from studies.paper.card import CARD
from studies.paper.laws import ARM
from workbench.controllers import WithCompensation
from workbench.loop import AbstractController, AbstractObserver
from workbench.observers import FullState, Luenberger, MomentumObserver, OracleFilter, VelocityFilter, WithDisturbance
from workbench.study.uncertainty.factors import Factor

Position = tuple[float, float]


@dataclass(frozen=True)
class Given:
    """What stands between the instruments and a law.

    Attributes
    ----------
    key
        Part of the names of files.
    name
        As the head of a column.
    make
        From its numbers by name and the arm's first position to the observer.
    estimates_d
        Whether D_hat is estimated, and therefore added to the torque of each law.
    """

    key: str
    name: str
    words: str
    make: Callable[[Numbers, Position], AbstractObserver]
    tuned: tuple[Sought, ...] = ()
    estimates_d: bool = False


def luenberger(x: Numbers, start: Position) -> Luenberger:
    """(10) in Cayley steps, from the position that a first reading without noise gives."""
    return Luenberger(ARM, x["L1"] * I, x["L2"] * I, q_hat=start, integrator="cayley")


def gains(path: str) -> tuple[Sought, Sought]:
    """The gains of (10) below a path."""
    return (
        Sought("L1", diagonal(f"{path}.L1"), 1.0, 400.0, 30.0, "1/s"),
        Sought("L2", diagonal(f"{path}.L2"), 50.0, 40000.0, 50.0, "1/s^2"),
    )


CUT_OFF = Sought(
    "omega", ("observer.omega",), 10.0, 1000.0, 200.0, "rad/s", (0.01, 10000.0), "the filter passes what it reads on"
)
PACE = Sought("l", ("observer.disturbance.l",), 1.0, 100.0, CARD["l"], "1/s")
READINGS = Given("readings", "raw readings", "positions and velocities as read", lambda x, start: FullState(2))
FILTER = Given(
    "filter",
    "filtered velocity",
    "positions as read, velocities through a filter of first order",
    lambda x, start: VelocityFilter(2, x["omega"]),
    (CUT_OFF,),
)
OBSERVER = Given("observer", "observer (10)", "positions, and observer (10)", luenberger, gains("observer"))
BOTH = Given(
    "both",
    "observer (10) and D_hat",
    "positions, observer (10), and an observer of the momentum for D",
    lambda x, start: WithDisturbance(luenberger(x, start), MomentumObserver(ARM, x["l"])),
    (*gains("observer.state"), PACE),
    estimates_d=True,
)
ORACLE = Given(
    "oracle",
    "oracle",
    "positions, observer (10), and the true disturbance through a filter: (24) as repaired",
    lambda x, start: WithDisturbance(luenberger(x, start), OracleFilter(2, x["l"])),
    (*gains("observer.state"), PACE),
    estimates_d=True,
)
GIVEN = (READINGS, FILTER, OBSERVER, BOTH)  # from what an instrument gives


@dataclass(frozen=True)
class Entrant:
    """A law behind what it is given, with all numbers that are tuned."""

    law: Law
    given: Given

    @property
    def name(self) -> str:
        """That of the law: within a table all laws are given the same."""
        return self.law.name

    @property
    def key(self) -> str:
        """Part of the names of files."""
        return f"{''.join(c if c.isalnum() else '_' for c in self.law.name.lower())}_{self.given.key}"

    @property
    def compensated(self) -> bool:
        """Whether D_hat is added to the torque of the law from outside."""
        return self.given.estimates_d and not self.law.counts_on_d

    @property
    def tuned(self) -> tuple[Sought, ...]:
        """The numbers of the law, then those of what stands before it."""
        own = tuple(
            replace(one, paths=tuple(path.replace("controller.", "controller.law.") for path in one.paths))
            if self.compensated
            else one
            for one in self.law.tuned
        )
        return (*own, *self.given.tuned)

    @property
    def factors(self) -> tuple[Factor, ...]:
        """What a tuning varies."""
        return tuple(one.factor for one in self.tuned)

    @property
    def starts(self) -> dict[str, tuple[float, float]]:
        """Where a search begins."""
        return {one.name: (one.low, one.high) for one in self.tuned}

    @property
    def physical(self) -> dict[tuple[str, str], str]:
        """The limits that are physical, in words."""
        return {(one.name, end): one.why for one in self.tuned if one.ends for end in ("low", "high")}

    @property
    def card(self) -> dict[str, float]:
        """The numbers of the card."""
        return {one.name: one.card for one in self.tuned}

    def loop(self, scenario: Scenario, numbers: Mapping[str, float]) -> Computed:
        """The law with these numbers in a scenario."""
        law: AbstractController = self.law.make(numbers)
        observer = self.given.make(numbers, scenario.start)
        return scenario.loop(observer, WithCompensation(law) if self.compensated else law)


ENTRANTS = {given.key: tuple(Entrant(law, given) for law in LAWS) for given in GIVEN}
PROPOSAL = next(one for one in ENTRANTS[BOTH.key] if one.law.name == PROPOSED)
TOLD = Entrant(PROPOSAL.law, ORACLE)
ALL = (*(one for entrants in ENTRANTS.values() for one in entrants), TOLD)

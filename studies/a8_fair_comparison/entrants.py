"""All that a law is given in a8, and each law behind it: laws are compared where they are given the same."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from studies.a8_fair_comparison.conditions import Scenario, first_estimates
from studies.a8_fair_comparison.laws import DIAGONAL, LAWS, PROPOSED, Law, Sought, one
from studies.paper.card import CARD
from studies.paper.computed_loop import ComputedLoop
from studies.paper.laws import ARM
from workbench.controllers import WithCompensation
from workbench.loop import AbstractObserver
from workbench.observers import FullState, Luenberger, MomentumObserver, VelocityFilter, WithDisturbance

T = TypeVar("T")


@dataclass(frozen=True)
class Given:
    """All that stands between the instruments and a law: in files by its `key`, in columns by its `name`."""

    key: str
    name: str
    words: str
    observer: AbstractObserver
    tuned: tuple[Sought, ...] = ()


def gains(path: str) -> tuple[Sought, Sought]:
    """The gains of (10) below a path."""
    return (
        one(f"{path}.L1", 1.0, 400.0, "1/s", DIAGONAL),
        one(f"{path}.L2", 50.0, 40000.0, "1/s^2", DIAGONAL),
    )


PASSES = "the filter passes what it reads on"
LUENBERGER = Luenberger(ARM, CARD["L1"], CARD["L2"], q_hat=(0.0, 0.0), integrator="cayley")
ALL_GAINS = (*gains("observer.state"), one("observer.disturbance.l", 1.0, 100.0, "1/s"))
READINGS = Given("readings", "raw readings", "positions and velocities as read", FullState(2))
FILTER = Given(
    "filter",
    "filtered velocity",
    "positions as read, velocities through a filter of first order",
    VelocityFilter(2, 200.0),
    (one("observer.omega", 10.0, 1000.0, "rad/s", ends=(0.01, 10000.0), why=PASSES),),
)
OBSERVER = Given("observer", "observer (10)", "positions, and observer (10)", LUENBERGER, gains("observer"))
BOTH = Given(
    "both",
    "observer (10) and D_hat",
    "positions, observer (10), and an observer of the momentum for D",
    WithDisturbance(LUENBERGER, MomentumObserver(ARM, CARD["l"])),
    ALL_GAINS,
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
        return f"{''.join(c if c.isalnum() else '_' for c in self.law.name.lower())}_{self.given.key}"

    @property
    def compensated(self) -> bool:
        """True if D_hat is estimated, and added to the torque of the law from outside."""
        return isinstance(self.given.observer, WithDisturbance) and not self.law.counts_on_d

    @property
    def tuned(self) -> tuple[Sought, ...]:
        """The numbers of the law, then those of what stands before it."""
        inside = "controller.law." if self.compensated else "controller."
        own = (
            replace(sought, paths=tuple(path.replace("controller.", inside) for path in sought.paths))
            for sought in self.law.tuned
        )
        return (*own, *self.given.tuned)

    def loop(self, scenario: Scenario, numbers: Mapping[str, float] | None = None) -> ComputedLoop:
        """The law with these numbers in a scenario, or with those that a1 assumes."""
        law = WithCompensation(self.law.block) if self.compensated else self.law.block
        observer = self.given.observer
        for path in first_estimates(observer):
            observer = with_number(observer, path, scenario.start)
        blocks = {"controller": law, "observer": observer}
        for sought in self.tuned if numbers else ():
            for path in sought.paths:
                block, _, inside = path.partition(".")
                blocks[block] = with_number(blocks[block], inside, numbers[sought.name])
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


ENTRANTS = {given.key: tuple(Entrant(law, given) for law in LAWS) for given in GIVEN}
PROPOSAL = next(entrant for entrant in ENTRANTS[BOTH.key] if entrant.name == PROPOSED)
ALL = tuple(entrant for entrants in ENTRANTS.values() for entrant in entrants)

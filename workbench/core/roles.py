"""Roles: what the law of a loop is given, as its equations say."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias

from workbench.validation.doors import door

Information: TypeAlias = tuple[tuple[str, ...], tuple[str, ...], bool, bool, bool]


@dataclass(frozen=True)
@door
class Roles:
    """What the command of a loop depends on, directly or by way of any memory.

    Attributes
    ----------
    law, observer
        What they are called; '' where there is no observer.
    positions, velocities
        'read' where a reading acts at its own instant, 'filtered' where it acts by the memory of the observer alone,
        and 'estimated' where the observer's estimate stands for a quantity that it does not read.
    reference
        Of 'q_ref', 'qd_ref' and 'qdd_ref' those that the command depends on.
    models
        By the path of each model of the arm, which of its 'M', 'C' and 'G' the command depends on: none of them where
        a model is given and not used.
    disturbance
        Whether an estimate of the disturbance acts.
    oracle
        Whether the true disturbance acts, which no instrument gives.
    law_states, observer_states
        How many numbers each remembers.
    """

    law: str
    observer: str
    positions: tuple[Literal["read", "filtered", "estimated"], ...]
    velocities: tuple[Literal["read", "filtered", "estimated"], ...]
    reference: tuple[str, ...]
    models: Mapping[str, tuple[str, ...]]
    disturbance: bool
    oracle: bool
    law_states: int
    observer_states: int

    @property
    def unused(self) -> tuple[str, ...]:
        """The paths of models that are given and act on nothing."""
        return tuple(path for path, matrices in self.models.items() if not matrices)

    @property
    def information(self) -> Information:
        """What a comparison must hold equal: how positions and velocities come, model, disturbance and oracle."""
        return self.positions, self.velocities, any(self.models.values()), self.disturbance, self.oracle


@door
def same_information(a: Roles, b: Roles) -> bool:
    """Whether two laws are given the same: only then may a comparison call one of them the better law."""
    return a.information == b.information


@door
def grouped(roles: Mapping[str, Roles]) -> tuple[tuple[str, ...], ...]:
    """The laws in classes of equal information, each in the order in which they came."""
    classes: dict[Information, list[str]] = {}
    for law, held in roles.items():
        classes.setdefault(held.information, []).append(law)
    return tuple(map(tuple, classes.values()))

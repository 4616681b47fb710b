"""Roles: the information that the law of a loop acts on, as its equations show."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias

from workbench.validation.signatures import door

Way: TypeAlias = Literal["read", "filtered", "estimated"]
Information: TypeAlias = tuple[tuple[tuple[str, tuple[Way, ...]], ...], bool, bool, bool]


@dataclass(frozen=True)
@door
class Roles:
    """The information that the command of a loop depends on, directly or through any memory.

    Attributes
    ----------
    law, observer
        What they are called; '' where there is no observer.
    readings
        By the name of each output of the plant: 'read' where a reading acts at its own instant, 'filtered'
        where it acts by a memory of that output alone, and 'estimated' where an estimate from other readings, too,
        stands for it; nothing where it does not act.
    reference
        Of the wanted signals, 'q_ref' for that of q, those that the command depends on.
    models
        By the path of each model of the arm, which of its 'M', 'C' and 'G' the command depends on, and by that of a
        model of any other plant 'f', its equations, where it does: none of them where a model is given and not used.
    unread
        The signals which no instrument gives, a disturbance among them, of which an estimate acts.
    truths
        Of those, the ones that act themselves.
    law_states, observer_states
        How many numbers each remembers.
    """

    law: str
    observer: str
    readings: Mapping[str, tuple[Way, ...]]
    reference: tuple[str, ...]
    models: Mapping[str, tuple[str, ...]]
    unread: tuple[str, ...]
    truths: tuple[str, ...]
    law_states: int
    observer_states: int

    @property
    def information(self) -> Information:
        """The way of each output, and the use of a model, an estimated disturbance or the truth."""
        return tuple(self.readings.items()), any(self.models.values()), bool(self.unread), bool(self.truths)


@door
def grouped(roles: Mapping[str, Roles]) -> tuple[tuple[str, ...], ...]:
    """The laws in classes of equal information, within which a comparison is fair."""
    classes: dict[Information, list[str]] = {}
    for law, held in roles.items():
        classes.setdefault(held.information, []).append(law)
    return tuple(map(tuple, classes.values()))

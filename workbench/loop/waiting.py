"""Commands that wait: a transport delay of whole periods, exact in a computer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import casadi as ca

from workbench.core import Layout, Signals
from workbench.core.port import one_entry
from workbench.validation.refusals import as_number, known, refusal

NEXT = "hold.next"  # the commands that wait for the next instant; 'hold.next.2' those for the one behind it
MOST_PERIODS = 1000  # each is a state for every input


@dataclass(frozen=True)
class Queue:
    """The commands of a computer on their way to the plant, a place for each instant that they still wait.

    Attributes
    ----------
    inputs
        Those of the plant.
    periods
        How many of them the command of each input waits; 0 for one that acts at once.
    """

    inputs: Layout
    periods: Mapping[str, int]

    @staticmethod
    def of(inputs: Layout, delay: bool | float | Mapping[str, float]) -> Queue:
        """The queue of `ClosedLoop.digital(delay=...)`: so many periods of all inputs, or of those that are named.

        Raises
        ------
        ValueError
            If a number of periods is not whole, negative or more than 1000.
        LookupError
            If a name is no input of the plant.
        """
        if not isinstance(delay, Mapping):
            return Queue(inputs, dict.fromkeys(inputs.names, _periods(float(delay))))
        named = {known(name, inputs.names, "inputs of the plant"): _periods(count) for name, count in delay.items()}
        return Queue(inputs, dict.fromkeys(inputs.names, 0) | named)

    @cached_property
    def places(self) -> dict[str, Layout]:
        """The inputs that have each place, by the name of its state, from the next instant on."""
        waits = range(1, max(self.periods.values(), default=0) + 1)
        entries = {i: tuple(e for e in self.inputs.entries if self.periods[e.name] >= i) for i in waits}
        return {NEXT if i == 1 else f"{NEXT}.{i}": Layout(held) for i, held in entries.items()}

    @property
    def memory(self) -> Layout:
        """A state for each place, which starts as the inputs of the plant do."""
        return Layout(tuple(replace(one_entry(held, name), default=held.default) for name, held in self.places.items()))

    def last(self, x: Mapping[str, ca.SX]) -> dict[str, ca.SX]:
        """What was commanded last to each input that waits."""
        held: dict[str, ca.SX] = {}
        for name, inputs in self.places.items():
            held |= inputs.view(x[name])  # a place further behind holds a later command
        return held

    def moved(self, x: Mapping[str, ca.SX], u: Signals) -> tuple[Signals, dict[str, ca.SX]]:
        """What acts from this instant on, where u is commanded, and what waits then, by the name of its state."""
        acts, moved = u, {}
        for name, inputs in reversed(self.places.items()):
            moved[name] = ca.vertcat(*(acts[each] for each in inputs.names))
            acts = acts | inputs.view(x[name])
        return acts, moved


def _periods(count: object) -> int:
    """A whole number of periods, or a refusal that says what to do."""
    clean = as_number(count)
    if clean is None or not (0 <= clean <= MOST_PERIODS and clean == round(clean)):
        raise refusal(
            "ClosedLoop.digital(delay=...)",
            f"a whole number of periods from 0 to {MOST_PERIODS}, as a computer commands at its instants",
            count,
            ": take a period that divides the delay, or a `PadeDelay` of `Equipped`",
        )
    return round(clean)

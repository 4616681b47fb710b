"""The queue of commands on their way from the computer to the plant."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Signals
from workbench.core.port import one_entry
from workbench.core.validation.refusals import as_array, as_number, known_name, refusal

NEXT = "hold.next"  # the commands that wait for the next instant; 'hold.next.2' those for the one behind it
MOST_PERIODS = 1000  # each is a state for every input


@dataclass(frozen=True)
class Queue:
    """The commands on their way to the plant, a place for each of the `periods` that an input waits."""

    inputs: Layout  # their defaults are the commands that wait at the start
    periods: Mapping[str, int]

    @staticmethod
    def of(
        inputs: Layout, delay: bool | float | Mapping[str, float], initial_commands: Mapping[str, object] | None = None
    ) -> Queue:
        """The queue of `ClosedLoop.digital(delay=..., initial_commands=...)`."""
        if isinstance(delay, Mapping):
            named = {
                known_name(name, inputs.names, "inputs of the plant"): _periods(count) for name, count in delay.items()
            }
            periods = dict.fromkeys(inputs.names, 0) | named
        else:
            periods = dict.fromkeys(inputs.names, _periods(float(delay)))
        first = {
            known_name(name, inputs.names, "inputs of the plant"): value
            for name, value in (initial_commands or {}).items()
        }
        if idle := [name for name in first if not periods[name]]:
            raise ValueError(
                f"`ClosedLoop.digital(initial_commands=...)` is for commands that wait, and '{idle[0]}' acts at once: "
                "leave it out, or give it a `delay`."
            )
        return Queue(Layout(tuple(_first_command(entry, first) for entry in inputs.entries)), periods)

    @cached_property
    def places(self) -> dict[str, Layout]:
        """The inputs that have each place, by the name of its state, from the next instant on."""
        waits = range(1, max(self.periods.values(), default=0) + 1)
        entries = {i: tuple(e for e in self.inputs.entries if self.periods[e.name] >= i) for i in waits}
        return {NEXT if i == 1 else f"{NEXT}.{i}": Layout(held) for i, held in entries.items()}

    @property
    def memory(self) -> Layout:
        """A state for each place, which starts as the inputs do."""
        return Layout(tuple(replace(one_entry(held, name), default=held.default) for name, held in self.places.items()))

    def last(self, x: Mapping[str, ca.SX]) -> dict[str, ca.SX]:
        """The last command to each input that waits."""
        held: dict[str, ca.SX] = {}
        for name, inputs in self.places.items():
            held |= inputs.view(x[name])  # a place further behind holds a later command
        return held

    def shift(self, x: Mapping[str, ca.SX], u: Signals) -> tuple[Signals, dict[str, ca.SX]]:
        """The commands that act from this instant on, where u is commanded, and those that wait, by their states."""
        acts, moved = u, {}
        for name, inputs in reversed(self.places.items()):
            moved[name] = ca.vertcat(*(acts[each] for each in inputs.names))
            acts = acts | inputs.view(x[name])
        return acts, moved


def _first_command(entry: Entry, first: Mapping[str, object]) -> Entry:
    """The entry of an input with the command that waits at the start as its default."""
    if entry.name not in first:
        return entry
    value = as_array(first[entry.name])
    one = value is not None and value.size == 1  # for all numbers of the input, or of an input that is one number
    if value is None or not (one or value.shape == entry.shape) or not np.isfinite(value).all():
        must = f"finite numbers of the shape {entry.shape} of '{entry.name}', or one for all"
        raise refusal("ClosedLoop.digital(initial_commands=...)", must, first[entry.name])
    return replace(entry, default=np.full(entry.shape, value.item()) if one else value)


def _periods(count: object) -> int:
    clean = as_number(count)
    if clean is None or not (0 <= clean <= MOST_PERIODS and clean == round(clean)):
        must = f"a whole number of periods from 0 to {MOST_PERIODS}, as a computer commands at its instants"
        advice = ": take a period that divides the delay, or a `PadeDelay` of `EquippedPlant`"
        raise refusal("ClosedLoop.digital(delay=...)", must, count, advice)
    return round(clean)

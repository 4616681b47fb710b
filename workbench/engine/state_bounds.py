"""States that pass the bounds of their block: their extremes over all steps of a run, and a sentence for each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, StepMap
from workbench.core.validation.notebook_display import short_list
from workbench.core.validation.refusals import Array, Integers

NEVER = -1.0  # the number of the first step beyond the bounds, where there is none
START = 1e300  # of a running minimum, and with a minus of a maximum: infinity would be NaN where it meets a zero
STARTS = {"low": START, "high": -START, "beyond": NEVER}
WATCH = "watch of"  # the prefix of the memories


@dataclass(frozen=True, eq=False)
class StateExtremes:
    """The least and largest numbers (B, m) of m states with bounds over all steps, of a step of length h [s].

    `beyond` (B, m) is the number of the first step at which a number of a state is beyond its bounds, or -1.
    """

    system: str
    entries: tuple[Entry, ...]
    h: float
    low: Array
    high: Array
    beyond: Array

    @staticmethod
    def of_kept(step: StepMap, first: int, stride: int, x: Array) -> StateExtremes:
        """The extremes of states x (B, N, nx) that are kept every `stride` steps from the step number `first` on."""
        entries = bounded_entries(step.states)
        low, high = np.full((2, len(x), len(entries)), np.nan)
        beyond = np.full((len(x), len(entries)), NEVER)
        for i, entry in enumerate(entries):
            part = x[..., step.states.slice(entry.name)]
            low[:, i] = np.fmin.reduce(part, axis=(1, 2), initial=START)
            high[:, i] = np.fmax.reduce(part, axis=(1, 2), initial=-START)
            passes = np.asarray(((part < entry.bounds.low) | (part > entry.bounds.high)).any(axis=2))
            beyond[:, i] = np.where(passes.any(axis=1), first + stride * passes.argmax(axis=1), NEVER)
        return StateExtremes(step.flow.name, entries, step.h, low, high, beyond)

    @staticmethod
    def of_totals(step: StepMap, states: Layout, layout: Layout, totals: Array) -> StateExtremes:
        """The extremes of some states from `totals` (B, a) of a layout with their memories; none of lost runs."""
        entries, columns = bounded_entries(states), []
        for end, start in STARTS.items():
            values = totals[:, [layout.slice(_name(entry, end)).start for entry in entries]]
            columns.append(np.where(np.isnan(values), start, values))
        return StateExtremes(step.flow.name, entries, step.h, *columns)

    @staticmethod
    def of_runs(step: StepMap, first: int, stride: int, x: Array) -> StateExtremes:
        """The extremes of states x (B, N, nx) that are kept every `stride` steps, at all steps if these are watched."""
        kept = StateExtremes.of_kept(step, first, stride, x)
        if not kept.entries or watch_memory(step.states).names[0] not in step.states:
            return kept
        return StateExtremes.of_totals(step, step.states, step.states, x[:, -1]).with_later(kept)

    def with_later(self, later: StateExtremes) -> StateExtremes:
        """The extremes with those of later steps."""
        beyond = np.where(self.beyond == NEVER, later.beyond, self.beyond)
        low, high = np.fmin(self.low, later.low), np.fmax(self.high, later.high)
        return replace(self, low=low, high=high, beyond=beyond)

    def only(self, runs: Integers) -> StateExtremes:
        """The extremes of some runs."""
        return replace(self, low=self.low[runs], high=self.high[runs], beyond=self.beyond[runs])

    @property
    def runs_beyond(self) -> Array:
        """(B,), true for each run in which a state passes its bounds."""
        return np.asarray((self.beyond != NEVER).any(axis=1))

    @property
    def sentences(self) -> tuple[str, ...]:
        """A sentence for each state that passes its bounds, with the runs, the first time and the farthest value."""
        return tuple(self._sentence(i) for i in range(len(self.entries)) if (self.beyond[:, i] != NEVER).any())

    def _sentence(self, i: int) -> str:
        entry, steps = self.entries[i], self.beyond[:, i]
        runs = np.flatnonzero(steps != NEVER)
        first = int(runs[np.argmin(steps[runs])])
        above, below = self.high[runs, i] - entry.bounds.high, entry.bounds.low - self.low[runs, i]
        farthest = int(np.argmax(np.maximum(above, below)))
        is_above = above[farthest] >= below[farthest]
        value = (self.high if is_above else self.low)[runs[farthest], i]
        bound = entry.bounds.high if is_above else entry.bounds.low
        which = f" in {len(runs)} of {len(steps)} runs ({short_list(list(map(str, runs)))}), in run {first} first,"
        return (
            f"'{entry.name}' of '{self.system}' passes its bound of {bound:.3g}{which if len(steps) > 1 else ''} at "
            f"{steps[first] * self.h:.4g} s, and reaches {value:.3g}"
        )


def bounded_entries(states: Layout) -> tuple[Entry, ...]:
    """The states of which a bound is declared."""
    return tuple(entry for entry in states.entries if np.isfinite([entry.bounds.low, entry.bounds.high]).any())


def watch_memory(states: Layout) -> Layout:
    """The memories that watch the states with bounds: least number, largest number, first step beyond the bounds."""
    entries = bounded_entries(states)
    return Layout(tuple(Entry(_name(e, end), np.array(start)) for e in entries for end, start in STARTS.items()))


def watch_update(states: Layout, k: ca.SX, x: ca.SX, z: ca.SX) -> ca.SX:
    """The memories after a step number k from the states x (nx, 1); what is no number changes nothing."""
    after: list[ca.SX] = []
    for entry, memory in zip(bounded_entries(states), _triples(z), strict=True):
        low, high, beyond = memory
        passes, least, most = ca.SX(0), entry.bounds.low, entry.bounds.high
        for number in ca.vertsplit(x[states.slice(entry.name)]):
            low, high = ca.if_else(number < low, number, low), ca.if_else(number > high, number, high)
            passes = ca.logic_or(passes, number < least) if least > -np.inf else passes
            passes = ca.logic_or(passes, number > most) if most < np.inf else passes
        after += [low, high, ca.if_else(ca.logic_and(beyond < 0, passes), k, beyond)]
    return ca.vertcat(ca.SX(0, 1), *after)


def with_watch(step: StepMap) -> StepMap:
    """The step with the memories that watch its states, if any of these have bounds and no memories yet."""
    memory = watch_memory(step.states)
    if not memory.size or memory.names[0] in step.states:
        return step
    symbols = memory.symbols()
    return step.with_memory(memory, symbols, watch_update(step.states, step.rule.k, step.rule.x, symbols))


def _triples(z: ca.SX) -> Sequence[tuple[ca.SX, ...]]:
    numbers = ca.vertsplit(z) if z.numel() else []
    return [tuple(numbers[i : i + 3]) for i in range(0, len(numbers), 3)]


def _name(entry: Entry, end: str) -> str:
    return f"{WATCH} {entry.name}: {end}"

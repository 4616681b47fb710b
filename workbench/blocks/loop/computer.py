"""The computer of a loop: what it remembers, and what it does at a sampling instant."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import dataclass
from typing import NamedTuple

import casadi as ca
import numpy as np

from workbench.blocks.loop import wiring
from workbench.blocks.loop.command_queue import Queue
from workbench.blocks.loop.contracts import AbstractMember, Parts, euler, is_recursion
from workbench.blocks.loop.environment import AbstractInstruments
from workbench.blocks.loop.injected_signals import InjectedSignals
from workbench.blocks.loop.wiring import Blocks
from workbench.core import Entry, Layout, Signals
from workbench.core.crossing import Crossing
from workbench.core.validation.refusals import MOST

LARGEST = float(np.finfo(float).max)


def periods_of(block: AbstractMember, period: float) -> int:
    """The number of the computer's periods in one of a block that has its own."""
    if block.period is None:
        return 1
    count = block.period / period
    if not round(min(count, MOST)) >= 1 or abs(count - round(min(count, MOST))) > 1e-6:
        raise ValueError(
            f"`ClosedLoop.digital(period=...)` must divide the period of each block: `{type(block).__name__}` runs "
            f"once in {block.period:g} s, which is no whole multiple of {period:g} s."
        )
    times: int = round(count)
    return times


def held_signals(loop: Blocks, every: Mapping[str, int], queue: Queue) -> Layout:
    """The signals, beside the memories, that a computer holds from one instant to the next."""
    inputs = loop.plant.inputs
    commands = is_recursion(loop.plant) or (every["controller"] > 1 and not all(queue.periods.values()))
    estimates = Layout(tuple(Entry(f"{e.name}_hat", e.default, e.unit) for e in loop.observer.gives.entries))
    return (
        queue.memory
        + (inputs.with_prefix("hold.") if commands else Layout())
        + (estimates.with_prefix("hold.") if every["observer"] > 1 else Layout())
    )


def kept_estimates(loop: Blocks, every: Mapping[str, int]) -> Layout:
    """The estimates whose record keeps the last finite number, as the law answers others by its safe command.

    A run ends at a state that is not finite, and a record is a state.
    """
    if every["observer"] > 1 or not answers_missing(loop):
        return Layout()
    return Layout(tuple(Entry(f"hold.{e.name}_hat", e.default, e.unit) for e in loop.observer.gives.entries))


def answers_missing(loop: Blocks) -> bool:
    """True if the law of a loop has a safe command for numbers that are not finite."""
    return getattr(loop.controller, "safe_command", None) is not None


def units_of(loop: Blocks) -> dict[str, str]:
    """The units of the signals that are held, by their states."""
    true = {entry.name: entry.unit for entry in (loop.plant.outputs + wiring.truths(loop)).entries}
    return {
        **{f"hold.{name}": unit for name, unit in loop.controller.signal_units.items()},
        **{f"hold.{entry.name}_hat": true.get(entry.name, entry.unit) for entry in loop.observer.gives.entries},
        **{f"hold.{entry.name}": entry.unit for entry in loop.plant.inputs.entries},
    }


class ComputerSignals(NamedTuple):
    """The signals of a computer at an instant, in the order in which it makes them."""

    est: Signals  # estimates
    law_commands: Signals  # commands of the law
    limited_commands: Signals  # the same within the limits of the instruments
    acts: Signals  # those that act from this instant on
    queued_commands: dict[str, ca.SX]  # those on their way, by the places of the queue
    next_memories: Mapping[str, Signals]  # the memories of observer and law at the next instant
    own: Mapping[str, ca.SX]  # the law's own signals

    @property
    def by_name(self) -> dict[str, ca.SX]:
        """All of them by names of their own, always in the same order."""
        groups = {name: part for name, part in self._asdict().items() if name != "next_memories"}
        return wiring.prefix_names({**groups, **self.next_memories})

    def as_numbers(self) -> tuple[ComputerSignals, Crossing]:
        """The same signals as numbers for whoever takes them, and the crossing that hands them over."""
        crossing = Crossing.of(self.by_name)
        groups = {name: wiring.strip_prefix(name, crossing.parts) for name in self._fields if name != "next_memories"}
        moved = {socket: Signals(wiring.strip_prefix(socket, crossing.parts)) for socket in self.next_memories}
        signals = {name: Signals(groups[name]) for name in ("est", "law_commands", "limited_commands", "acts")}
        return ComputerSignals(
            **signals, queued_commands=groups["queued_commands"], next_memories=moved, own=groups["own"]
        ), crossing

    def states(self) -> dict[str, ca.SX]:
        """The states at the next instant, but those of the plant: memories, commands on their way, and what is held."""
        holds = {**self.acts, **{f"{name}_hat": part for name, part in self.est.items()}, **self.own}
        return self.queued_commands | wiring.prefix_names({**self.next_memories, "hold": holds})


@dataclass(frozen=True)
class Computer:
    """The computer of a loop at a sampling instant: each block of `every` runs once in so many periods.

    With `fine` = 0 each block moves its memory by the method that it declares.
    """

    loop: Blocks
    instruments: AbstractInstruments
    period: float
    every: Mapping[str, int]
    queue: Queue
    fine: int
    outside: InjectedSignals

    def after(self, k: ca.SX, x: Mapping[str, ca.SX], w: ca.SX) -> tuple[dict[str, ca.SX], tuple[Crossing, ...]]:
        """The states x after the instant t_k, all that the computer remembers and holds, in symbols of the crossings.

        The computer is handed its readings and references as numbers, and hands over numbers: its part of the equations
        is the one that `answer` gives to whoever asks for the law alone.
        """
        crossings, plant = list[Crossing](), wiring.split(x)["plant"]

        def numbers(socket: str, parts: Mapping[str, ca.SX]) -> Signals:
            crossings.append(Crossing.of(wiring.prefix_names({socket: parts})))
            return Signals(wiring.strip_prefix(socket, crossings[-1].parts))

        if is_recursion(self.loop.plant):
            plant = numbers("plant", self._moved_plant(k, k * self.period, plant, x))
        plant, drifts = (
            plant | self.plant_noise_states(k, wiring.prefix_names({"plant": plant}), w),
            self._drifts(k, x, w),
        )
        said = self.reference(k)
        crossings.append(said)
        ref = Signals(wiring.strip_prefix("r", said.parts))
        if self.outside.touches("references"):
            ref = numbers("r", self.outside.inject("references", ref))
        y = self.outside.inject("readings", wiring.measurements(self.loop, k * self.period, plant))
        seen = self.instruments.add_coloured_noise(y.only(self.instruments.reads), drifts)
        y = y | self.instruments.read(seen, w[: self.instruments.noises])
        answer, made = self.answer(k, x, numbers("y", y.only(self.loop.observer.reads)), ref).as_numbers()
        acts = self.outside.inject("inputs", answer.acts)
        own = self.loop.plant
        plant = plant | wiring.call_block(
            own, "update_sampled_states", own.sampled_states, k * self.period, plant, acts
        )
        states = answer.states()
        for name in kept_estimates(self.loop, self.every).names:
            states[name] = ca.if_else(ca.fabs(states[name]) <= LARGEST, states[name], x[name])
        return wiring.prefix_names({"plant": plant, "instruments": drifts}) | states, (*crossings, made)

    def reference(self, k: ca.SX) -> Crossing:
        """The signals that the law follows at t_k, as the reference says them."""
        ref = wiring.reference_signals(self.loop, k * self.period)
        return Crossing.of(wiring.prefix_names({"r": ref.only(self.loop.controller.follows)}))

    def answer(self, k: ca.SX, x: Mapping[str, ca.SX], y: Signals, ref: Signals) -> ComputerSignals:
        """The answer at t_k to readings y and wanted signals."""
        loop, z, t = self.loop, wiring.split(x), k * self.period
        seen, est = wiring.estimates(loop, t, z["observer"], y)
        est = self._unless("observer", k, est, {n: x.get(f"hold.{n}_hat", part) for n, part in est.items()})
        law = loop.controller.run_every(self.every["controller"] * self.period)
        twin = copy(loop)  # in which the law runs at its period
        object.__setattr__(twin, "controller", law)
        asked = wiring.commands(twin, t, z["controller"], est, ref)
        u = asked | self.instruments.limit_commands(asked.only(self.instruments.limits))
        last = {name: x.get(f"hold.{name}", part) for name, part in u.items()} | self.queue.last(x)
        acts, waiting = self.queue.shift(x, self._unless("controller", k, u, last))
        moved = self._next_memories(twin, t, z, seen, est, acts, ref)
        moved = {socket: self._unless(socket, k, Signals(new), z[socket]) for socket, new in moved.items()}
        own = {name: ca.vec(ca.SX(part)) for name, part in wiring.signals(twin, z["controller"], est, ref).items()}
        return ComputerSignals(est, asked, u, acts, waiting, moved, own)

    def _unless(self, socket: str, k: ca.SX, new: Signals, old: Mapping[str, ca.SX]) -> Signals:
        """The new signals of a block where this is one of its instants, and the old ones elsewhere."""
        if self.every[socket] == 1:
            return new
        runs = ca.fmod(k, self.every[socket]) == 0
        return Signals({name: ca.if_else(runs, part, old[name]) for name, part in new.items()})

    def plant_noise_states(self, k: ca.SX, x: Mapping[str, ca.SX], w: ca.SX) -> Signals:
        """The states of the plant that its noise moves at t_k."""
        last = self.instruments.noises + self.instruments.memory.size
        return wiring.noise_states(self.loop.plant, k, wiring.split(x)["plant"], w[last:], self.period)

    def _drifts(self, k: ca.SX, x: Mapping[str, ca.SX], w: ca.SX) -> Signals:
        """The memory of the instruments at t_k."""
        first, size = self.instruments.noises, self.instruments.memory.size
        z = Signals(wiring.strip_prefix("instruments", x))
        return Signals(self.instruments.noise_states(k, z, w[first : first + size], self.period))

    def _moved_plant(self, k: ca.SX, t: ca.SX, z: Signals, x: Mapping[str, ca.SX]) -> Signals:
        """The states of a plant in discrete time after the held command."""
        plant = self.loop.plant
        u = Signals({name: x[f"hold.{name}"] for name in plant.inputs.names})
        new = wiring.call_block(plant, "update", plant.states, t - self.every["plant"] * self.period, z, u)
        runs = k > 0 if self.every["plant"] == 1 else ca.logic_and(k > 0, ca.fmod(k, self.every["plant"]) == 0)
        return Signals({name: ca.if_else(runs, part, z[name]) for name, part in new.items()})

    def _next_memories(
        self,
        loop: Blocks,
        t: ca.SX,
        z: Mapping[str, Signals],
        readings: Signals,
        est: Signals,
        u: Signals,
        ref: Signals,
    ) -> dict[str, Signals]:
        observer, law = loop.observer, loop.controller
        told, heard, followed = u.only(observer.inputs), est.only(law.reads), ref.only(law.follows)

        def observer_rate(own: Signals) -> Mapping[str, ca.SX]:
            _, now = wiring.estimates(loop, t, own, readings)
            return wiring.call_block(observer, "rate", observer.memory, t, own, readings, now, told)

        def law_rate(own: Signals) -> Mapping[str, ca.SX]:
            return wiring.call_block(law, "rate", law.memory, t, own, heard, followed)

        def advance_memory(
            block: AbstractMember, rate: Callable[[Signals], Parts], z: Signals, period: float, *arguments: Signals
        ) -> Signals:
            if self.fine and not is_recursion(block):
                return _fine_steps(rate, z, period, self.fine)
            return wiring.call_block(block, "advance", block.memory, t, z, *arguments, period)

        return {
            "observer": advance_memory(
                observer, observer_rate, z["observer"], self.every["observer"] * self.period, readings, est, told
            ),
            "controller": advance_memory(
                law, law_rate, z["controller"], self.every["controller"] * self.period, heard, followed
            ),
        }


def _fine_steps(rate: Callable[[Signals], Parts], z: Signals, period: float, steps: int) -> Signals:
    """A memory after so many classical Runge-Kutta steps of a period together."""
    h = period / steps
    for _ in range(steps):
        a = rate(z)
        b = rate(Signals(euler(z, a, h / 2)))
        c = rate(Signals(euler(z, b, h / 2)))
        d = rate(Signals(euler(z, c, h)))
        z = Signals(euler(z, {name: a[name] + 2 * b[name] + 2 * c[name] + d[name] for name in a}, h / 6))
    return z

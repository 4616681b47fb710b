"""The computer of a loop: what it remembers, and what it does at a sampling instant."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import dataclass
from typing import Any, NamedTuple

import casadi as ca

from workbench.core import Entry, Layout, Signals
from workbench.loop import wiring
from workbench.loop.command_queue import Queue
from workbench.loop.contracts import Parts, euler, is_recursion
from workbench.loop.injected_signals import Outside
from workbench.loop.surroundings import AbstractInstruments
from workbench.loop.wiring import Blocks
from workbench.validation.refusals import MOST


def periods_of(block: Any, period: float) -> int:
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


def remembered(loop: Blocks, every: Mapping[str, int], queue: Queue) -> Layout:
    """The signals, beside the memories, that a computer holds from one instant to the next."""
    inputs = loop.plant.inputs
    commands = is_recursion(loop.plant) or (every["controller"] > 1 and not all(queue.periods.values()))
    estimates = Layout(tuple(Entry(f"{e.name}_hat", e.default, e.unit) for e in loop.observer.gives.entries))
    return (
        queue.memory
        + (inputs.prefixed("hold.") if commands else Layout())
        + (estimates.prefixed("hold.") if every["observer"] > 1 else Layout())
    )


def units_of(loop: Blocks) -> dict[str, str]:
    """The units of the signals that are held, by their states."""
    true = {entry.name: entry.unit for entry in (loop.plant.outputs + loop.plant.truths).entries}
    return {
        **{f"hold.{name}": unit for name, unit in loop.controller.signal_units.items()},
        **{f"hold.{entry.name}_hat": true.get(entry.name, entry.unit) for entry in loop.observer.gives.entries},
        **{f"hold.{entry.name}": entry.unit for entry in loop.plant.inputs.entries},
    }


class Answer(NamedTuple):
    """The signals of a computer at an instant, in the order in which it makes them."""

    est: Signals  # estimates
    asked: Signals  # commands of the law
    limited: Signals  # the same within the limits of the instruments
    acts: Signals  # those that act from this instant on
    waiting: dict[str, ca.SX]  # those on their way, by the places of the queue
    moved: Mapping[str, Signals]  # the memories of observer and law at the next instant
    own: Mapping[str, ca.SX]  # the law's own signals


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
    outside: Outside

    def after(self, k: ca.SX, x: Mapping[str, ca.SX], w: ca.SX) -> tuple[dict[str, ca.SX], dict[str, ca.SX]]:
        """The states x after the instant t_k, all that the computer remembers and holds; and what it is handed then."""
        t = k * self.period
        plant = self._moved_plant(k, t, wiring.split(x)["plant"], x)
        ref = self.outside.meets("references", wiring.wanted(self.loop, t))
        y = self.outside.meets("readings", wiring.measured(self.loop, t, plant))
        y = y | self.instruments.read(y.only(self.instruments.reads), w)
        answer = self.answer(k, x, y, ref)
        holds = {**answer.acts, **{f"{name}_hat": part for name, part in answer.est.items()}, **answer.own}
        after = answer.waiting | wiring.above({"plant": plant, **answer.moved, "hold": holds})
        taken = wiring.above({"y": y.only(self.loop.observer.reads), "r": ref.only(self.loop.controller.follows)})
        return after, {name: ca.densify(ca.SX(part)) for name, part in taken.items()}

    def answer(self, k: ca.SX, x: Mapping[str, ca.SX], y: Signals, ref: Signals) -> Answer:
        """The answer at t_k to readings y and wanted signals."""
        loop, z, t = self.loop, wiring.split(x), k * self.period
        seen, est = wiring.estimated(loop, t, z["observer"], y)
        est = self._unless("observer", k, est, {n: x.get(f"hold.{n}_hat", part) for n, part in est.items()})
        law = loop.controller.run_every(self.every["controller"] * self.period)
        twin = copy(loop)  # in which the law runs at its period
        object.__setattr__(twin, "controller", law)
        asked = wiring.commanded(twin, t, z["controller"], est, ref)
        u = asked | self.instruments.limited(asked.only(self.instruments.limits))
        last = {name: x.get(f"hold.{name}", part) for name, part in u.items()} | self.queue.last(x)
        acts, waiting = self.queue.moved(x, self._unless("controller", k, u, last))
        moved = self._moved(twin, t, z, seen, est, acts, ref)
        moved = {socket: self._unless(socket, k, Signals(new), z[socket]) for socket, new in moved.items()}
        own = {name: ca.vec(ca.SX(part)) for name, part in wiring.signals(twin, z["controller"], est, ref).items()}
        return Answer(est, asked, u, acts, waiting, moved, own)

    def _unless(self, socket: str, k: ca.SX, new: Signals, old: Mapping[str, ca.SX]) -> Signals:
        """The new signals of a block where this is one of its instants, and the old ones elsewhere."""
        if self.every[socket] == 1:
            return new
        runs = ca.fmod(k, self.every[socket]) == 0
        return Signals({name: ca.if_else(runs, part, old[name]) for name, part in new.items()})

    def _moved_plant(self, k: ca.SX, t: ca.SX, z: Signals, x: Mapping[str, ca.SX]) -> Signals:
        """The states of a plant in discrete time after the held command; those of any other plant as they are."""
        plant = self.loop.plant
        if not is_recursion(plant):
            return z
        u = Signals({name: x[f"hold.{name}"] for name in plant.inputs.names})
        new = wiring.asked(plant, "update", plant.states, t - self.every["plant"] * self.period, z, u)
        runs = k > 0 if self.every["plant"] == 1 else ca.logic_and(k > 0, ca.fmod(k, self.every["plant"]) == 0)
        return Signals({name: ca.if_else(runs, part, z[name]) for name, part in new.items()})

    def _moved(
        self, loop: Blocks, t: ca.SX, z: Mapping[str, Signals], seen: Signals, est: Signals, u: Signals, ref: Signals
    ) -> dict[str, Signals]:
        observer, law = loop.observer, loop.controller
        told, heard, followed = u.only(observer.inputs), est.only(law.reads), ref.only(law.follows)

        def observed(own: Signals) -> Mapping[str, ca.SX]:
            _, now = wiring.estimated(loop, t, own, seen)
            return wiring.asked(observer, "rate", observer.memory, t, own, seen, now, told)

        def adapted(own: Signals) -> Mapping[str, ca.SX]:
            return wiring.asked(law, "rate", law.memory, t, own, heard, followed)

        def moved(block: Any, rate: Callable[[Signals], Parts], z: Signals, period: float, *given: Signals) -> Signals:
            if self.fine and not is_recursion(block):
                return _refined(rate, z, period, self.fine)
            return wiring.asked(block, "advance", block.memory, t, z, *given, period)

        return {
            "observer": moved(observer, observed, z["observer"], self.every["observer"] * self.period, seen, est, told),
            "controller": moved(law, adapted, z["controller"], self.every["controller"] * self.period, heard, followed),
        }


def _refined(rate: Callable[[Signals], Parts], z: Signals, period: float, steps: int) -> Signals:
    """A memory after so many classical Runge-Kutta steps of a period together."""
    h = period / steps
    for _ in range(steps):
        a = rate(z)
        b = rate(Signals(euler(z, a, h / 2)))
        c = rate(Signals(euler(z, b, h / 2)))
        d = rate(Signals(euler(z, c, h)))
        z = Signals(euler(z, {name: a[name] + 2 * b[name] + 2 * c[name] + d[name] for name in a}, h / 6))
    return z

"""A loop that a computer closes: its jump at each sampling instant, and the flow of the plant in between."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Ode, Sampled, Signals, lift
from workbench.core.port import one_entry
from workbench.loop import wiring
from workbench.loop.contracts import Parts, euler, is_recursion
from workbench.loop.injected_signals import Outside, refuse_inputs_of_recursion
from workbench.loop.surroundings import AbstractInstruments
from workbench.loop.wiring import SOCKETS, Blocks
from workbench.validation.refusals import MOST, as_number, known, refusal

FINE = 16  # steps of Runge-Kutta a period: stable up to 44 / period, where (34) at 500 N m and 4 ms has 23

NEXT = "hold.next"  # the commands that wait for the next instant; 'hold.next.2' those for the one behind it
MOST_PERIODS = 1000  # each is a state for every input


def digital(
    loop: Blocks,
    period: float,
    instruments: AbstractInstruments,
    queue: Queue,
    fine: int,
    name: str,
    outside: Outside,
) -> Sampled:
    """The loop as a flow and a jump, see `ClosedLoop.digital`."""
    refuse_inputs_of_recursion(loop, outside)
    wiring.refuse_instruments(loop, instruments)
    every = {socket: _every(getattr(loop, socket), period) for socket in SOCKETS}
    lifted, gauges = lift(loop), lift(instruments, "instruments.")
    remembers = wiring.memory(loop) + _remembered(loop, every, queue)
    k, w = ca.SX.sym("k"), ca.SX.sym("w", instruments.noises)
    x = remembers.symbols()
    computer = Computer(lifted.block, gauges.block, period, every, queue, fine, outside)
    after = {n: ca.densify(ca.SX(part)) for n, part in computer.after(k, remembers.view(x), w).items()}
    units = _units(loop)
    new = [(n, part) for n, part in after.items() if n not in remembers]
    held = Layout(tuple(Entry(n, np.zeros(part.numel()), units.get(n, "")) for n, part in new))
    states, x, t = remembers + held, ca.vertcat(x, held.symbols()), ca.SX.sym("t")
    moves, outputs, watched = _between(lifted.block, queue, t, states.view(x), outside)
    parameters = lifted.layout + gauges.layout + outside.layout
    p = ca.vertcat(lifted.symbols, gauges.symbols, outside.symbols)
    equations = (states.flatten(moves), outputs.flatten(watched))
    flow = Ode(name, states, parameters, outputs, t, x, p, *equations, inputs=outside.layout.names)
    follows = () if outside.cut.size else loop.follows
    flow = replace(flow, notes=wiring.notes(loop), horizon=wiring.horizon(loop), counts=loop.plant.counts)
    drawing = wiring.drawn(lifted.block.plant, t, wiring.split(states.view(x))["plant"], p, parameters)
    flow = replace(flow, follows=follows, drives=loop.plant.inputs.names, drawing=drawing)
    return Sampled(flow, period, k, w, states.flatten(after), _methods(loop, every["controller"] * period, fine))


def _every(block: Any, period: float) -> int:
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


def _remembered(loop: Blocks, every: Mapping[str, int], queue: Queue) -> Layout:
    """The signals, beside the memories, that a computer holds from one instant to the next."""
    inputs = loop.plant.inputs
    commands = is_recursion(loop.plant) or (every["controller"] > 1 and not all(queue.periods.values()))
    estimates = Layout(tuple(Entry(f"{e.name}_hat", e.default, e.unit) for e in loop.observer.gives.entries))
    return (
        queue.memory
        + (inputs.prefixed("hold.") if commands else Layout())
        + (estimates.prefixed("hold.") if every["observer"] > 1 else Layout())
    )


def _units(loop: Blocks) -> dict[str, str]:
    true = {entry.name: entry.unit for entry in (loop.plant.outputs + loop.plant.truths).entries}
    return {
        **{f"hold.{name}": unit for name, unit in loop.controller.signal_units.items()},
        **{f"hold.{entry.name}_hat": true.get(entry.name, entry.unit) for entry in loop.observer.gives.entries},
        **{f"hold.{entry.name}": entry.unit for entry in loop.plant.inputs.entries},
    }


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

    def after(self, k: ca.SX, x: Mapping[str, ca.SX], w: ca.SX) -> dict[str, ca.SX]:
        """The states x after the instant t_k: all that the computer remembers and holds."""
        loop, z, t = self.loop, wiring.split(x), k * self.period
        plant = self._moved_plant(k, t, z["plant"], x)
        ref = self.outside.meets("references", wiring.wanted(loop, t))
        y = self.outside.meets("readings", wiring.measured(loop, t, plant))
        y = y | self.instruments.read(y.only(self.instruments.reads), w)
        seen, est = wiring.estimated(loop, t, z["observer"], y)
        est = self._unless("observer", k, est, {n: x.get(f"hold.{n}_hat", part) for n, part in est.items()})
        law = loop.controller.run_every(self.every["controller"] * self.period)
        twin = copy(loop)  # in which the law runs at its period
        object.__setattr__(twin, "controller", law)
        u = wiring.commanded(twin, t, z["controller"], est, ref)
        u = u | self.instruments.limited(u.only(self.instruments.limits))
        last = {name: x.get(f"hold.{name}", part) for name, part in u.items()} | self.queue.last(x)
        held, waiting = self.queue.moved(x, self._unless("controller", k, u, last))
        moved = self._moved(twin, t, z, seen, est, held, ref)
        moved = {socket: self._unless(socket, k, Signals(new), z[socket]) for socket, new in moved.items()}
        own = {name: ca.vec(ca.SX(part)) for name, part in wiring.signals(twin, z["controller"], est, ref).items()}
        holds = {**held, **{f"{name}_hat": part for name, part in est.items()}, **own}
        return waiting | wiring.above({"plant": plant, **moved, "hold": holds})

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


def _between(
    loop: Blocks, queue: Queue, t: ca.SX, x: Mapping[str, ca.SX], outside: Outside
) -> tuple[dict[str, ca.SX], Layout, dict[str, ca.SX]]:
    """The rates of all states between two instants, where only the plant moves, and the outputs then."""
    plant, z = loop.plant, wiring.split(x)["plant"]
    held = wiring.below("hold", {name: part for name, part in x.items() if name not in queue.places})
    u = Signals({name: held.pop(name) for name in plant.inputs.names})
    acts = outside.meets("inputs", u)
    est = Signals({name: held.pop(f"{name}_hat") for name in loop.observer.gives.names})
    moves = {name: ca.SX.zeros(part.shape) for name, part in x.items()}
    if not is_recursion(plant):
        moves |= wiring.above({"plant": wiring.asked(plant, "rate", plant.states, t, z, acts)})
    y, ref = wiring.measured(loop, t, z), outside.meets("references", wiring.wanted(loop, t))
    if outside.cut.size:
        return moves, outside.cut, {n: ca.densify(ca.SX(part)) for n, part in (y | u).only(outside.cut).items()}
    applied = wiring.asked(plant, "applied", plant.inputs, t, z, acts)
    return moves, *wiring.shown(loop, y, ref, est, u, applied, held)


def _methods(loop: Blocks, period: float, fine: int) -> tuple[str, ...]:
    """The method by which each memory is stepped where the law runs once in `period` seconds, or `fine` steps."""
    by = f"{fine} Runge-Kutta steps a period" if fine else ""
    # as a computer runs them: a law's method may depend on that
    blocks: dict[str, Any] = {"observer": loop.observer, "controller": loop.controller.run_every(period)}
    return tuple(
        f"memory of the {socket}: {own.method if is_recursion(own) or not fine else by}"
        for socket, own in blocks.items()
        if own.memory.size
    )


@dataclass(frozen=True)
class Queue:
    """The commands on their way to the plant, a place for each of the `periods` that an input waits."""

    inputs: Layout
    periods: Mapping[str, int]

    @staticmethod
    def of(inputs: Layout, delay: bool | float | Mapping[str, float]) -> Queue:
        """The queue of `ClosedLoop.digital(delay=...)`: so many periods of all inputs, or of those that are named."""
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
        """A state for each place, which starts as the inputs do."""
        return Layout(tuple(replace(one_entry(held, name), default=held.default) for name, held in self.places.items()))

    def last(self, x: Mapping[str, ca.SX]) -> dict[str, ca.SX]:
        """The last command to each input that waits."""
        held: dict[str, ca.SX] = {}
        for name, inputs in self.places.items():
            held |= inputs.view(x[name])  # a place further behind holds a later command
        return held

    def moved(self, x: Mapping[str, ca.SX], u: Signals) -> tuple[Signals, dict[str, ca.SX]]:
        """The commands that act from this instant on, where u is commanded, and those that wait, by their states."""
        acts, moved = u, {}
        for name, inputs in reversed(self.places.items()):
            moved[name] = ca.vertcat(*(acts[each] for each in inputs.names))
            acts = acts | inputs.view(x[name])
        return acts, moved


def _periods(count: object) -> int:
    clean = as_number(count)
    if clean is None or not (0 <= clean <= MOST_PERIODS and clean == round(clean)):
        must = f"a whole number of periods from 0 to {MOST_PERIODS}, as a computer commands at its instants"
        advice = ": take a period that divides the delay, or a `PadeDelay` of `Equipped`"
        raise refusal("ClosedLoop.digital(delay=...)", must, count, advice)
    return round(clean)

"""Once round a loop that a computer closes: what it does at an instant, and how the plant moves until the next."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Lifted, Ode, Sampled, Signals, lift
from workbench.loop.contracts import Parts, euler, is_recursion
from workbench.loop.matching import refuse_instruments
from workbench.loop.outside import Outside, refuse_inputs_of_recursion
from workbench.loop.surroundings import AbstractInstruments
from workbench.loop.waiting import Queue
from workbench.loop.wiring import (
    Blocks,
    above,
    asked,
    below,
    commanded,
    estimated,
    horizon,
    measured,
    memory,
    methods,
    notes,
    shown,
    signals,
    split,
    wanted,
)
from workbench.validation.refusals import MOST

FINE = 16  # steps of Runge-Kutta a period: stable up to 44 / period, where (34) at 500 N m and 4 ms has 23


def digital(
    loop: Blocks,
    period: float,
    instruments: AbstractInstruments | None,
    queue: Queue,
    fine: int,
    name: str,
    outside: Outside,
) -> Sampled:
    """The loop as a flow and a jump, see `ClosedLoop.digital`."""
    refuse_inputs_of_recursion(loop, outside)
    if instruments is not None:
        refuse_instruments(loop, instruments)
    every = {socket: _every(getattr(loop, socket), period) for socket in ("plant", "observer", "controller")}
    lifted = lift(loop)
    gauges = Lifted(None, Layout(), ca.SX(0, 1)) if instruments is None else lift(instruments, "instruments.")
    remembers = memory(loop) + _remembered(loop, every, queue)
    if instruments is not None:
        remembers += instruments.drifts.prefixed("drift.")
    k, w = ca.SX.sym("k"), ca.SX.sym("w", instruments.noises if instruments is not None else 0)
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
    flow = replace(flow, notes=notes(loop), horizon=horizon(loop), counts=loop.plant.counts)
    flow = replace(flow, follows=follows, drives=loop.plant.inputs.names)
    return Sampled(flow, period, k, w, states.flatten(after), methods(loop, every["controller"] * period, fine))


def _every(block: Any, period: float) -> int:
    """How many periods of the computer make one of a block that has its own."""
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
    """What a computer holds from one instant to the next beside the memories, as something there reads it."""
    inputs = loop.plant.inputs
    commands = is_recursion(loop.plant) or (every["controller"] > 1 and not all(queue.periods.values()))
    estimates = Layout(tuple(_renamed(entry, f"{entry.name}_hat") for entry in loop.observer.gives.entries))
    return (
        queue.memory
        + (inputs.prefixed("hold.") if commands else Layout())
        + (estimates.prefixed("hold.") if every["observer"] > 1 else Layout())
    )


def _renamed(entry: Entry, name: str) -> Entry:
    return Entry(name, entry.default, entry.unit)


def _units(loop: Blocks) -> dict[str, str]:
    """The units of what is held."""
    true = {entry.name: entry.unit for entry in (loop.plant.outputs + loop.plant.truths).entries}
    return {
        **{f"hold.{name}": unit for name, unit in loop.controller.signal_units.items()},
        **{f"hold.{entry.name}_hat": true.get(entry.name, entry.unit) for entry in loop.observer.gives.entries},
        **{f"hold.{entry.name}": entry.unit for entry in loop.plant.inputs.entries},
    }


@dataclass(frozen=True)
class Computer:
    """What a computer does at an instant.

    Attributes
    ----------
    every
        How many periods make one of each block.
    queue
        The commands that wait.
    fine
        Runge-Kutta steps a period through the memories; 0 for the method that each block declares.
    outside
        The signals from outside that meet it.
    """

    loop: Blocks
    instruments: AbstractInstruments | None
    period: float
    every: Mapping[str, int]
    queue: Queue
    fine: int
    outside: Outside

    def after(self, k: ca.SX, x: Mapping[str, ca.SX], w: ca.SX) -> dict[str, ca.SX]:
        """What the states x become at the instant t_k: all that the computer remembers and holds."""
        loop, z, t = self.loop, split(x), k * self.period
        plant = self._moved_plant(k, t, z["plant"], x)
        ref = self.outside.meets("references", wanted(loop, t))
        y = self.outside.meets("readings", measured(loop, t, plant))
        drift = Signals()
        if self.instruments is not None:
            drift = self.instruments.drifted(Signals(below("drift", x)), w, self.period)
            y = y | {name: y[name] + part for name, part in drift.items()}
            y = y | self.instruments.read(y.only(self.instruments.reads), w)
        seen, est = estimated(loop, t, z["observer"], y)
        est = self._unless("observer", k, est, {n: x.get(f"hold.{n}_hat", part) for n, part in est.items()})
        law = loop.controller.run_every(self.every["controller"] * self.period)
        twin = Turn(loop.plant, loop.observer, law, loop.reference)
        u = commanded(twin, t, z["controller"], est, ref)
        if self.instruments is not None:
            u = u | self.instruments.limited(u.only(self.instruments.limits))
        last = {name: x.get(f"hold.{name}", part) for name, part in u.items()} | self.queue.last(x)
        held, waiting = self.queue.moved(x, self._unless("controller", k, u, last))
        moved = self._moved(twin, t, z, seen, est, held, ref)
        moved = {socket: self._unless(socket, k, Signals(new), z[socket]) for socket, new in moved.items()}
        own = signals(twin, z["controller"], est, ref)
        return {
            **above({"plant": plant, **moved}),
            **waiting,
            **above({"drift": drift}),
            **above({"hold": held}),
            **above({"hold": {f"{name}_hat": part for name, part in est.items()}}),
            **above({"hold": {name: ca.vec(ca.SX(part)) for name, part in own.items()}}),
        }

    def _unless(self, socket: str, k: ca.SX, new: Signals, old: Mapping[str, ca.SX]) -> Signals:
        """What a block makes anew where this is one of its instants, and what it was elsewhere."""
        if self.every[socket] == 1:
            return new
        runs = ca.fmod(k, self.every[socket]) == 0
        return Signals({name: ca.if_else(runs, part, old[name]) for name, part in new.items()})

    def _moved_plant(self, k: ca.SX, t: ca.SX, z: Signals, x: Mapping[str, ca.SX]) -> Signals:
        """The states of a plant in discrete time, by the command held until now; others have moved by themselves."""
        plant = self.loop.plant
        if not is_recursion(plant):
            return z
        u = Signals({name: x[f"hold.{name}"] for name in plant.inputs.names})
        new = asked(plant, "update", plant.states, t - self.every["plant"] * self.period, z, u)
        runs = k > 0 if self.every["plant"] == 1 else ca.logic_and(k > 0, ca.fmod(k, self.every["plant"]) == 0)
        return Signals({name: ca.if_else(runs, part, z[name]) for name, part in new.items()})

    def _moved(
        self, loop: Blocks, t: ca.SX, z: Mapping[str, Signals], seen: Signals, est: Signals, u: Signals, ref: Signals
    ) -> dict[str, Mapping[str, ca.SX]]:
        """The memories of observer and law at the end of a period of theirs."""
        observer, law = loop.observer, loop.controller
        told, heard, followed = u.only(observer.inputs), est.only(law.reads), ref.only(law.follows)

        def observed(own: Signals) -> Mapping[str, ca.SX]:
            _, now = estimated(loop, t, own, seen)
            return asked(observer, "rate", observer.memory, t, own, seen, now, told)

        def adapted(own: Signals) -> Mapping[str, ca.SX]:
            return asked(law, "rate", law.memory, t, own, heard, followed)

        lengths = {socket: self.every[socket] * self.period for socket in ("observer", "controller")}
        moved: dict[str, Mapping[str, ca.SX]] = {}
        if self.fine and not is_recursion(observer):
            moved["observer"] = _refined(observed, z["observer"], lengths["observer"], self.fine)
        else:
            moved["observer"] = asked(
                observer, "advance", observer.memory, t, z["observer"], seen, est, told, lengths["observer"]
            )
        if self.fine and not is_recursion(law):
            moved["controller"] = _refined(adapted, z["controller"], lengths["controller"], self.fine)
        else:
            moved["controller"] = asked(
                law, "advance", law.memory, t, z["controller"], heard, followed, lengths["controller"]
            )
        return moved


@dataclass(frozen=True)
class Turn:
    """The blocks of a loop, of which the law runs at its period."""

    plant: Any
    observer: Any
    controller: Any
    reference: Any
    follows: tuple[str, ...] = ()


def _refined(rate: Callable[[Signals], Parts], z: Signals, period: float, steps: int) -> Mapping[str, ca.SX]:
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
    """The rates of all states between two instants, where only the plant moves, and what is watched then."""
    plant, z = loop.plant, split(x)["plant"]
    held = below("hold", {name: part for name, part in x.items() if name not in queue.places})
    u = Signals({name: held.pop(name) for name in plant.inputs.names})
    acts = outside.meets("inputs", u)
    est = Signals({name: held.pop(f"{name}_hat") for name in loop.observer.gives.names})
    moves = {name: ca.SX.zeros(part.shape) for name, part in x.items()}
    if not is_recursion(plant):
        moves |= above({"plant": asked(plant, "rate", plant.states, t, z, acts)})
    y, ref = measured(loop, t, z), outside.meets("references", wanted(loop, t))
    if outside.cut.size:
        return moves, outside.cut, {n: ca.densify(ca.SX(part)) for n, part in (y | u).only(outside.cut).items()}
    outputs, watched = shown(loop, y, ref, est, u, asked(plant, "applied", plant.inputs, t, z, acts), held)
    return moves, outputs, watched

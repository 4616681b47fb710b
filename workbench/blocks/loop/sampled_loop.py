"""A loop that a computer closes: its jump at each sampling instant, and the flow of the plant in between."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

import casadi as ca
import numpy as np

from workbench.blocks.loop import wiring
from workbench.blocks.loop.command_queue import Queue
from workbench.blocks.loop.computer import Computer, held_signals, kept_estimates, periods_of, units_of
from workbench.blocks.loop.contracts import AbstractMember, is_recursion
from workbench.blocks.loop.environment import AbstractInstruments
from workbench.blocks.loop.injected_signals import InjectedSignals, refuse_inputs_of_recursion
from workbench.blocks.loop.law_extraction import extract_law
from workbench.blocks.loop.port_checks import refuse_instruments
from workbench.blocks.loop.wiring import SOCKETS, Blocks
from workbench.core import Entry, Layout, Ode, SampledSystem, Signals, lift
from workbench.core.crossing import without_crossings
from workbench.core.publications import origins

FINE = 16  # steps of Runge-Kutta a period: stable up to 44 / period, where (34) at 500 N m and 4 ms has 23
INTEGRATORS = ("declared", "fine")


def digital(
    loop: Blocks,
    period: float,
    instruments: AbstractInstruments,
    queue: Queue,
    fine: int,
    name: str,
    outside: InjectedSignals,
) -> SampledSystem:
    """The loop as a flow and a jump, see `ClosedLoop.digital`."""
    refuse_inputs_of_recursion(loop, outside)
    refuse_instruments(loop, instruments)
    every = {socket: periods_of(getattr(loop, socket), period) for socket in SOCKETS}
    lifted, gauges = lift(loop), lift(instruments, "instruments.")
    drifts = instruments.memory.with_prefix("instruments.")
    remembers = wiring.memory(loop) + held_signals(loop, every, queue) + kept_estimates(loop, every) + drifts
    k, w = ca.SX.sym("k"), ca.SX.sym("w", instruments.noises + drifts.size + loop.plant.noises)
    x = remembers.symbols()
    computer = Computer(lifted.block, gauges.block, period, every, queue, fine, outside)
    answer, crossings = computer.after(k, remembers.view(x), w)
    stirred = (*drifts.names, *wiring.prefix_names({"plant": computer.plant_noise_states(k, remembers.view(x), w)}))
    after = {n: ca.densify(ca.SX(part)) for n, part in answer.items()}
    units = units_of(loop)
    new = [(n, part) for n, part in after.items() if n not in remembers]
    held = Layout(tuple(Entry(n, np.zeros(part.numel()), units.get(n, "")) for n, part in new))
    states, x, t = remembers + held, ca.vertcat(x, held.symbols()), ca.SX.sym("t")
    moves, outputs, watched = _between(lifted.block, queue, t, states.view(x), outside)
    parameters = lifted.layout + gauges.layout + outside.layout
    p = ca.vertcat(lifted.symbols, gauges.symbols, outside.symbols)
    equations = (states.flatten(moves), outputs.flatten(watched))
    flow = Ode(name, states, parameters, outputs, t, x, p, *equations, inputs=outside.layout.names)
    follows = () if outside.cut_signals.size else loop.follows
    flow = replace(flow, notes=wiring.notes(loop), horizon=wiring.horizon(loop), counts=loop.plant.counts)
    drawing = wiring.plant_drawing(lifted.block.plant, t, wiring.split(states.view(x))["plant"], p, parameters)
    flow = replace(flow, follows=follows, drives=loop.plant.inputs.names, drawing=drawing)
    flow = replace(flow, measures=wiring.measures(loop), differences=wiring.differences(loop), power=wiring.power(loop))
    flow = replace(flow, origins=tuple(dict.fromkeys(origins(loop) + origins(instruments))))
    methods = _methods(loop, every["controller"] * period, fine)
    law = partial(extract_law, loop, period, instruments, queue, fine)
    crossed = states.flatten(after)
    return SampledSystem(
        flow, period, k, w, without_crossings(crossings, crossed), methods, law, crossings, crossed, stirred
    )


def _between(
    loop: Blocks, queue: Queue, t: ca.SX, x: Mapping[str, ca.SX], outside: InjectedSignals
) -> tuple[dict[str, ca.SX], Layout, dict[str, ca.SX]]:
    """The rates of all states between two instants, where only the plant moves, and the outputs then."""
    plant, z = loop.plant, wiring.split(x)["plant"]
    held = wiring.strip_prefix("hold", {name: part for name, part in x.items() if name not in queue.places})
    u = Signals({name: held.pop(name) for name in plant.inputs.names})
    acts = outside.inject("inputs", u)
    est = Signals({name: held.pop(f"{name}_hat") for name in loop.observer.gives.names})
    moves = {name: ca.SX.zeros(part.shape) for name, part in x.items()}
    if not is_recursion(plant):
        moves |= wiring.prefix_names({"plant": wiring.call_block(plant, "rate", plant.states, t, z, acts)})
    y, ref = wiring.measurements(loop, t, z), outside.inject("references", wiring.reference_signals(loop, t))
    applied = wiring.call_block(plant, "applied_inputs", plant.inputs, t, z, acts)
    return moves, *outside.outputs(y | u, lambda: wiring.loop_outputs(loop, y, ref, est, u, applied, held))


def _methods(loop: Blocks, period: float, fine: int) -> tuple[str, ...]:
    """The method by which each memory is stepped where the law runs once in `period` seconds, or `fine` steps."""
    by = f"{fine} Runge-Kutta steps a period" if fine else ""
    # as a computer runs them: a law's method may depend on that
    blocks: dict[str, AbstractMember] = {"observer": loop.observer, "controller": loop.controller.run_every(period)}
    return tuple(
        f"memory of the {socket}: {own.method if is_recursion(own) or not fine else by}"
        for socket, own in blocks.items()
        if own.memory.size
    )

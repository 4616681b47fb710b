"""The computer of a loop without the plant: its readings and, unless built in, what is wanted are inputs."""

from __future__ import annotations

import inspect
from collections.abc import Mapping

import casadi as ca
import numpy as np

from workbench.blocks.loop import wiring
from workbench.blocks.loop.command_queue import Queue
from workbench.blocks.loop.computer import Computer, ComputerSignals, answers_missing, held_signals, periods_of
from workbench.blocks.loop.environment import AbstractInstruments, NoReference
from workbench.blocks.loop.injected_signals import InjectedSignals
from workbench.blocks.loop.wiring import SOCKETS, Blocks
from workbench.core import Layout, Signals, lift
from workbench.core.block import Vector
from workbench.core.crossing import without_crossings
from workbench.core.sampled_law import SampledLaw, Stage
from workbench.core.validation.refusals import as_text, known_name, one_of


def extract_law(
    loop: Blocks,
    period: float,
    instruments: AbstractInstruments,
    queue: Queue,
    fine: int,
    reference: str = "input",
    truths: tuple[str, ...] = (),
) -> SampledLaw:
    """The law of a loop, see `SampledSystem.law`."""
    built_in = one_of("law(reference=...)", reference, ("input", "built in")) == "built in"
    readings, every = _readings(loop, truths), {one: periods_of(getattr(loop, one), period) for one in SOCKETS}
    lifted, gauges = lift(loop), lift(instruments, "instruments.")
    states = wiring.memory(loop) + held_signals(loop, every, queue)
    wanted = Layout() if built_in else loop.controller.follows
    k, x, y, r = ca.SX.sym("k"), states.symbols(), readings.symbols(), wanted.symbols()
    computer = Computer(lifted.block, gauges.block, period, every, queue, fine, InjectedSignals())
    said = computer.reference(k)
    ref = Signals(wiring.strip_prefix("r", said.parts) if built_in else wanted.view(r))
    answer = computer.answer(k, states.view(x), Signals(readings.view(y)), ref)
    handed, made = answer.as_numbers()
    crossings = (said, made) if built_in else (made,)
    commands, after = loop.plant.inputs, handed.states()
    acts = commands.flatten(handed.acts)
    moved = {name: without_crossings(crossings, part) for name, part in after.items()}
    memory = _needed_states(states, x, moved, without_crossings(crossings, acts))
    new = ca.vertcat(memory.flatten({name: after[name] for name in memory.names}), acts)
    update, command = ca.vertsplit(without_crossings(crossings, new), [0, memory.size, new.numel()])
    parameters, p = lifted.layout + gauges.layout, ca.vertcat(lifted.symbols, gauges.symbols)
    chosen = _present(parameters, p, ca.vertcat(update, command))
    ports = (memory, readings, wanted, commands, chosen)
    return SampledLaw(
        type(loop.controller).__name__,
        period,
        *ports,
        k,
        ca.vertcat(*(x[states.slice(name)] for name in memory.names), ca.SX(0, 1)),
        y,
        r,
        ca.vertcat(*(p[parameters.slice(name)] for name in chosen.names), ca.SX(0, 1)),
        command,
        update,
        _stages(loop, ref if built_in else None, answer, handed),
        _limits(loop, instruments),
        {name: periods for name, periods in queue.periods.items() if periods},
        (*wiring.notes(loop), *_note_of(truths)),
        crossings,
        new,
        answers_missing(loop),
    )


def _note_of(truths: tuple[str, ...]) -> tuple[str, ...]:
    return (f"{', '.join(truths)}: an input that no instrument of the plant gives",) if truths else ()


def _limits(loop: Blocks, instruments: AbstractInstruments) -> dict[str, tuple[Vector, Vector]]:
    """The limits of commands: those of the law itself, of the instruments, and of converters, as these round them."""
    law, own = loop.controller, {}
    low, high = getattr(law, "command_limits", (getattr(law, "low", None), getattr(law, "high", None)))
    if low is not None and high is not None and len(law.drives.entries) == 1:
        own[law.drives.names[0]] = (low, high)
    own |= {bound.input: (bound.low, bound.high) for bound in getattr(instruments, "bounds", ())}
    for dac in getattr(instruments, "dacs", ()):
        low, high = own.get(dac.signal, (dac.low, dac.top))
        own[dac.signal] = (dac.value(low), dac.value(high))
    return own


def _readings(loop: Blocks, truths: tuple[str, ...]) -> Layout:
    """The signals that the observer reads; a truth among them is refused unless it is named."""
    observer, plant, true = loop.observer, loop.plant, wiring.truths(loop)
    for name in truths if as_text(truths) is None else (truths,):
        known_name(name, true.names, "truths of the plant")
    for entry in observer.reads.entries:
        if entry.name not in plant.outputs and entry.name not in truths:
            raise ValueError(
                f"No machine can run a law that uses the truth: `{type(observer).__name__}` reads '{entry.name}', "
                f"which no instrument of `{type(plant).__name__}` gives. Take an observer that estimates it, or name "
                f"it as an input of the machine: `law(truths=('{entry.name}',))`."
            )
    there = plant.outputs + true
    return Layout(tuple(there[name] for name in observer.reads.names))


def _needed_states(states: Layout, x: ca.SX, after: Mapping[str, ca.SX], command: ca.SX) -> Layout:
    """The states but those of the plant, without those on which nothing depends."""
    own = [entry for entry in states.entries if not entry.name.startswith("plant.")]
    while True:
        new = ca.vertcat(command, *(ca.vec(after[entry.name]) for entry in own))
        left = [entry for entry in own if ca.depends_on(new, x[states.slice(entry.name)])]
        if len(left) == len(own):
            return Layout(tuple(own))
        own = left


def _present(parameters: Layout, p: ca.SX, expression: ca.SX) -> Layout:
    """The parameters that an expression has."""
    there = {symbol.element_hash() for symbol in ca.symvar(expression)}
    rows = np.array([p[i].element_hash() in there for i in range(p.numel())], dtype=bool)
    return Layout(tuple(entry for entry in parameters.entries if rows[parameters.slice(entry.name)].any()))


def _stages(loop: Blocks, ref: Signals | None, answer: ComputerSignals, numbers: ComputerSignals) -> tuple[Stage, ...]:
    """The values of the loop's blocks in the order of the loop, under names that tell them apart."""
    law, observer = loop.controller, loop.observer
    stages = []
    if ref is not None and not isinstance(loop.reference, NoReference):
        stages.append(_stage("Reference", loop.reference, {f"{name}_ref": part for name, part in ref.items()}))
    stages.append(_stage("Observer", observer, {f"{name}_hat": part for name, part in numbers.est.items()}))
    stages.append(_stage("Law", law, {**numbers.own, **numbers.law_commands}))
    if any(answer.limited_commands[name] is not answer.law_commands[name] for name in answer.law_commands):
        stages.append(Stage("Limits", {f"{name}_limited": part for name, part in numbers.limited_commands.items()}))
    if numbers.queued_commands:
        stages.append(
            Stage("Queue of commands", {**numbers.queued_commands, **wiring.prefix_names({"acts": numbers.acts})})
        )
    stages += [
        Stage(f"Memory of the {socket}", wiring.prefix_names({socket: moved}))
        for socket, moved in numbers.next_memories.items()
        if len(moved)
    ]
    return tuple(stages)


def _stage(noun: str, block: object, values: Mapping[str, ca.SX]) -> Stage:
    return Stage(f"{noun}: {type(block).__name__}", dict(values), inspect.cleandoc(type(block).__doc__ or ""))

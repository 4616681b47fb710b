"""The checks of a loop when it is made: each refusal names both blocks and what to do."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from workbench.blocks.loop.contracts import AbstractController, AbstractPlant
from workbench.blocks.loop.environment import AbstractInstruments, NoReference, Readings
from workbench.blocks.loop.wiring import SOCKETS, Blocks, names, truths
from workbench.core import Layout
from workbench.core.block import quantities
from workbench.core.port import misfits
from workbench.core.validation.refusals import refusal

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

PORTS = {
    "plant": ("states", "inputs", "outputs", "truths"),
    "observer": ("memory", "inputs", "reads", "gives"),
    "controller": ("memory", "reads", "follows", "drives"),
    "reference": ("gives",),
}
DERIVATIVES = ("", "d", "dd")  # the ends of the names of a signal, its rate and its acceleration
OBSERVERS = "`ExtendedKalmanFilter`, `SteadyKalmanFilter` or `LinearObserver`"  # those that estimate the states


def refuse_odd_ports(loop: object) -> None:
    """Refuse a loop one of whose blocks has a port that is no layout."""
    for socket, ports in PORTS.items():
        block = getattr(loop, socket)
        for port in ports if block is not None else ():
            if not isinstance(held := getattr(block, port), Layout):
                must = "a `Layout`, as `layout(v='V')` makes one of names and units"
                raise refusal(f"{_name(block)}.{port}", must, held)


def refuse_misfits(loop: Blocks) -> None:
    """Refuse a loop in which a block needs a signal that no other gives, in one sentence that names both."""
    plant, observer, law, reference = loop.plant, loop.observer, loop.controller, loop.reference
    if not observer.uses_truth:
        for name in observer.reads.names:
            if name in plant.truths and name not in plant.outputs:
                raise ValueError(
                    f"`{_name(observer)}` reads '{name}', which no instrument of `{_name(plant)}` gives: read one of "
                    f"{_names(plant.outputs)}, or declare `uses_truth = True`."
                )
    shown = names(loop)
    if twice := next((name for name in shown if shown.count(name) > 1), None):
        raise ValueError(
            f"A loop shows each signal by a name of its own, and here '{twice}' would stand for two of them: rename an "
            f"input or an output of `{_name(plant)}`."
        )
    refuse_shared_names(plant)
    for socket in SOCKETS[1:]:
        block = getattr(loop, socket)
        _refuse_shared(block, "state", block.memory.names, "parameter", _parameters(block))
    visible = plant.outputs + truths(loop) if observer.uses_truth else plant.outputs
    _refuse(observer, "reads", observer.reads, plant, "gives", visible, _way_to_observe(loop))
    _refuse(observer, "counts on", observer.inputs, plant, "has as inputs", plant.inputs)
    if isinstance(reference, NoReference) and law.follows.size:
        raise ValueError(
            f"`{_name(law)}` follows {_names(law.follows)}, and the loop has no reference: give "
            "`ClosedLoop(reference=...)` one that gives it, as a `Step` does."
        )
    giver = plant if isinstance(observer, Readings) else observer
    _refuse(law, "reads", law.reads, giver, "gives", observer.gives, _way_to_estimate(loop))
    _refuse(law, "follows", law.follows, reference, "gives", reference.gives)
    _refuse(law, "drives", law.drives, plant, "has as inputs", plant.inputs)
    for name in plant.inputs.names:
        if name not in law.drives:
            raise ValueError(
                f"Every input of `{_name(plant)}` must be driven: nothing drives '{name}', as `{_name(law)}` drives "
                f"{_names(law.drives)}. Take a law that drives it too, or make it a parameter of the plant."
            )
    _refuse_unlike(loop)
    _refuse_ignored_reference(loop)


def refuse_instruments(loop: Blocks, instruments: AbstractInstruments) -> None:
    """Refuse instruments of another plant, in one sentence that names both."""
    plant = loop.plant
    _refuse(instruments, "reads", instruments.reads, plant, "gives", plant.outputs)
    _refuse(instruments, "limits", instruments.limits, plant, "has as inputs", plant.inputs)


def refuse_instants(plant: AbstractPlant) -> None:
    """Refuse a plant in continuous time that has parts which move at the instants of a computer alone."""
    if plant.noises:
        raise ValueError(
            f"`{_name(plant)}` has coloured noise, which moves at the instants of a computer, and in continuous time "
            "there are none: take `ClosedLoop.digital(period)`, or the plant without its noise for a design."
        )
    if plant.sampled_states.size:
        raise ValueError(
            f"`{_name(plant)}` has {_names(plant.sampled_states)}, which moves at the instants of a computer, and in "
            "continuous time there are none: take `ClosedLoop.digital(period)`, or give it its `time_constant`."
        )


def refuse_shared_names(plant: AbstractPlant) -> None:
    """Refuse a plant in which one name means two things: its equations and its runs are read by name."""
    states, inputs, own = plant.states.names, plant.inputs.names, _parameters(plant)
    _refuse_shared(plant, "state", states, "input", inputs)
    _refuse_shared(plant, "state", states, "parameter", own)
    _refuse_shared(plant, "input", inputs, "parameter", own)
    _refuse_shared(plant, "input", inputs, "output", (plant.outputs + plant.truths).names)
    same = Layout(tuple(entry for entry in plant.outputs.entries if entry.name in plant.states))
    for clause in misfits(same, plant.states):
        gives = f"`{_name(plant)}` has as a state"
        raise ValueError(
            f"`{_name(plant)}` gives {clause.format(gives=gives)}: an output by the name of a state must be that "
            "state; rename one of them."
        )


def _refuse_shared(block: object, one: str, own: Iterable[str], other: str, others: Iterable[str]) -> None:
    for name in own:
        if name in others:
            raise ValueError(
                f"`{_name(block)}` calls {_an(one)} and {_an(other)} '{name}', and the equations of a loop tell "
                "their symbols apart by name: rename one of them."
            )


def _refuse_unlike(loop: Blocks) -> None:
    """Refuse an estimate or a wanted signal that has the name of an output, and another size or unit."""
    outputs = loop.plant.outputs + truths(loop)
    ports = ((loop.observer, "gives", loop.observer.gives), (loop.reference, "gives", loop.reference.gives))
    for block, verb, port in ports:
        same = Layout(tuple(entry for entry in port.entries if entry.name in outputs))
        _refuse(block, verb, same, loop.plant, "gives", outputs)


def _refuse_ignored_reference(loop: Blocks) -> None:
    """Refuse a reference of which the law follows nothing, or not what is wanted of an output of the plant.

    A reference that is made for several plants may say more than this one has.
    """
    law, reference = loop.controller, loop.reference
    motions = {f"{name}{end}" for name in law.follows.names for end in DERIVATIVES}  # each makes the others redundant
    motions |= {name for name in reference.primary if any(f"{name}{end}" in law.follows for end in DERIVATIVES)}
    ignored = tuple(name for name in reference.primary if name not in motions)
    everything = len(ignored) == len(reference.primary)
    if ignored := ignored if everything else tuple(name for name in ignored if name in loop.plant.outputs):
        named = _list_names(ignored)
        raise ValueError(
            f"`{_name(reference)}` gives {named}, which `{_name(law)}` does not follow, as it follows "
            f"{_names(law.follows)}: this would change nothing. Take {_way_to_follow(law, ignored)}, or make the loop "
            f"without {'a reference' if everything else named}."
        )


def _way_to_follow(law: AbstractController, names: tuple[str, ...]) -> str:
    """The law that follows the signals: by its own advice, if this one reads them."""
    if law.hint_on_follows and all(name in law.reads for name in names):
        return law.hint_on_follows.format(names=_list_names(names), wanted=_list_names(f"{name}_ref" for name in names))
    return f"a law that follows {_list_names(names)}"


def _way_to_observe(loop: Blocks) -> str:
    """The remedy where an observer reads what no instrument gives."""
    hint = f"{loop.observer.hint_on_reads} " if loop.observer.hint_on_reads else ""
    return (
        f"{hint}Leave `observer` out where the law shall read {_names(loop.plant.outputs)} as the "
        f"instruments do, or take an observer of this plant, as {OBSERVERS} is."
    )


def _way_to_estimate(loop: Blocks) -> str:
    """The remedy where a law reads what neither an instrument nor the observer gives."""
    plant, law = loop.plant, loop.controller
    missing = [name for name in law.reads.names if name not in loop.observer.gives]
    hidden = [name for name in missing if name in plant.states + plant.truths]
    if not hidden:
        return law.hint_on_reads
    as_these = f", as {OBSERVERS} does" if all(name in plant.states for name in hidden) else ""
    if not isinstance(loop.observer, Readings):
        return f"Take an observer that gives {_list_names(hidden)}{as_these}."
    return (
        f"Give `ClosedLoop(observer=...)` one that estimates {_list_names(hidden)}{as_these}; where an instrument "
        f"measures it, add it to the outputs of `{_name(plant)}`."
    )


def _refuse(asks: object, verb: str, demand: Layout, gives: object, has: str, offer: Layout, remedy: str = "") -> None:
    for clause in misfits(demand, offer):
        sentence = f"`{_name(asks)}` {verb} {clause.format(gives=f'`{_name(gives)}` {has}')}"
        if sentence.endswith("?"):
            raise ValueError(sentence)
        lacking = ", where {gives} it" not in clause
        raise ValueError(f"{sentence}.{f' {remedy}' if remedy and lacking else ''}")


def _parameters(block: DataclassInstance) -> tuple[str, ...]:
    own = (field.name for field, quantity in quantities(block) if quantity.is_symbolic)
    return tuple(name for name in own if getattr(block, name) is not None)


def _names(port: Layout) -> str:
    return _list_names(port.names)


def _list_names(names: Iterable[str]) -> str:
    return ", ".join(map(repr, names)) or "nothing"


def _an(noun: str) -> str:
    return f"{'an' if noun[0] in 'aeiou' else 'a'} {noun}"


def _name(block: object) -> str:
    return type(block).__name__

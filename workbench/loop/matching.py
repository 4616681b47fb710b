"""Which ports of a loop fit one another, by name, shape and unit."""

from __future__ import annotations

from workbench.core import Layout
from workbench.core.port import misfits
from workbench.loop.defaults import Readings, Rest
from workbench.loop.surroundings import AbstractInstruments
from workbench.loop.wiring import Blocks, names
from workbench.validation.refusals import nearest, refusal

PORTS = {
    "plant": ("states", "inputs", "outputs", "truths"),
    "observer": ("memory", "inputs", "reads", "gives"),
    "controller": ("memory", "reads", "follows", "drives"),
    "reference": ("says",),
}


def refuse_odd_ports(loop: object) -> None:
    """Refuse a loop one of whose blocks has a port that is no layout."""
    for socket, ports in PORTS.items():
        block = getattr(loop, socket)
        for port in ports if block is not None else ():
            if not isinstance(held := getattr(block, port), Layout):
                must = "a `Layout`, as `layout(v='V')` makes one of names and units"
                raise refusal(f"{_name(block)}.{port}", must, held)


def refuse_misfits(loop: Blocks) -> None:
    """Refuse a loop one of whose blocks asks for what no other gives, in one sentence that names both.

    Raises
    ------
    ValueError
        If a signal is missing, or comes with another number of components or in another unit; if an input of the plant
        is driven by nothing, or a law drives what is no input; or if the truth is read without `uses_truth`.
    """
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
    visible = plant.outputs + plant.truths if observer.uses_truth else plant.outputs
    _refuse(observer, "reads", observer.reads, plant, "gives", visible)
    _refuse(observer, "counts on", observer.inputs, plant, "has as inputs", plant.inputs)
    if isinstance(reference, Rest) and law.follows.size:
        raise ValueError(
            f"`{_name(law)}` follows {_names(law.follows)}, and the loop has no reference: give "
            "`ClosedLoop(reference=...)` one that says it, as a `Step` does."
        )
    _refuse(law, "reads", law.reads, plant if isinstance(observer, Readings) else observer, "gives", observer.gives)
    _refuse(law, "follows", law.follows, reference, "says", reference.says)
    _refuse(law, "drives", law.drives, plant, "has as inputs", plant.inputs)
    for name in plant.inputs.names:
        if name not in law.drives:
            raise ValueError(
                f"Every input of `{_name(plant)}` must be driven: nothing drives '{name}', as `{_name(law)}` drives "
                f"{_names(law.drives)}.{nearest(name, law.drives.names)}"
            )


def refuse_instruments(loop: Blocks, instruments: AbstractInstruments) -> None:
    """Refuse instruments of another plant, in one sentence that names both."""
    plant = loop.plant
    _refuse(instruments, "reads", instruments.reads, plant, "gives", plant.outputs)
    _refuse(instruments, "limits", instruments.limits, plant, "has as inputs", plant.inputs)


def _refuse(asks: object, verb: str, wanted: Layout, gives: object, has: str, offered: Layout) -> None:
    for clause in misfits(wanted, offered):
        sentence = f"`{_name(asks)}` {verb} {clause.format(gives=f'`{_name(gives)}` {has}')}"
        raise ValueError(sentence if sentence.endswith("?") else f"{sentence}.")


def _names(port: Layout) -> str:
    return ", ".join(map(repr, port.names)) or "nothing"


def _name(block: object) -> str:
    return type(block).__name__

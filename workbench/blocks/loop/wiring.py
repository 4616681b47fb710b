"""The connections of a loop: the answers of its blocks, and the outputs that it shows."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator, Mapping
from dataclasses import Field, fields
from typing import TYPE_CHECKING, ClassVar, Protocol

import casadi as ca
import numpy as np

from workbench.blocks.loop.contracts import AbstractController, AbstractMember, AbstractObserver, AbstractPlant, Parts
from workbench.blocks.loop.environment import AbstractReference
from workbench.core import Entry, Layout, Signals
from workbench.core.block import is_block
from workbench.core.expressions import SymbolError, symbols_are_no_numbers
from workbench.core.port import NoSignalError, signals_of
from workbench.core.shapes import Drawing, drawing_of
from workbench.core.validation.refusals import describe

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

SOCKETS = ("plant", "observer", "controller")  # those with a memory


class Blocks(Protocol):
    """The blocks of a loop; `follows` are the outputs of the plant that are to follow the reference."""

    __dataclass_fields__: ClassVar[dict[str, Field[object]]]

    @property
    def plant(self) -> AbstractPlant: ...  # noqa: D102
    @property
    def observer(self) -> AbstractObserver: ...  # noqa: D102
    @property
    def controller(self) -> AbstractController: ...  # noqa: D102
    @property
    def reference(self) -> AbstractReference: ...  # noqa: D102
    @property
    def follows(self) -> tuple[str, ...]: ...  # noqa: D102


def memory(loop: Blocks) -> Layout:
    """The states of all blocks, each below the name of its socket."""
    own = {"plant": loop.plant.states, "observer": loop.observer.memory, "controller": loop.controller.memory}
    return sum((own[socket].with_prefix(f"{socket}.") for socket in SOCKETS), Layout())


def call_block(block: object, method: str, port: Layout, *arguments: object) -> Signals:
    """The answer of a method of a block for a port, or a refusal that names the class, the method and the port."""
    call = f"{type(block).__name__}.{method}(...)"
    if not hasattr(block, method):
        raise LookupError(f"`{call}` is asked for, and this class of blocks has no such method.")
    with _refuse_odd_answers(call):
        parts = getattr(block, method)(*arguments)
    return signals_of(call, port, parts)


def plant_drawing(plant: AbstractPlant, t: ca.SX, x: Signals, p: ca.SX, parameters: Layout) -> Drawing | None:
    """The drawing of a plant, its widths at the defaults of the loop's parameters p, or a refusal that names it."""
    call = f"{type(plant).__name__}.drawing(...)"
    with _refuse_odd_answers(call):
        shapes = plant.drawing(t, x)
    return drawing_of(call, shapes, p, parameters.default)


@contextlib.contextmanager
def _refuse_odd_answers(call: str) -> Iterator[None]:
    """Refuse by name a method that takes symbols for numbers, or asks for signals that are not there."""
    try:
        with symbols_are_no_numbers():
            yield
    except NoSignalError as missing:
        raise LookupError(f"`{call}` asks for a signal that its ports do not declare. {missing}") from missing
    except SymbolError as error:
        raise ValueError(
            f"`{call}` must compute with symbols in place of numbers, as it is read once, derived and compiled; "
            f"{error}: take `ca.sin` of CasADi in place of `math.sin`, and `ca.if_else(c, a, b)` in place of `if`."
        ) from error


def reference_signals(loop: Blocks, t: ca.SX) -> Signals:
    """The signals of the reference at a time."""
    return call_block(loop.reference, "at", loop.reference.gives, t)


def truths(loop: Blocks) -> Layout:
    """The signals of the plant that no instrument gives: its own truths, and each state that the observer reads so."""
    plant, observer = loop.plant, loop.observer
    told = plant.outputs + plant.truths
    states = (entry for entry in plant.states.entries if entry.name in observer.reads and entry.name not in told)
    return plant.truths + Layout(tuple(states) if observer.uses_truth else ())


def measurements(loop: Blocks, t: ca.SX, x: Signals) -> Signals:
    """The outputs and the truths of the plant."""
    y = call_block(loop.plant, "measure", loop.plant.outputs + loop.plant.truths, t, x)
    return y | {name: x[name] for name in truths(loop).names if name not in y}


def noise_states(plant: AbstractPlant, k: ca.SX, x: Signals, w: ca.SX, period: float) -> Signals:
    """The states of a plant that its noise moves at an instant."""
    with _refuse_odd_answers(call := f"{type(plant).__name__}.stirred(...)"):
        moved = plant.noise_states(k, x, w, period) if plant.noises else {}
    return signals_of(call, Layout(tuple(entry for entry in plant.states.entries if entry.name in moved)), moved)


def estimates(loop: Blocks, t: ca.SX, z: Signals, y: Signals) -> tuple[Signals, Signals]:
    """The signals that the observer reads, the truth only where it declares to use it, and its estimates."""
    seen = y.only(loop.observer.reads)
    return seen, call_block(loop.observer, "estimate", loop.observer.gives, t, z, seen)


def commands(loop: Blocks, t: ca.SX, z: Signals, est: Signals, ref: Signals) -> Signals:
    """The commands of the law."""
    law = loop.controller
    return call_block(law, "command", law.drives, t, z, est.only(law.reads), ref.only(law.follows))


def split(parts: Mapping[str, ca.SX]) -> dict[str, Signals]:
    """The states of a loop as those of each socket, by their own names."""
    return {socket: Signals(strip_prefix(socket, parts)) for socket in SOCKETS}


def loop_outputs(
    loop: Blocks, y: Signals, ref: Signals, est: Signals, u: Signals, applied_inputs: Signals, own: Parts
) -> tuple[Layout, dict[str, ca.SX]]:
    """The signals that are worth watching in any loop, with their layout, as `ClosedLoop.ode` has them."""
    outputs, inputs, true = loop.plant.outputs, loop.plant.inputs, truths(loop)
    of = {entry.name: entry for entry in (outputs + true).entries}
    follows = [of[name] for name in loop.reference.gives.names if name in outputs]
    rows = [(e.name, y[e.name], e.unit) for e in outputs.entries]
    rows += [(f"{e.name}_ref", ref[e.name], e.unit) for e in follows]
    for e in follows:
        rows.append((f"e_{e.name}", y[e.name] - ref[e.name], e.unit))
        if e.name in est and e.name in loop.reference.primary:
            rows.append((f"e_hat_{e.name}", est[e.name] - ref[e.name], e.unit))
    rows += [(e.name, u[e.name], e.unit) for e in inputs.entries]
    rows += [(f"{e.name}_applied", applied_inputs[e.name], e.unit) for e in inputs.entries]
    rows += [(e.name, y[e.name], e.unit) for e in true.entries]
    rows += [(f"{e.name}_error", y[e.name] - est[e.name], e.unit) for e in of.values() if e.name in est]
    short, law = loop.plant.labels, loop.controller
    parts = [(short.get(name, name), part, unit) for name, part, unit in rows]
    parts += [(name, ca.vec(ca.SX(part)), law.signal_units.get(name, "")) for name, part in own.items()]
    layout = Layout(tuple(Entry(name, np.zeros(part.numel()), unit) for name, part, unit in parts))
    return layout, {name: ca.densify(ca.SX(part)) for name, part, _ in parts}


def differences(loop: Blocks) -> dict[str, tuple[str, str]]:
    """The outputs that are the difference of two signals, by the names under which the loop shows all three."""
    outputs, gives = loop.plant.outputs, loop.observer.gives
    follows = [name for name in loop.reference.gives.names if name in outputs]
    pairs = {f"e_{name}": (name, f"{name}_ref") for name in follows}
    pairs |= {f"e_hat_{name}": (f"{name}_hat", f"{name}_ref") for name in follows if name in gives}
    pairs |= {f"{name}_error": (name, f"{name}_hat") for name in (outputs + truths(loop)).names if name in gives}
    short = loop.plant.labels
    return {short.get(name, name): (short.get(a, a), short.get(b, b)) for name, (a, b) in pairs.items()}


def power(loop: Blocks) -> tuple[str, ...]:
    """The effort and the flow that the plant declares, as they act, by the names under which the loop shows them."""
    plant = loop.plant
    if not plant.power:
        return ()
    effort, flow = plant.power if len(plant.power) == 2 else ("", "")
    if effort not in plant.inputs or flow not in plant.outputs + plant.truths:
        raise ValueError(
            f"`{type(plant).__name__}.power` must be an input and an output whose product is a power, as ('v', 'i') "
            f"is; got {plant.power!r}. Its inputs are {', '.join(plant.inputs.names)}, its outputs "
            f"{', '.join((plant.outputs + plant.truths).names)}."
        )
    return f"{effort}_applied", plant.labels.get(flow, flow)


def measures(loop: Blocks) -> tuple[str, ...]:
    """The outputs of the plant, by the names under which the loop shows them."""
    return tuple(loop.plant.labels.get(name, name) for name in loop.plant.outputs.names)


def names(loop: Blocks) -> list[str]:
    """The names of the signals that a loop shows and, below `hold.`, of those that a computer holds."""
    outputs, inputs, true = loop.plant.outputs.names, loop.plant.inputs.names, truths(loop).names
    gives, follows = loop.observer.gives.names, [name for name in loop.reference.gives.names if name in outputs]
    own = [*outputs, *inputs, *true, *(f"{name}_applied" for name in inputs)]
    own += [f"{name}_ref" for name in follows] + [f"e_{name}" for name in follows]
    own += [f"e_hat_{name}" for name in follows if name in gives and name in loop.reference.primary]
    own += [f"{name}_error" for name in (*outputs, *true) if name in gives]
    return [loop.plant.labels.get(name, name) for name in own] + [f"{name}_hat" for name in gives] + ["next"]


def signals(loop: Blocks, z: Signals, est: Signals, ref: Signals) -> Parts:
    """The signals that the law shows by itself, by names that are not the loop's own."""
    law = loop.controller
    own: Parts = law.signals(z, est.only(law.reads), ref.only(law.follows))
    if not isinstance(own, Mapping):
        raise ValueError(f"`{type(law).__name__}.signals(...)` must return a mapping; it returned {describe(own)}.")
    taken = names(loop)
    for name in own:
        if name in taken:
            raise ValueError(
                f"`{type(law).__name__}.signals(...)` must not use the name '{name}', which is the loop's own; rename "
                "it."
            )
    return own


def strip_prefix(socket: str, parts: Mapping[str, ca.SX]) -> dict[str, ca.SX]:
    """The parts of one socket by their own names."""
    prefix = f"{socket}."
    return {name.removeprefix(prefix): part for name, part in parts.items() if name.startswith(prefix)}


def prefix_names(parts: Mapping[str, Mapping[str, ca.SX]]) -> dict[str, ca.SX]:
    """The parts of several sockets, each below the name of its own."""
    return {f"{socket}.{name}": part for socket, own in parts.items() for name, part in own.items()}


def notes(loop: Blocks, *, continuous: bool = False) -> tuple[str, ...]:
    """The remarks that a reader of the loop's equations needs, in continuous time also of the periods of its blocks."""
    true = truths(loop).names
    signals = f"{'signal' if len(true) == 1 else 'signals'} {' and '.join(true)}"
    reader = _reader_of_truth(loop.observer)
    oracle = (f"the {reader} uses the true {signals}, which no instrument gives",) if loop.observer.uses_truth else ()
    blocks: tuple[AbstractMember, ...] = (loop.observer, loop.controller)
    held = [(type(block).__name__, block.period) for block in blocks if continuous and block.period is not None]
    says = "{} acts at every instant here; its period of {:g} s applies only in a computer"
    return (*oracle, *(says.format(*each) for each in held))


def _reader_of_truth(observer: AbstractObserver) -> str:
    """The observer, or the one of its parts that uses a truth, named by its field."""
    parts = [name for name, part in vars(observer).items() if getattr(part, "uses_truth", False)]
    return f"{parts[0]} observer" if len(parts) == 1 else "observer"


def horizon(block: DataclassInstance) -> float:
    """The last time for which each reference or plant in a block has values, however deep it lies, in s."""
    own: float = getattr(block, "ends", math.inf)  # of a reference, or of a plant of equations
    held = (getattr(block, field.name) for field in fields(block))
    parts = (part for value in held for part in (value if isinstance(value, tuple) else (value,)))
    return min([own, *(horizon(part) for part in parts if is_block(part))])

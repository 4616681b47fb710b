"""The roles of a loop's blocks, read from its equations: the inputs that reach the command, and by which way."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from copy import copy
from dataclasses import fields
from typing import TYPE_CHECKING, TypeGuard, TypeVar

import casadi as ca

from workbench.blocks.loop.contracts import AbstractController, AbstractPlant, is_recursion
from workbench.blocks.loop.wiring import Blocks, truths
from workbench.core import Layout, Signals, lift
from workbench.core.block import is_block
from workbench.core.model_probe import AbstractModel, Probe
from workbench.core.port import Roles, Way
from workbench.core.validation.refusals import refusal
from workbench.core.validation.signatures import check_arguments

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

T = TypeVar("T")
Part = TypeVar("Part", bound="DataclassInstance")
SOCKETS = ("plant", "observer", "controller", "reference")
PERIOD = 1.0  # s: a law that only a computer can run needs one; which does not matter here
Edges = dict[str, set[str]]


@check_arguments
def roles(loop: object) -> Roles:
    """The inputs that the command of the law of a `ClosedLoop`, or of what has one as its `loop`, depends on.

    Dependence, at one instant or by way of a memory, is that of the equations with the numbers of this loop, so that a
    term whose gain is 0 does not count; what cancels only after a calculation does. The torque that the observer is
    told is the computer's own and gives nothing.

    Raises
    ------
    ValueError
        If `loop` is neither.

    Examples
    --------
    >>> from workbench.blocks.loop import roles
    >>> law = wb.PID(wb.DCMotor().outputs, wb.DCMotor().inputs, Kp=10.0, Ki=20.0)
    >>> roles(wb.ClosedLoop(wb.DCMotor(), controller=law, reference=wb.Step("omega", "rad/s", 1.0)))
    Roles(law='PID', readings={'omega'}, reference=('omega_ref',), law_states=2, observer_states=0)
    """
    closed = getattr(loop, "loop", loop)
    if not _is_loop(closed):
        raise refusal("roles(loop)", "a `ClosedLoop`, or what has one as its `loop`", loop)
    models = (
        *_parts_of(closed.observer, "observer", AbstractModel),
        *_parts_of(closed.controller, "controller", AbstractModel),
    )
    probes: dict[str, Probe] = {path: model.probe() for path, model in models}
    of_plants = (path for path, _ in _parts_of(closed.observer, "observer", AbstractPlant))
    plants = [path for path in of_plants if not any(model.startswith(path) for model in probes)]
    edges = _edges(closed, probes)
    commands = {f"u.{name}" for name in closed.controller.drives.names}
    at_once, ever = _reachable(edges, commands, but="observer."), _reachable(edges, commands)
    outputs, true = closed.plant.outputs.names, truths(closed).names
    return Roles(
        _name_of(closed.controller),
        _name_of(closed.observer),
        {name: tuple(_ways(name, edges, at_once, ever)) for name in outputs},
        tuple(f"{name}_ref" for name in closed.controller.follows.names if f"ref.{name}" in ever),
        {path: tuple(name for name in probe.symbols if f"{path}.{name}" in ever) for path, probe in probes.items()}
        | {path: ("f",) * any(node.startswith("observer.") for node in ever) for path in plants},
        tuple(name for name in true if f"est.{name}" in ever and edges.get(f"est.{name}")),
        tuple(name for name in true if f"y.{name}" in ever),
        closed.controller.memory.size,
        closed.observer.memory.size,
    )


def _ways(name: str, edges: Edges, at_once: set[str], ever: set[str]) -> Iterator[Way]:
    """The ways by which an output reaches the commands: read at once, by a memory, or as an estimate of another."""
    read, given = f"y.{name}", f"est.{name}"
    remembered = {node for node in edges.get(given, ()) if node in edges}
    behind = _reachable(edges, remembered)
    alone = behind <= remembered | {read}
    if read in at_once:
        yield "read"
    elif read in ever and alone:
        yield "filtered"
    if (given in ever and remembered and not alone) or (read in ever and read not in at_once and not alone):
        yield "estimated"


def _is_loop(value: object) -> TypeGuard[Blocks]:
    return is_block(value) and all(hasattr(value, socket) for socket in SOCKETS)


def _parts_of(block: DataclassInstance, path: str, kind: type[T]) -> Iterator[tuple[str, T]]:
    """All parts of a kind that a block holds, by their paths."""
    for field in fields(block):
        part, place = getattr(block, field.name), f"{path}.{field.name}"
        if isinstance(part, kind):
            yield place, part
        elif is_block(part):
            yield from _parts_of(part, place, kind)


def _with_probes(block: Part, path: str, probes: Mapping[str, Probe]) -> Part:
    twin = copy(block)
    for field in fields(block):
        part, place = getattr(block, field.name), f"{path}.{field.name}"
        if place in probes:
            object.__setattr__(twin, field.name, probes[place].block)
        elif is_block(part):
            object.__setattr__(twin, field.name, _with_probes(part, place, probes))
    return twin


def _edges(loop: Blocks, probes: Mapping[str, Probe]) -> Edges:
    """The direct dependencies of each command, each estimate and each state of observer and controller."""
    lifted, t = lift(loop), ca.SX.sym("t")
    observer = _with_probes(lifted.block.observer, "observer", probes)
    law = _with_probes(lifted.block.controller, "controller", probes).run_every(loop.controller.period or PERIOD)
    y, est, ref, told = map(_symbols, (observer.reads, observer.gives, law.follows, observer.inputs))
    z = {"observer": _symbols(loop.observer.memory), "controller": _symbols(loop.controller.memory)}
    heard = est.only(law.reads)
    given = observer.estimate(t, z["observer"], y)
    remembers = observer.update if is_recursion(observer) else observer.rate
    adapts = law.update if is_recursion(law) else law.rate
    made = {
        **{f"u.{name}": part for name, part in law.command(t, z["controller"], heard, ref).items()},
        **{f"est.{name}": part for name, part in given.items()},
        **{f"observer.{name}": rate for name, rate in remembers(t, z["observer"], y, est, told).items()},
        **{f"controller.{name}": rate for name, rate in adapts(t, z["controller"], heard, ref).items()},
    }
    inputs = {
        **{f"y.{name}": part for name, part in y.items()},
        **{f"est.{name}": part for name, part in est.items()},
        **{f"ref.{name}": part for name, part in ref.items()},
        **{f"{socket}.{name}": part for socket, own in z.items() for name, part in own.items()},
        **{f"{path}.{name}": symbol for path, probe in probes.items() for name, symbol in probe.symbols.items()},
    }
    numbers = ca.DM(lifted.layout.default)
    plain = {name: ca.substitute(ca.SX(part), lifted.symbols, numbers) for name, part in made.items()}
    return {name: _inputs_of(part, inputs) for name, part in plain.items()}


def _symbols(port: Layout) -> Signals:
    return Signals(port.view(port.symbols()))


def _inputs_of(part: ca.SX, inputs: Mapping[str, ca.SX]) -> set[str]:
    return {name for name, symbol in inputs.items() if symbol.numel() and ca.depends_on(part, ca.vec(symbol))}


def _reachable(edges: Edges, start: set[str], but: str | None = None) -> set[str]:
    """All nodes that the edges reach from some nodes, without going beyond nodes whose names begin so."""
    found, new = set(start), set(start)
    while new:
        new = {end for node in new if but is None or not node.startswith(but) for end in edges.get(node, ())} - found
        found |= new
    return found


def _name_of(block: DataclassInstance) -> str:
    """The name of a block: the `noun` of its class or else its name, with the laws or observers that it holds."""
    own = getattr(block, "noun", type(block).__name__)
    parts = (getattr(block, field.name) for field in fields(block))
    held = [_name_of(part) for part in parts if isinstance(part, AbstractController) or hasattr(part, "uses_truth")]
    return " ".join(word for word in (own, " + ".join(filter(None, held))) if word)

"""What a loop in continuous time and a sampled one have in common: sockets, one turn around them, and the outputs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields
from typing import Any, Protocol

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Signals
from workbench.core.block import is_block
from workbench.core.expressions import SymbolError, symbols_are_no_numbers
from workbench.core.port import NoSignalError, signals_of
from workbench.loop.contracts import AbstractController, AbstractObserver, AbstractPlant, Parts, is_recursion
from workbench.loop.surroundings import AbstractReference
from workbench.validation.refusals import described

SOCKETS = ("plant", "observer", "controller")  # those with a memory


class Blocks(Protocol):
    """A loop, as far as its blocks go."""

    @property
    def plant(self) -> AbstractPlant:
        """What is controlled."""

    @property
    def observer(self) -> AbstractObserver:
        """What estimates."""

    @property
    def controller(self) -> AbstractController:
        """What commands the inputs of the plant."""

    @property
    def reference(self) -> AbstractReference:
        """What is wanted."""

    @property
    def follows(self) -> tuple[str, ...]:
        """The outputs of the plant that the law is to make follow the reference."""


def own(socket: str, block: Any) -> Layout:
    """The states of a block, by their own names."""
    layout: Layout = block.states if socket == "plant" else block.memory
    return layout


def memory(loop: Blocks) -> Layout:
    """The states of all blocks, each below the name of its socket."""
    return sum((own(socket, getattr(loop, socket)).prefixed(f"{socket}.") for socket in SOCKETS), Layout())


def asked(block: Any, method: str, port: Layout, *arguments: Any) -> Signals:
    """What a method of a block returns for a port, or a refusal that names the class, the method and the port."""
    call = f"{type(block).__name__}.{method}(...)"
    try:
        with symbols_are_no_numbers():
            parts = getattr(block, method)(*arguments)
    except NoSignalError as missing:
        raise LookupError(f"`{call}` asks for a signal that its ports do not declare. {missing}") from missing
    except SymbolError as error:
        raise ValueError(
            f"`{call}` must compute with symbols in place of numbers, as it is read once, derived and compiled; "
            f"{error}: take `ca.sin` of CasADi in place of `math.sin`, and `ca.if_else(c, a, b)` in place of `if`."
        ) from error
    return signals_of(call, port, parts)


def wanted(loop: Blocks, t: ca.SX) -> Signals:
    """What the reference says at a time."""
    return asked(loop.reference, "at", loop.reference.says, t)


def measured(loop: Blocks, t: ca.SX, x: Signals) -> Signals:
    """The outputs of the plant and what no instrument gives."""
    return asked(loop.plant, "measure", loop.plant.outputs + loop.plant.truths, t, x)


def estimated(loop: Blocks, t: ca.SX, z: Signals, y: Signals) -> tuple[Signals, Signals]:
    """What the observer reads, which is the truth only where it declares to use it, and what it makes of that."""
    seen = y.only(loop.observer.reads)
    return seen, asked(loop.observer, "estimate", loop.observer.gives, t, z, seen)


def commanded(loop: Blocks, t: ca.SX, z: Signals, est: Signals, ref: Signals) -> Signals:
    """What the law commands."""
    law = loop.controller
    return asked(law, "command", law.drives, t, z, est.only(law.reads), ref.only(law.follows))


def rates(
    loop: Blocks, t: ca.SX, z: Mapping[str, Signals], seen: Signals, est: Signals, u: Signals, ref: Signals
) -> dict[str, Signals]:
    """The derivatives of the states of observer and law."""
    law, observer = loop.controller, loop.observer
    heard, followed = est.only(law.reads), ref.only(law.follows)
    return {
        "observer": asked(observer, "rate", observer.memory, t, z["observer"], seen, est, u.only(observer.inputs)),
        "controller": asked(law, "rate", law.memory, t, z["controller"], heard, followed),
    }


def split(parts: Mapping[str, ca.SX]) -> dict[str, Signals]:
    """The states of a loop as those of each socket, by their own names."""
    return {socket: Signals(below(socket, parts)) for socket in SOCKETS}


def shown(
    loop: Blocks, y: Signals, ref: Signals, est: Signals, u: Signals, applied: Signals, own: Parts
) -> tuple[Layout, dict[str, ca.SX]]:
    """What is worth watching in any loop, with its layout.

    Each output, wanted signal, command and truth goes by its own name; `x_ref` is what is wanted of x, `e_x` the error
    x - x_ref, `e_hat_x` that of the estimate where x is wanted for itself, `u_applied` what acts where u is commanded,
    and `x_error` what is true less what is estimated. The plant's `labels` shorten them. Behind them comes what the law
    shows, `own`.
    """
    outputs, inputs, truths = loop.plant.outputs, loop.plant.inputs, loop.plant.truths
    of = {entry.name: entry for entry in (outputs + truths).entries}
    follows = [of[name] for name in loop.reference.says.names if name in outputs]
    rows = [(e.name, y[e.name], e.unit) for e in outputs.entries]
    rows += [(f"{e.name}_ref", ref[e.name], e.unit) for e in follows]
    for e in follows:
        rows.append((f"e_{e.name}", y[e.name] - ref[e.name], e.unit))
        if e.name in est and e.name in loop.reference.primary:
            rows.append((f"e_hat_{e.name}", est[e.name] - ref[e.name], e.unit))
    rows += [(e.name, u[e.name], e.unit) for e in inputs.entries]
    rows += [(f"{e.name}_applied", applied[e.name], e.unit) for e in inputs.entries]
    rows += [(e.name, y[e.name], e.unit) for e in truths.entries]
    rows += [(f"{e.name}_error", y[e.name] - est[e.name], e.unit) for e in of.values() if e.name in est]
    short, law = loop.plant.labels, loop.controller
    parts = [(short.get(name, name), part, unit) for name, part, unit in rows]
    parts += [(name, ca.vec(ca.SX(part)), law.signal_units.get(name, "")) for name, part in own.items()]
    layout = Layout(tuple(Entry(name, np.zeros(part.numel()), unit) for name, part, unit in parts))
    return layout, {name: ca.densify(ca.SX(part)) for name, part, _ in parts}


def names(loop: Blocks) -> list[str]:
    """The names that a loop gives to what it shows and, below `hold.`, to what a computer holds."""
    outputs, inputs, truths = loop.plant.outputs.names, loop.plant.inputs.names, loop.plant.truths.names
    gives, follows = loop.observer.gives.names, [name for name in loop.reference.says.names if name in outputs]
    own = [*outputs, *inputs, *truths, *(f"{name}_applied" for name in inputs)]
    own += [f"{name}_ref" for name in follows] + [f"e_{name}" for name in follows]
    own += [f"e_hat_{name}" for name in follows if name in gives and name in loop.reference.primary]
    own += [f"{name}_error" for name in (*outputs, *truths) if name in gives]
    return [loop.plant.labels.get(name, name) for name in own] + [f"{name}_hat" for name in gives] + ["next"]


def signals(loop: Blocks, z: Signals, est: Signals, ref: Signals) -> Parts:
    """What the law shows by itself.

    Raises
    ------
    ValueError
        If it is no mapping, or uses a name that is the loop's own, whose signal it would take the place of.
    """
    law = loop.controller
    own: Parts = law.signals(z, est.only(law.reads), ref.only(law.follows))
    if not isinstance(own, Mapping):
        raise ValueError(f"`{type(law).__name__}.signals(...)` must return a mapping; it returned {described(own)}.")
    taken = names(loop)
    for name in own:
        if name in taken:
            raise ValueError(
                f"`{type(law).__name__}.signals(...)` must not use the name '{name}', which is the loop's own; rename "
                "it."
            )
    return own


def below(socket: str, parts: Mapping[str, ca.SX]) -> dict[str, ca.SX]:
    """The parts of one socket by their own names."""
    prefix = f"{socket}."
    return {name.removeprefix(prefix): part for name, part in parts.items() if name.startswith(prefix)}


def above(parts: Mapping[str, Mapping[str, ca.SX]]) -> dict[str, ca.SX]:
    """The parts of several sockets, each below the name of its own."""
    return {f"{socket}.{name}": part for socket, own in parts.items() for name, part in own.items()}


def methods(loop: Blocks, period: float, fine: int) -> tuple[str, ...]:
    """How a computer that runs the law once in `period` seconds steps each memory: its method, or `fine` steps."""
    by = f"{fine} Runge-Kutta steps a period" if fine else ""
    # as a computer runs them: a law's method may depend on that
    blocks: dict[str, Any] = {"observer": loop.observer, "controller": loop.controller.run_every(period)}
    return tuple(
        f"memory of the {socket}: {own.method if is_recursion(own) or not fine else by}"
        for socket, own in blocks.items()
        if own.memory.size
    )


def notes(loop: Blocks, *, continuous: bool = False) -> tuple[str, ...]:
    """What a reader must know of the loop's equations, in continuous time also of the periods of its blocks."""
    truths = ", ".join(loop.plant.truths.names)
    told = (f"the observer uses the truth ({truths}), which no instrument gives",) if loop.observer.uses_truth else ()
    blocks: tuple[Any, ...] = (loop.observer, loop.controller)
    held = [(type(block).__name__, block.period) for block in blocks if continuous and block.period is not None]
    says = "{} acts at every instant here: its period of {:g} s is that of a computer"
    return (*told, *(says.format(*each) for each in held))


def horizon(block: Any) -> float:
    """The last time for which each reference or plant in a block has values, however deep it lies, in s."""
    own: float = getattr(block, "ends", math.inf)  # of a reference, or of a plant of equations
    held = (getattr(block, field.name) for field in fields(block))
    parts = (part for value in held for part in (value if isinstance(value, tuple) else (value,)))
    return min([own, *(horizon(part) for part in parts if is_block(part))])

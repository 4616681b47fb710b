"""Signals from outside a loop: added to its own, or in their place where it is cut."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import casadi as ca

from workbench.blocks.loop.contracts import is_recursion
from workbench.blocks.loop.wiring import Blocks
from workbench.core import Entry, Layout, Signals
from workbench.core.port import one_entry
from workbench.core.validation.refusals import known, several

Shown = tuple[Layout, dict[str, ca.SX]]  # outputs and their expressions


@dataclass(frozen=True)
class Outside:
    """Signals that come from outside a loop: parameters `symbols` by `layout`, the declared inputs of its equations.

    By "references", "readings" and "inputs", `added` has a symbol for each signal to which one is added there, and
    `replaced` one for each of the signals `cut`, in whose place it stands.
    """

    layout: Layout = field(default_factory=Layout)
    symbols: ca.SX = field(default_factory=lambda: ca.SX(0, 1))
    added: Mapping[str, Mapping[str, ca.SX]] = field(default_factory=dict)
    replaced: Mapping[str, Mapping[str, ca.SX]] = field(default_factory=dict)
    cut: Layout = field(default_factory=Layout)

    def __add__(self, other: Outside) -> Outside:
        """The signals of a cut and, behind them, others that are added to those of the same loop."""
        return Outside(
            self.layout + other.layout, ca.vertcat(self.symbols, other.symbols), other.added, self.replaced, self.cut
        )

    def meets(self, place: str, own: Signals) -> Signals:
        """The signals at a place of the loop, with those from outside in their place or added to them."""
        here = own | self.replaced.get(place, {})
        return here | {name: here[name] + part for name, part in self.added.get(place, {}).items()}

    def touches(self, place: str) -> bool:
        """True if a signal from outside meets one at this place of the loop."""
        return bool(self.added.get(place) or self.replaced.get(place))

    def watched(self, arriving: Signals, shown: Callable[[], Shown]) -> Shown:
        """The outputs: all signals that a loop shows, or those that arrive at the cut; the latter first, if both."""
        if not self.cut.size:
            return shown()
        at_cut = {name: ca.densify(ca.SX(part)) for name, part in arriving.only(self.cut).items()}
        if not self.added:
            return self.cut, at_cut
        layout, parts = shown()
        rest = Layout(tuple(entry for entry in layout.entries if entry.name not in self.cut))
        return self.cut + rest, parts | at_cut


def outside_of(call: str, loop: Blocks, inputs: bool, at: str | tuple[str, ...] | None) -> Outside:
    """The signals from outside that a call asks for: `inputs` that are added, and a cut `at` some signals."""
    if at is None:
        return added(loop) if inputs else Outside()
    return cut(call, loop, at) + added(loop) if inputs else cut(call, loop, at)


def added(loop: Blocks) -> Outside:
    """Parameters, zero unless set, added to wanted signals (`x_ref`), inputs (`u_load`) and readings (`y_noise`)."""
    plant, law = loop.plant, loop.controller
    ports = {
        "references": ("_ref", [loop.reference.says[name] for name in law.follows.names]),
        "inputs": ("_load", plant.inputs.entries),
        "readings": ("_noise", plant.outputs.entries),
    }
    named = [
        (place, e.name, Entry(f"{e.name}{end}", 0 * e.default, e.unit))
        for place, (end, es) in ports.items()
        for e in es
    ]
    layout = Layout(tuple(entry for _, _, entry in named))
    symbols = layout.symbols()
    values = layout.view(symbols)
    parts: dict[str, dict[str, ca.SX]] = {place: {} for place in ports}
    for place, name, entry in named:
        parts[place][name] = values[entry.name]
    return Outside(layout, symbols, added=parts)


def cut(call: str, loop: Blocks, at: str | tuple[str, ...] | None) -> Outside:
    """The parameter 'drive' in the place of inputs or readings of the plant, all inputs unless told."""
    plant = loop.plant
    given = plant.inputs.names if at is None else (at,) if isinstance(at, str) else at
    names = several(f"{call}(at=...)", given, str, 1)
    ports = plant.inputs + plant.outputs
    for name in names:
        known(name, ports.names, "inputs and outputs of the plant")
    at_cut = Layout(tuple(ports[name] for name in names))
    layout = Layout((one_entry(at_cut, "drive"),))
    symbols = layout.symbols()
    values = at_cut.view(symbols)
    parts = {
        "inputs": {name: part for name, part in values.items() if name in plant.inputs},
        "readings": {name: part for name, part in values.items() if name not in plant.inputs},
    }
    return Outside(layout, symbols, replaced=parts, cut=at_cut)


def refuse_inputs_of_recursion(loop: Blocks, outside: Outside) -> None:
    """Refuse signals from outside at the inputs of a plant in discrete time, which moves by the held command."""
    if not (outside.touches("inputs") and is_recursion(loop.plant)):
        return
    name = type(loop.plant).__name__
    if outside.added.get("inputs"):
        raise ValueError(
            "`linear_loop(loop)`, and `inputs=True`, add signals to the inputs of a plant at any time, and "
            f"`{name}` moves in discrete time, at its instants alone. Give the plant in continuous time, and the law "
            "to its computer; where both are discrete systems P and C, ask python-control's P * C by "
            "`wb.stability_margins`, `wb.bode` and `wb.step_info`."
        )
    raise ValueError(
        f"`ClosedLoop.digital(...)` must have a plant in continuous time where signals meet its inputs; "
        f"`{name}` moves in discrete time. Cut the loop at an output: `at=...`."
    )

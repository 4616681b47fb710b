"""Signals from outside a loop: added to its own, or in their place where it is cut."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import casadi as ca

from workbench.blocks.loop.contracts import is_recursion
from workbench.blocks.loop.wiring import Blocks
from workbench.core import Entry, Layout, Signals
from workbench.core.port import one_entry
from workbench.core.validation.refusals import known_name, several

Outputs = tuple[Layout, dict[str, ca.SX]]  # outputs and their expressions


@dataclass(frozen=True)
class InjectedSignals:
    """Signals that come from outside a loop: parameters `symbols` by `layout`, the declared inputs of its equations.

    By "references", "readings" and "inputs", `additions` has a symbol for each signal to which one is added there, and
    `replacements` one for each of the signals `cut_signals`, in whose place it stands.
    """

    layout: Layout = field(default_factory=Layout)
    symbols: ca.SX = field(default_factory=lambda: ca.SX(0, 1))
    additions: Mapping[str, Mapping[str, ca.SX]] = field(default_factory=dict)
    replacements: Mapping[str, Mapping[str, ca.SX]] = field(default_factory=dict)
    cut_signals: Layout = field(default_factory=Layout)

    def __add__(self, other: InjectedSignals) -> InjectedSignals:
        """The signals of a cut and, behind them, others that are added to those of the same loop."""
        return InjectedSignals(
            self.layout + other.layout,
            ca.vertcat(self.symbols, other.symbols),
            other.additions,
            self.replacements,
            self.cut_signals,
        )

    def inject(self, place: str, own: Signals) -> Signals:
        """The signals at a place of the loop, with those from outside in their place or added to them."""
        here = own | self.replacements.get(place, {})
        return here | {name: here[name] + part for name, part in self.additions.get(place, {}).items()}

    def touches(self, place: str) -> bool:
        """True if a signal from outside meets one at this place of the loop."""
        return bool(self.additions.get(place) or self.replacements.get(place))

    def outputs(self, signals: Signals, loop_outputs: Callable[[], Outputs]) -> Outputs:
        """The outputs: all signals that a loop shows, or those that arrive at the cut; the latter first, if both."""
        if not self.cut_signals.size:
            return loop_outputs()
        at_cut = {name: ca.densify(ca.SX(part)) for name, part in signals.only(self.cut_signals).items()}
        if not self.additions:
            return self.cut_signals, at_cut
        layout, parts = loop_outputs()
        rest = Layout(tuple(entry for entry in layout.entries if entry.name not in self.cut_signals))
        return self.cut_signals + rest, parts | at_cut


def injected_signals(call: str, loop: Blocks, inputs: bool, at: str | tuple[str, ...] | None) -> InjectedSignals:
    """The signals from outside that a call asks for: `inputs` that are added, and a cut `at` some signals."""
    if at is None:
        return added_inputs(loop) if inputs else InjectedSignals()
    return cut_loop(call, loop, at) + added_inputs(loop) if inputs else cut_loop(call, loop, at)


def added_inputs(loop: Blocks) -> InjectedSignals:
    """Parameters, zero unless set, added to wanted signals (`x_ref`), inputs (`u_load`) and readings (`y_noise`)."""
    plant, law = loop.plant, loop.controller
    ports = {
        "references": ("_ref", [loop.reference.gives[name] for name in law.follows.names]),
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
    return InjectedSignals(layout, symbols, additions=parts)


def cut_loop(call: str, loop: Blocks, at: str | tuple[str, ...] | None) -> InjectedSignals:
    """The parameter 'drive' in the place of inputs or readings of the plant, all inputs unless told."""
    plant = loop.plant
    given = plant.inputs.names if at is None else (at,) if isinstance(at, str) else at
    names = several(f"{call}(at=...)", given, str, 1)
    ports = plant.inputs + plant.outputs
    for name in names:
        known_name(name, ports.names, "inputs and outputs of the plant")
    at_cut = Layout(tuple(ports[name] for name in names))
    layout = Layout((one_entry(at_cut, "drive"),))
    symbols = layout.symbols()
    values = at_cut.view(symbols)
    parts = {
        "inputs": {name: part for name, part in values.items() if name in plant.inputs},
        "readings": {name: part for name, part in values.items() if name not in plant.inputs},
    }
    return InjectedSignals(layout, symbols, replacements=parts, cut_signals=at_cut)


def refuse_inputs_of_recursion(loop: Blocks, outside: InjectedSignals) -> None:
    """Refuse signals from outside at the inputs of a plant in discrete time, which moves by the held command."""
    if not (outside.touches("inputs") and is_recursion(loop.plant)):
        return
    name = type(loop.plant).__name__
    if outside.additions.get("inputs"):
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

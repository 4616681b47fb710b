"""The equations of a loop, closed and cut, with some states frozen, and the numbers at which they are taken."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from workbench.core import Layout, Ode, SampledSystem
from workbench.core.equations import Loop
from workbench.core.expressions import call_again, evaluate_sx
from workbench.core.validation.number_types import Numbers, Values
from workbench.core.validation.refusals import Array, finite, known_name, nearest, refusal, several
from workbench.design.frequency import common_period
from workbench.design.linear.linear_path import freeze
from workbench.design.linear.linear_period import jump_of

LOOP = "a `ClosedLoop`, a `DigitalLoop`, or equations, an `Ode` or a `SampledSystem`, with inputs and outputs"
Equations = Ode | SampledSystem


@dataclass(frozen=True, eq=False)
class LoopEquations:
    """The equations of a loop that is closed, and of the same loop cut at `drive`, the labels of what arrives there.

    The inputs of `closed_loop` are added to its signals. Those of `open_loop` are the drives and then the same ones;
    its outputs are what arrives and then the others. It is cut at the `channels`, places of drives; at the others only
    a delay acts. Equations that are no loop of blocks have no cut.
    """

    closed_loop: Equations
    open_loop: Equations | None = None
    drive: tuple[str, ...] = ()
    channels: tuple[int, ...] = ()
    delays: tuple[float, ...] = ()  # in s, one for each drive

    @staticmethod
    def of(
        call: str,
        loop: Loop | Ode | SampledSystem,
        at: Sequence[str] | None,
        delays: Mapping[str, float],
        frozen_states: Sequence[str],
    ) -> LoopEquations:
        """The equations of a loop that is cut at some of its ports, all inputs of the plant if `at` is None."""
        if isinstance(loop, Ode | SampledSystem):
            if at is not None or delays:
                raise ValueError(
                    f"`{call}({'delays' if delays else 'at'}=...)` needs a `ClosedLoop` or a `DigitalLoop`, which "
                    f"knows its ports; '{loop.name}' is equations alone."
                )
            _refuse_bare(call, loop)
            return LoopEquations(_freeze(call, loop, frozen_states))
        made = getattr(loop, "ode", None)
        if isinstance(loop, type) or not callable(made) or not {"inputs", "at"} <= _keywords(made):
            raise refusal(f"{call}(loop=...)", LOOP, loop)
        closed = made("loop", inputs=True)
        names = flow_of(closed).drives if at is None else several(f"{call}(at=...)", at, str, 1)
        ports = port_names(f"{call}(at=...)", closed, names)
        late = port_names(f"{call}(delays=...)", closed, tuple(delays))
        opened = made("loop", inputs=True, at=tuple(dict.fromkeys((*ports, *late))))
        drive = labels_of(Layout(opened.outputs.entries[: len({*ports, *late})]))
        times = np.zeros(len(drive))
        for name, time in delays.items():
            times[places_of_names(drive, name)] = finite(f"{call}(delays=...)", time, " of seconds", low=0)
        if times.any() and isinstance(closed, SampledSystem):
            raise ValueError(
                f"`{call}(delays=...)` is for a loop in continuous time; the commands of a computer wait for whole "
                "periods: give them to `DigitalLoop(delay=...)`."
            )
        channels = tuple(dict.fromkeys(i for name in names for i in places_of_names(drive, name)))
        closed, opened = _freeze(call, closed, frozen_states), _freeze(call, opened, frozen_states)
        return LoopEquations(closed, opened, drive, channels, tuple(times.tolist()))

    @property
    def ports(self) -> tuple[str, ...]:
        """The outputs on which the loop depends, as the plant's own inputs and outputs; of equations alone all."""
        flow = flow_of(self.closed_loop)
        return (*flow.drives, *flow.measures) if self.open_loop is not None else flow.outputs.names


def port_names(call: str, closed_loop: Equations, labels: Sequence[str]) -> tuple[str, ...]:
    """The ports to which names or labels such as `tau[0]` belong, each once; what is no port is refused."""
    flow = flow_of(closed_loop)
    ports = [*flow.drives, *flow.measures]
    numbers = {label: name for name in ports for label in labels_of(Layout((flow.outputs[name],)))}
    for label in labels:
        if label not in ports and label not in numbers:
            raise LookupError(
                f"`{call}` must name a port of the plant, an input or an output, at which a loop can be cut; "
                f"'{label}' is none of {', '.join(ports)}.{nearest(label, [*ports, *numbers])}"
            )
    return tuple(dict.fromkeys(label if label in ports else numbers[label] for label in labels))


def labels_of(layout: Layout) -> tuple[str, ...]:
    """The names of the numbers of a layout; one of a single number goes by its own name."""
    return tuple(n for e in layout.entries for n in (e.labels() if e.size > 1 else [e.name]))


def chosen_places(call: str, layout_labels: Sequence[str], names: Sequence[str] | None, of: str) -> list[int]:
    """The places of some names, each a label or a whole vector; all of them if None."""
    if names is None:
        return list(range(len(layout_labels)))
    places: list[int] = []
    for name in several(call, names, str, 1):
        own = places_of_names(layout_labels, name)
        if not own:
            known_name(name, dict.fromkeys([*layout_labels, *(n.partition("[")[0] for n in layout_labels)]), of)
        places += own
    return places


def places_of_names(labels: Sequence[str], name: str) -> list[int]:
    """The places of a label, or of all numbers of a vector."""
    return [i for i, label in enumerate(labels) if name in (label, label.partition("[")[0])]


def flow_of(equations: Equations) -> Ode:
    """The equations in continuous time."""
    return equations.flow if isinstance(equations, SampledSystem) else equations


def rows_by_name(source: Layout, target: Layout, rows: Array) -> Array:
    """Rows (N, size) of another layout, whose numbers of the same names are taken over; the rest are its defaults."""
    found = np.tile(target.default, (len(rows), 1))
    for entry in target.entries:
        if entry.name in source:
            found[:, target.slice(entry.name)] = rows[:, source.slice(entry.name)]
    return found


def instants_of(system: SampledSystem) -> tuple[int, float]:
    """The number of periods after which the jump is the same again, and their common length in s."""
    jump = jump_of(system)
    symbols, moduli = (jump.t, jump.x, jump.p), set[float]()

    def operation(code: int, *a: ca.SX) -> ca.SX:
        if code == ca.OP_FMOD and ca.depends_on(a[0], jump.t) and a[1].is_constant():
            moduli.add(float(a[1]))
        if code == ca.OP_ASSIGN:
            return a[0]
        return ca.SX.unary(code, *a) if len(a) == 1 else ca.SX.binary(code, *a)

    function = ca.Function("jump", [*symbols], [jump.rate], {"cse": True})
    if any(function.instruction_id(k) == ca.OP_FMOD for k in range(function.n_instructions())):
        evaluate_sx(function, lambda part, entry: symbols[part][entry], ca.SX, operation, call_again)
    length, counts = common_period([system.period, *(system.period * m for m in sorted(moduli))])
    return counts[0], length


def _keywords(function: Callable[..., object]) -> set[str]:
    return set(inspect.signature(function).parameters)


def _refuse_bare(call: str, equations: Equations) -> None:
    for what, size in (("input", len(flow_of(equations).inputs)), ("output", equations.outputs.size)):
        if not size:
            raise ValueError(
                f"`{call}(loop=...)` must have at least one {what} to be answered; '{equations.name}' has none: give "
                "the `ClosedLoop` or `DigitalLoop` itself, or equations with `inputs=True`."
            )


def _freeze(call: str, equations: Equations, names: Sequence[str]) -> Equations:
    """The same equations with the named states as parameters."""
    names = several(f"{call}(freeze=...)", names, str)
    if not names:
        return equations
    if isinstance(equations, Ode):
        return freeze(equations, names)
    flow = freeze(equations.flow, names)
    fixed = {place for name in names for place in equations.states.indices(name)}
    jump = equations.jump[[i for i in range(equations.jump.numel()) if i not in fixed]]
    return replace(equations, flow=flow, jump=jump, law_of=None, crossings=(), crossing_jump=None)


def split_values(call: str, closed_loop: Equations, values: Values) -> tuple[Array, Array, list[int]]:
    """States (N, nx) and parameters (N, np) with values by name, and the places of the states that are named."""
    states = {name: value for name, value in values.items() if _in(closed_loop.states, name)}
    rest = {name: value for name, value in values.items() if name not in states}
    for name in rest:
        if not _in(closed_loop.parameters, name):
            known_name(
                name,
                [*closed_loop.parameters.names, *closed_loop.states.names],
                f"parameters and states of '{closed_loop.name}'",
            )
    empty = [name for name, one in values.items() if _is_empty(one)]
    if empty:
        raise ValueError(f"`{call}(...)` must have at least one value for each name; '{empty[0]}' has none.")
    x, p = closed_loop.states.pack(states), closed_loop.parameters.pack(rest)
    count = max(len(x), len(p))
    if {len(x), len(p)} - {1, count}:
        raise ValueError(f"`{call}(...)` must have one number of rows; got {len(x)} of states, {len(p)} of parameters.")
    fixed = sorted({place for name in states for place in closed_loop.states.indices(name)})
    x, p = (np.repeat(rows, count // len(rows), axis=0) for rows in (x, p))
    return x, p, fixed


def _in(layout: Layout, name: object) -> bool:
    return name in layout or name in layout.labels


def _is_empty(value: Numbers) -> bool:
    """True for a list or an array that has no number."""
    return not (value.size if isinstance(value, np.ndarray) else len(value) if isinstance(value, list | tuple) else 1)

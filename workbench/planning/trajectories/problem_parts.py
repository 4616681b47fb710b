"""The problem of a plan from what its user names: costs, limits and jumps as functions of the plant's own names."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Ode, Signals
from workbench.core.equations import LOOP, Loop, equations_of, is_loop
from workbench.core.expressions import refuse_unknown
from workbench.core.sampled_system import SampledSystem
from workbench.core.validation.refusals import Array, describe, error_text, finite, known_name, refusal
from workbench.planning.trajectories.phase import Cost, NamedNumbers, Phase
from workbench.planning.trajectories.plan_names import (
    duration_pair,
    fixed_numbers,
    fixed_values,
    limit_pair,
    limit_values,
)
from workbench.planning.trajectories.plan_problem import Ends, PhaseProblem

CALL = "plan"
PLANT = "a plant by itself is driven by its inputs as `wb.open_loop(plant)`"
NO_LIMIT = (None, None)
Expression = Callable[..., object]


def equation_of(system: Ode | SampledSystem | Loop) -> Ode:
    """The equations of a system in continuous time that has inputs."""
    if not is_loop(system):
        is_plant = hasattr(system, "inputs") and hasattr(system, "rate")
        raise refusal(f"{CALL}(system=...)", LOOP, system, f": {PLANT}" if is_plant else "")
    ode = equations_of(system, "loop")
    if isinstance(ode, SampledSystem):
        raise ValueError(
            f"`{CALL}(system=...)` must be in continuous time; a computer closes this loop: plan for the plant alone, "
            "`wb.open_loop(plant)`, and follow the plan in the loop."
        )
    if not ode.inputs:
        raise ValueError(
            f"`{CALL}(system=...)` must have inputs, which the plan chooses; '{ode.name}' has none: give "
            "`wb.open_loop(plant)`, or `loop.ode(inputs=True)` to plan what enters a loop."
        )
    return ode


@dataclass(frozen=True, eq=False)
class PlanParts:
    """The symbols of a problem, and the parts that its user gave for all phases."""

    ode: Ode
    cost: Cost
    limits: NamedNumbers
    rate_limits: NamedNumbers
    signals: Mapping[str, Expression]
    values: Mapping[str, float]

    def __post_init__(self) -> None:
        if not self.inputs.size:
            raise ValueError(
                f"`{CALL}(values=...)` must leave an input to be planned; it holds all of them at numbers."
            )

    @property
    def inputs(self) -> Layout:
        """The inputs that are planned, with their units: those that `values` does not hold at a number."""
        return Layout(tuple(self.ode.parameters[name] for name in self.ode.inputs if name not in self.values))

    @property
    def moves(self) -> Layout:
        """The states and the inputs."""
        return self.ode.states + self.inputs

    @property
    def input_places(self) -> tuple[int, ...]:
        """The places of the inputs among the parameters."""
        return tuple(int(i) for name in self.inputs.names for i in self.ode.parameters.indices(name))

    def parameters(self, values: Mapping[str, float]) -> Array:
        """(np,), with the values given."""
        p = self.ode.parameters.default.copy()
        own = [label for i, label in enumerate(self.ode.parameters.labels) if i not in self.input_places]
        for name, value in {**self.values, **values}.items():
            known_name(name, own, f"parameters of '{self.ode.name}'")
            p[self.ode.parameters.labels.index(name)] = finite(f"{CALL}(values={{{name!r}: ...}})", value)
        self.ode.parameters.check(p[np.newaxis])
        return p

    def phase(self, phase: Phase, place: int) -> PhaseProblem:
        """The problem of one phase."""
        ode, p = self.ode, self.parameters(phase.values)
        t, x, u = ca.SX.sym("t"), ode.states.symbols(), self.inputs.symbols()
        full = ca.SX(p)
        for i, k in enumerate(self.input_places):
            full[k] = u[i]
        signals = Signals(ode.states.view(x)), Signals(self.inputs.view(u))
        cost = self._cost_rate(self.cost if phase.cost is None else phase.cost, (t, x, u), signals, full)
        rate = ca.Function("rate", [t, x, u], [ca.densify(ode.f(t, x, full)), cost], {"cse": True})
        limits = {**self.limits, **phase.limits}
        names, low, high, path = self._path({**dict.fromkeys(phase.end, NO_LIMIT), **limits}, t, x, full, signals)
        call = f"{CALL}(until" if not phase.name else f"Phase(name={phase.name!r}, until"
        box = limit_values(f"{CALL}(limits", self._of(limits), self.moves, "states, inputs, outputs and signals")
        nx = ode.states.size
        slopes = {**self.rate_limits, **phase.rate_limits}
        return PhaseProblem(
            phase.name or f"phase {place + 1}",
            p,
            duration_pair(f"{call}=...)", phase.until),
            rate,
            ca.Function("path", [t, x, u], [path]),
            names,
            Ends(box.low[:nx], box.high[:nx]),
            Ends(box.low[nx:], box.high[nx:]),
            limit_values(f"{CALL}(rate_limits", slopes, self.inputs, "inputs"),
            Ends(low, high),
            fixed_values(f"{CALL}(end", self._of(phase.end), self.moves, "states, inputs, outputs and signals"),
            self._signal_ends(names, phase.end),
            self._jump(phase),
        )

    def _of(self, named: NamedNumbers) -> dict[str, object]:
        """The limits or values that are not of outputs or signals."""
        moves = {*self.moves.names, *self.moves.labels}
        return {name: value for name, value in named.items() if name in moves or not self._is_output(name)}

    def _signal_ends(self, names: tuple[str, ...], end: NamedNumbers) -> Ends:
        """The values of outputs and signals at the end, infinite ends where there is none."""
        layout = Layout(tuple(Entry(name, np.zeros(())) for name in names))
        own: dict[str, object] = {}
        for name in (name for name in end if name not in self._of(end)):
            is_output = name not in self.signals
            labels = [self.ode.outputs.labels[int(i)] for i in self.ode.outputs.indices(name)] if is_output else [name]
            call = f"{CALL}(end={{{name!r}: ...}})"
            own |= dict(zip(labels, fixed_numbers(call, end[name], len(labels)), strict=True))
        return fixed_values(f"{CALL}(end", own, layout, "outputs and signals")

    def _is_output(self, name: str) -> bool:
        return name in self.signals or name in self.ode.outputs or name in self.ode.outputs.labels

    def _path(
        self, limits: NamedNumbers, t: ca.SX, x: ca.SX, p: ca.SX, signals: tuple[Signals, Signals]
    ) -> tuple[tuple[str, ...], Array, Array, ca.SX]:
        """The labels, ends and expressions of the outputs and signals among these names."""
        names, lows, highs, parts = [], [np.zeros(0)], [np.zeros(0)], [ca.SX(0, 1)]
        y, outputs = self.ode.h(t, x, p), self.ode.outputs
        for name in (name for name in limits if name not in self._of(limits)):
            if name in self.signals:
                value, labels = (
                    self._value(f"{CALL}(signals={{{name!r}: ...}})", self.signals[name], t, *signals),
                    [name],
                )
            else:
                places = [int(i) for i in outputs.indices(name)]
                value, labels = ca.vertcat(*[y[i] for i in places]), [outputs.labels[i] for i in places]
            low, high = limit_pair(f"{CALL}(limits", name, limits[name], len(labels))
            names += labels
            lows.append(low)
            highs.append(high)
            parts.append(ca.densify(value))
        return tuple(names), np.concatenate(lows), np.concatenate(highs), ca.vertcat(*parts)

    def _cost_rate(
        self, cost: Cost, symbols: tuple[ca.SX, ca.SX, ca.SX], signals: tuple[Signals, Signals], p: ca.SX
    ) -> ca.SX:
        t, x, u = symbols
        if isinstance(cost, str):
            if cost not in ("time", "energy"):
                must = "'time', 'energy' (the integral of the squares of the inputs), a function (t, x, u), or an `SX`"
                raise refusal(f"{CALL}(cost=...)", must, cost)
            return ca.SX(1) if cost == "time" else ca.densify(ca.sumsqr(u))
        if isinstance(cost, ca.SX):
            ode = self.ode
            refuse_unknown(CALL, {"t": ode.t, "x": ode.x, "p": ode.p}, cost=cost)
            function = ca.Function("cost", [ode.t, ode.x, ode.p], [cost])
            return _scalar(f"{CALL}(cost=...)", function(t, x, p))
        return self._value(f"{CALL}(cost=...)", cost, t, *signals)

    def end_cost(self, function: Expression | None) -> ca.Function:
        """The cost at the end as a function of time and states there."""
        t, x = ca.SX.sym("t"), self.ode.states.symbols()
        signals = Signals(self.ode.states.view(x))
        value = ca.SX(0) if function is None else self._value(f"{CALL}(end_cost=...)", function, t, signals)
        return ca.Function("end_cost", [t, x], [value])

    def _value(self, call: str, function: Expression, *arguments: object) -> ca.SX:
        """The value of a user's function for symbols: one expression in them."""
        count = "t, x, u" if len(arguments) == 3 else "t, x"
        try:
            value = function(*arguments)
        except LookupError:
            raise
        except Exception as error:  # whatever a function of a user's own does with symbols
            must = f"must be a function of {count} that computes with symbols, as x.{self.ode.states.names[0]}"
            raise ValueError(f"`{call}` {must}; it raised {error_text(error)}.") from error
        return _scalar(call, value)

    def _jump(self, phase: Phase) -> ca.Function | None:
        if phase.jump is None:
            return None
        x = self.ode.states.symbols()
        parts = self.ode.states.view(x)
        given = phase.jump(Signals(parts))
        if not isinstance(given, Mapping):
            raise ValueError(
                f"`Phase(jump=...)` must return the states that jump by name; it returned {describe(given)}."
            )
        for name in given:
            known_name(name, self.ode.states.names, f"states of '{self.ode.name}'")
        after = self.ode.states.flatten({**parts, **{name: ca.SX(value) for name, value in given.items()}})
        return ca.Function("jump", [x], [after])


def _scalar(call: str, value: object) -> ca.SX:
    try:
        part = ca.SX(value)  # type: ignore[call-overload]  # whatever it is that came
    except Exception:
        raise ValueError(f"`{call}` must be one expression; got {describe(value)}.") from None
    if part.shape != (1, 1):
        raise ValueError(f"`{call}` must be one number, (1, 1); got shape {part.shape}.")
    return ca.SX(ca.densify(part))

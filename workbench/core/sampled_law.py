"""SampledLaw: what the computer of a loop does at a sampling instant, from readings and references to commands."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import ClassVar

import casadi as ca
import numpy as np

from workbench.core.crossing import Crossing, refuse_strangers
from workbench.core.expressions import refuse_misfit, refuse_unknown
from workbench.core.fingerprints import fingerprint_of
from workbench.core.layout import Entry, Layout, layouts_to_html
from workbench.core.ode import Ode
from workbench.core.step import StepMap, StepRule
from workbench.core.validation.refusals import Array, seconds
from workbench.core.validation.signatures import check_arguments

SYMBOLS = {"z": "memory", "y": "readings", "r": "references", "p": "parameters"}  # each with its layout


@dataclass(frozen=True)
@check_arguments
class Stage:
    """Values that a sampled law computes together, by name, and the equations of the block that they come from.

    The values are expressions in the symbols of the law and of its crossings. Values of the memory are those of the
    next instant.

    Parameters
    ----------
    title
        The kind and the class of the block.
    values
        The expressions by name.
    equations
        The docstring of the block.
    """

    title: str
    values: Mapping[str, ca.SX]
    equations: str = ""


@dataclass(frozen=True, eq=False)
@check_arguments
class SampledLaw:
    """A law as a computer runs it, from readings and references to commands, at t_k = k period, k = 0, 1, ...:

        u = c(k, z, y, r, p),     z+ = g(k, z, y, r, p).

    `SampledSystem.law` makes one. The command u acts from t_k to the next instant.

    Parameters
    ----------
    name
        The name of the law.
    period
        The sampling period in s.
    memory
        Layout of z: the memories of observer and law, and delayed commands. Its defaults are the first value of z.
    readings
        Layout of y, the readings of the instruments.
    references
        Layout of r, the references; empty if the reference is built in.
    commands
        Layout of u.
    parameters
        Layout of p, with the values of the parameters.
    k, z, y, r, p
        The symbols of the sample index k, (1, 1), and of memory, readings, references and parameters, (size, 1).
    command
        The expression of u in these symbols.
    update
        The expression of z+ in these symbols.
    stages
        Intermediate values, in the order in which they are computed, with their equations for readers of the code.
    limits
        Limits (low, high) of commands, by name.
    delay
        Delays of commands in periods, by name.
    notes
        Warnings for a reader of the code.
    crossings
        Intermediate values that are computed first, in this order, and then used as plain numbers. So expressions
        before and after them are never simplified together. Each has a symbol and an expression.
    crossing_result
        [z+; u] written with the symbols of `crossings`. By default it is written without them.
    answers_missing
        True if the law itself answers readings and references that are not finite, as by its `safe_command`.

    Raises
    ------
    ValueError
        If the period is not a positive finite number, or an expression has another size than its layout or a symbol
        other than k, z, y, r and p.

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0)
    >>> loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    >>> law = loop.digital(0.01, delay=True).law()
    >>> law.readings.names, law.references.names, law.commands.names, law.memory.names[0]
    (('omega',), ('omega',), ('v',), 'controller.integral')
    """

    name: str
    period: float
    memory: Layout
    readings: Layout
    references: Layout
    commands: Layout
    parameters: Layout
    k: ca.SX
    z: ca.SX
    y: ca.SX
    r: ca.SX
    p: ca.SX
    command: ca.SX
    update: ca.SX
    stages: tuple[Stage, ...] = ()
    limits: Mapping[str, tuple[Array, Array]] = field(default_factory=dict)
    delay: Mapping[str, int] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    crossings: tuple[Crossing, ...] = ()
    crossing_result: ca.SX | None = None
    answers_missing: bool = False

    WAYS: ClassVar = {"ClosedLoop": "take `loop.digital(period)`, whose law it is"}

    def __post_init__(self) -> None:
        seconds("SampledLaw(period=...)", self.period)
        for name, port in SYMBOLS.items():
            refuse_misfit(
                "SampledLaw", name, getattr(self, name), getattr(self, port).size, 1, f"one of each of {port}"
            )
        refuse_misfit("SampledLaw", "k", self.k, 1, 1, "the number of the instant")
        refuse_misfit("SampledLaw", "command", self.command, self.commands.size, 1, "one for each command")
        refuse_misfit("SampledLaw", "update", self.update, self.memory.size, 1, "one for each of the memory")
        refuse_unknown("SampledLaw", self._symbols, command=self.command, update=self.update)
        refuse_strangers("SampledLaw", self._symbols, self._all_crossings, expressions=self._crossing_result)

    @property
    def _symbols(self) -> dict[str, ca.SX]:
        return {"k": self.k, **{name: getattr(self, name) for name in SYMBOLS}}

    @property
    def uses_time(self) -> bool:
        """True if the command or the update depends on the number k of the instant."""
        return bool(ca.depends_on(ca.vertcat(self.command, self.update), self.k))

    @cached_property
    def step(self) -> StepMap:
        """The law as a `StepMap` with the states [z; u] and the parameters [p; y; r].

        The state u is the command of the last instant. Readings and references are named as 'y.q' and 'r.q'.
        """
        u, handed = self.commands.with_prefix("u."), self.readings.with_prefix("y.") + self.references.with_prefix("r.")
        states, x = self.memory + u, ca.vertcat(self.z, u.symbols())
        values, parameters = handed.symbols(), self.parameters + handed
        p, t, none = ca.vertcat(self.p, values), ca.SX.sym("t"), Layout()
        still = Ode(self.name, states, parameters, none, t, x, p, ca.SX.zeros(x.numel(), 1), ca.SX(0, 1))
        crossings = (Crossing(handed, ca.vertcat(self.y, self.r), values), *self._all_crossings)
        none_of_it = ca.SX(0, 1)
        rule = StepRule(
            ca.SX.sym("h"), self.k, t, x, p, none_of_it, none_of_it, self._crossing_result, none_of_it, crossings
        )
        return StepMap(self.period, states, parameters, none, rule, still, (1.0,))

    @property
    def _crossing_result(self) -> ca.SX:
        return ca.densify(
            ca.vertcat(self.update, self.command) if self.crossing_result is None else self.crossing_result
        )

    @cached_property
    def _all_crossings(self) -> tuple[Crossing, ...]:
        """The crossings, behind one that gives zero for each symbol of the loop on which nothing of the law depends."""
        own = [*self._symbols.values(), *(crossing.symbols for crossing in self.crossings)]
        known = {symbol.element_hash() for symbol in ca.symvar(ca.vertcat(*own))}
        used = ca.symvar(ca.vertcat(ca.SX(0, 1), *(crossing.values for crossing in self.crossings)))
        idle = [symbol for symbol in used if symbol.element_hash() not in known]
        if not idle:
            return self.crossings
        layout = Layout((Entry("idle", np.zeros(len(idle))),))
        return (Crossing(layout, ca.vertcat(*idle), ca.SX.zeros(len(idle), 1)), *self.crossings)

    @cached_property
    def F(self) -> ca.Function:
        """The law as a CasADi function (k, z, y, r, p) -> (z+, u)."""
        values = [ca.densify(self.update), ca.densify(self.command)]
        return ca.Function("workbench_law", [*self._symbols.values()], values, [*self._symbols], ["z_next", "u"])

    @cached_property
    def fingerprint(self) -> str:
        """The digest of equations, period and default values (64 hexadecimal digits), the same in every process."""
        head = [self.period.hex().encode()]
        for port in (self.memory, self.readings, self.references, self.commands, self.parameters):
            head += [repr((entry.name, entry.shape, entry.unit)).encode() for entry in port.entries]
            head += [np.ascontiguousarray(port.default).tobytes()]
        return fingerprint_of(b"".join(head), self.step.rule.parts)

    @check_arguments
    def with_name(self, name: str) -> SampledLaw:
        """A copy of the law with another name."""
        return replace(self, name=name)

    def __repr__(self) -> str:
        ports = {"reading": self.readings, "reference": self.references, "command": self.commands}
        counts = ", ".join(f"{port.size} {word}{'' if port.size == 1 else 's'}" for word, port in ports.items())
        return f"<SampledLaw '{self.name}': every {self.period:g} s, {counts}, {self.memory.size} states>"

    def _repr_html_(self) -> str:
        ports = {"reading": self.readings, "reference": self.references, "command": self.commands}
        ports |= {"memory": self.memory, "parameter": self.parameters}
        return layouts_to_html(f"{self.name}, every {self.period:g} s", ports)

"""Ode: x' = f(t, x, p), y = h(t, x, p), with exact Jacobians and a fingerprint of its equations."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from workbench.core.layout import Array, Entry, Layout
from workbench.core.show import layouts_to_html


@dataclass(frozen=True, eq=False)
class Ode:
    """An ordinary differential equation with named states, parameters and outputs.

    Attributes
    ----------
    t, x, p
        Symbols: time (1, 1) in s, state (nx, 1), parameters (np, 1).
    rate
        f(t, x, p), (nx, 1).
    outputs, output
        Names of y, and y = h(t, x, p) as an expression (ny, 1).
    inputs
        The parameters that an outside signal may drive (the torque of an open loop, say).
    notes
        What a reader must know of these equations: an estimate that uses the truth, say.
    """

    name: str
    states: Layout
    parameters: Layout
    outputs: Layout
    t: ca.SX
    x: ca.SX
    p: ca.SX
    rate: ca.SX
    output: ca.SX
    inputs: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    @staticmethod
    def of(
        name: str,
        states: Layout,
        parameters: Layout,
        symbols: tuple[ca.SX, ca.SX, ca.SX],
        rates: Mapping[str, ca.SX],
        outputs: Mapping[str, ca.SX],
        units: Mapping[str, str] | None = None,
    ) -> Ode:
        """An `Ode` from named rates and outputs over symbols (t, x, p)."""
        entries = tuple(
            Entry(key, np.zeros(value.numel()), (units or {}).get(key, "")) for key, value in outputs.items()
        )
        y = ca.vertcat(*[ca.vec(value) for value in outputs.values()]) if outputs else ca.SX(0, 1)
        return Ode(name, states, parameters, Layout(entries), *symbols, states.flatten(rates), y)

    @cached_property
    def f(self) -> ca.Function:
        """The rate as a CasADi function (t, x, p) -> (nx, 1)."""
        return self._function("f", self.rate)

    @cached_property
    def h(self) -> ca.Function:
        """The outputs as a CasADi function (t, x, p) -> (ny, 1)."""
        return self._function("h", self.output)

    @cached_property
    def A(self) -> ca.Function:
        """The exact Jacobian df/dx as a function (t, x, p) -> (nx, nx)."""
        return self._function("A", ca.densify(ca.jacobian(self.rate, self.x)))

    @cached_property
    def B(self) -> ca.Function:
        """The exact Jacobian df/du for the declared inputs u as a function (t, x, p) -> (nx, nu)."""
        return self._function("B", ca.densify(ca.jacobian(self.rate, self.input_symbols)))

    @cached_property
    def Cy(self) -> ca.Function:
        """The exact Jacobian dh/dx as a function (t, x, p) -> (ny, nx)."""
        return self._function("Cy", ca.densify(ca.jacobian(self.output, self.x)))

    @cached_property
    def D(self) -> ca.Function:
        """The exact Jacobian dh/du for the declared inputs u as a function (t, x, p) -> (ny, nu)."""
        return self._function("D", ca.densify(ca.jacobian(self.output, self.input_symbols)))

    def _function(self, name: str, value: ca.SX) -> ca.Function:
        return ca.Function(f"workbench_{name}", [self.t, self.x, self.p], [value], {"cse": True})

    @property
    def input_symbols(self) -> ca.SX:
        """The symbols of the declared inputs, (nu, 1)."""
        return ca.vertcat(*[self.p[self.parameters.slice(name)] for name in self.inputs])

    def rate_at(self, t: float, x: Array, p: Array | None = None) -> Array:
        """f(t, x, p) as numbers (nx,), at default parameters unless p is given."""
        return np.array(self.f(t, x, self.parameters.default if p is None else p)).ravel()

    def outputs_at(self, t: float, x: Array, p: Array | None = None) -> dict[str, Array]:
        """The outputs by name at one state."""
        y = np.array(self.h(t, x, self.parameters.default if p is None else p)).ravel()
        return self.outputs.unpack(y)

    @cached_property
    def fingerprint(self) -> str:
        """A name of the equations (64 hexadecimal digits), the same in every process.

        It changes with any operation, constant, name or unit, and with no default value: numbers
        belong to a run, not to the equations.
        """
        digest = hashlib.sha256()
        for layout in (self.states, self.parameters, self.outputs):
            for entry in layout.entries:
                digest.update(repr((entry.name, entry.shape, entry.unit)).encode())
        function = ca.Function("f", [self.t, self.x, self.p], [self.rate, self.output])
        for line in instructions(function):
            digest.update(repr(line).encode())
        return digest.hexdigest()

    def _repr_html_(self) -> str:
        """What a notebook shows: the names, units and values of states and parameters."""
        return layouts_to_html(self.name, {"state": self.states, "parameter": self.parameters})


def instructions(function: ca.Function) -> list[tuple[Any, ...]]:
    """The operations of an SX function in order, as plain tuples that print the same everywhere."""
    lines: list[tuple[Any, ...]] = []
    for k in range(function.n_instructions()):
        op = function.instruction_id(k)
        value = function.instruction_constant(k).hex() if op == ca.OP_CONST else ""
        lines.append((op, tuple(function.instruction_input(k)), tuple(function.instruction_output(k)), value))
    return lines

"""Limits of inputs, states, outputs and their rates along an experiment."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from workbench.core import Ode
from workbench.core.expressions import rows
from workbench.core.validation.refusals import Array, describe, known_name

RATE = "rate of "


@dataclass(frozen=True, eq=False)
class PathLimits:
    """Limits low <= v(t) <= high of inputs, of states, outputs and rates by name; the inputs are parameters of `ode`.

    The rate of a state is that of the equation, the rate of an input the slope between two samples.
    """

    ode: Ode
    inputs: tuple[str, ...]  # labels
    names: tuple[str, ...]  # of the limits along the path
    low: Array  # (nl,)
    high: Array  # (nl,)
    slopes: tuple[tuple[int, float, float], ...]  # of the rates of inputs: place of the input, low and high

    @staticmethod
    def of(ode: Ode, inputs: tuple[str, ...], limits: Mapping[str, tuple[float, float]]) -> PathLimits:
        """The limits by name; a name of a vector limits each of its entries.

        Raises
        ------
        ValueError
            If two limits cross, or none is finite.
        LookupError
            If a name is unknown.
        """
        names, ends, slopes = [], [], []
        for name, pair in limits.items():
            low, high = _ends(name, pair)
            rate, base = (RATE, name.removeprefix(RATE)) if name.startswith(RATE) else ("", name)
            for label in _labels(ode, inputs, base):
                if rate and label in inputs:
                    slopes.append((inputs.index(label), low, high))
                else:
                    names.append(rate + label)
                    ends.append((low, high))
        bounds = np.reshape(ends, (-1, 2))
        return PathLimits(ode, inputs, tuple(names), bounds[:, 0], bounds[:, 1], tuple(slopes))

    @property
    def all_names(self) -> tuple[str, ...]:
        """The names of all limits: those along the path, then those of the rates of inputs."""
        return (*self.names, *(RATE + self.inputs[i] for i, _, _ in self.slopes))

    @cached_property
    def all_ends(self) -> Array:
        """(all limits, 2), the ends of each."""
        return np.vstack([np.column_stack([self.low, self.high]), np.reshape([e[1:] for e in self.slopes], (-1, 2))])

    @cached_property
    def scales(self) -> Array:
        """(all limits,), the range of each limit, or the size of its only finite end."""
        ends = self.all_ends
        width = ends[:, 1] - ends[:, 0]
        size = np.maximum(np.where(np.isfinite(ends), np.abs(ends), 0.0).max(axis=1), np.finfo(float).tiny)
        return np.where(np.isfinite(width), width, size)

    @cached_property
    def _functions(self) -> tuple[ca.Function, ca.Function]:
        """The limited quantities of (t, x, p, u), and their derivatives by x and u, row by row."""
        ode, u = self.ode, ca.SX.sym("u", len(self.inputs))
        places = [ode.parameters.labels.index(label) for label in self.inputs]
        values = [self._expression(name, places) for name in self.names]
        v = ca.substitute(ca.vertcat(ca.SX(0, 1), *values), ode.p[places], u)
        slopes = ca.densify(ca.jacobian(v, ca.vertcat(ode.x, u)))
        arguments = [ode.t, ode.x, ode.p, u]
        return (
            ca.Function("limited", arguments, [ca.densify(v)]),
            ca.Function("slopes", arguments, [ca.vec(slopes.T)]),
        )

    def _expression(self, name: str, places: list[int]) -> ca.SX:
        ode, base = self.ode, name.removeprefix(RATE)
        if base in self.inputs:
            return ode.p[places[self.inputs.index(base)]]
        labels = (*ode.states.labels, *ode.outputs.labels)
        value = ca.vertcat(ode.x, ode.output)[labels.index(base)]
        if base == name:
            return value
        if ca.depends_on(value, ode.p[places]):
            raise ValueError(
                f"`design_experiment(limits={{{name!r}: ...}})` needs a quantity that moves by the equation alone; "
                f"'{base}' jumps with an input: limit the rate of that input."
            )
        return ca.jtimes(value, ode.x, ode.rate) + ca.jacobian(value, ode.t)

    def values(self, t: Array, x: Array, p: Array, u: Array) -> Array:
        """The limited quantities (N, nl) at instants t (N,), states (N, nx), parameters (np,) and inputs (N, nu)."""
        return rows(self._functions[0], t[:, np.newaxis], x, p[np.newaxis], u)

    def derivatives(self, t: Array, x: Array, p: Array, u: Array) -> Array:
        """Their derivatives (N, nl, nx + nu)."""
        flat = rows(self._functions[1], t[:, np.newaxis], x, p[np.newaxis], u)
        return flat.reshape(len(t), len(self.names), -1)


def _ends(name: str, pair: tuple[float, float]) -> tuple[float, float]:
    """The two ends of a limit."""
    call = f"design_experiment(limits={{{name!r}: ...}})"
    try:
        low, high = (float(end) for end in pair)
    except (TypeError, ValueError):
        raise ValueError(f"`{call}` must be a pair of numbers, low and high; got {describe(pair)}.") from None
    if not low < high or not (np.isfinite(low) or np.isfinite(high)):
        raise ValueError(
            f"`{call}` must be two numbers, the lower first, of which one is finite; got {low:g} and {high:g}: no "
            "experiment lies within limits that cross."
        )
    return low, high


def _labels(ode: Ode, inputs: tuple[str, ...], name: str) -> list[str]:
    """The labels of an input, state or output."""
    if name in ode.parameters or name in ode.parameters.labels:
        own = [ode.parameters.labels[i] for i in ode.parameters.indices(name)]
        if set(own) <= set(inputs):
            return own
    layout = ode.outputs if name in ode.outputs or name in ode.outputs.labels else ode.states
    known = dict.fromkeys((*inputs, *layout.names, *layout.labels, *ode.outputs.names))
    known_name(name, known, f"inputs, states and outputs of '{ode.name}'")
    return [layout.labels[i] for i in layout.indices(name)]

"""The outputs of an equation at the samples of a run, and their derivatives in all directions of change at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from workbench.core import Ode
from workbench.core.expressions import rows
from workbench.core.validation.refusals import Array


@dataclass(frozen=True, eq=False)
class OutputMap:
    """Outputs and states y (ny,) of an equation as functions of t, x, p and inputs u (nd,), and their derivatives.

    A label that is a state is copied. Of all others the derivatives by x, p and u are computed once a sample, where
    they are not zero, whatever the number of directions.
    """

    ode: Ode
    labels: tuple[str, ...]  # (ny,), of states and outputs
    inputs: tuple[str, ...]  # (nd,), the parameters in whose place the inputs stand

    def values(self, t: Array, x: Array, p: Array, u: Array) -> Array:
        """The outputs (N, ny) at times t (N,) for states x (N, nx), parameters p (np,) and inputs u (N, nd)."""
        y = np.empty((len(t), len(self.labels)))
        y[:, self._columns] = x[:, self._states]
        if self._others:
            y[:, self._others] = rows(self._functions[0], t[:, np.newaxis], x, p[np.newaxis], u)
        return y

    def derivatives(
        self, t: Array, x: Array, p: Array, u: Array, S: Array, parameters: Sequence[int], du: Sequence[Array]
    ) -> tuple[Array, Array]:
        """The outputs (N, ny), and their derivatives (N, ny, m) in m directions.

        The states change by S (m, N, nx). The first directions are unit changes of the `parameters`, by their places;
        in the following ones the inputs change by `du`, each (N, nd); in the last ones only the states change.
        """
        y, dy = np.empty((len(t), len(self.labels))), np.zeros((len(t), len(self.labels), len(S)))
        y[:, self._columns] = x[:, self._states]
        for j, state in zip(self._columns, self._states, strict=True):
            dy[:, j] = S[:, :, state].T
        if not self._others:
            return y, dy
        flat = rows(self._functions[1], t[:, np.newaxis], x, p[np.newaxis], u)
        y[:, self._others], slopes = flat[:, : len(self._others)], flat[:, len(self._others) :]
        nx, end = x.shape[1], x.shape[1] + p.size
        for (row, column), slope in zip(self._places, slopes.T, strict=True):
            j = self._others[row]
            if column < nx:
                dy[:, j] += (slope * S[:, :, column]).T
            elif column < end:
                for i in (i for i, place in enumerate(parameters) if place == column - nx):
                    dy[:, j, i] += slope
            else:
                for i, change in enumerate(du, len(parameters)):
                    dy[:, j, i] += slope * change[:, column - end]
        return y, dy

    @cached_property
    def _columns(self) -> list[int]:
        """The places of the labels that are states."""
        return [j for j, label in enumerate(self.labels) if label in self.ode.states.labels]

    @cached_property
    def _states(self) -> list[int]:
        return [self.ode.states.labels.index(self.labels[j]) for j in self._columns]

    @cached_property
    def _others(self) -> list[int]:
        """The places of the labels that are outputs alone."""
        return [j for j, label in enumerate(self.labels) if label not in self.ode.states.labels]

    @cached_property
    def _slopes(self) -> tuple[ca.SX, ca.SX, ca.SX]:
        """The inputs u, the outputs that are no states, and their derivatives by [x; p; u]."""
        ode, u = self.ode, ca.SX.sym("u", len(self.inputs))
        y = ode.output[[ode.outputs.labels.index(self.labels[j]) for j in self._others]]
        places = [ode.parameters.labels.index(label) for label in self.inputs]
        y = ca.densify(ca.substitute(y, ode.p[places], u) if places else y)
        return u, y, ca.jacobian(y, ca.vertcat(ode.x, ode.p, u))

    @cached_property
    def _places(self) -> list[tuple[int, int]]:
        """The row and the column of each derivative that is not zero, in the order in which they are computed."""
        return list(zip(*self._slopes[2].sparsity().get_triplet(), strict=True))

    @cached_property
    def _functions(self) -> tuple[ca.Function, ca.Function]:
        """The outputs that are no states, of (t, x, p, u), and the same with the derivatives that are not zero."""
        u, y, J = self._slopes
        symbols = [self.ode.t, self.ode.x, self.ode.p, u]
        both = ca.vertcat(y, ca.vec(J.nz[:]))  # which are a row if J is one
        return ca.Function("outputs", symbols, [y]), ca.Function("slopes", symbols, [both], {"cse": True})

"""The linear models of a loop at thousands of rows of states and parameters, through the compiled kernel."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from workbench.core import Ode, SampledSystem
from workbench.core.validation.refusals import Array
from workbench.design.linear.linear_period import jump_of
from workbench.design.linear_loop.kernel_values import KernelFlow, KernelJacobian
from workbench.design.linear_loop.loop_equations import Equations, flow_of, labels_of
from workbench.design.linear_loop.loop_model import LoopModel, lift_maps
from workbench.design.linear_loop.point_model import Instant, input_labels

Mask = np.ndarray[tuple[int, ...], np.dtype[np.bool_]]
Matrices = tuple[Array, Array, Array, Array]


@dataclass(frozen=True, eq=False)
class RowModels:
    """Equations whose motion and Jacobians are evaluated for many rows at once."""

    equations: Equations
    at: Instant
    substeps: int | None = None

    def motion(self, x: Array, p: Array) -> tuple[Array, Array]:
        """The change of the states (N, nx), and its derivatives by them (N, nx, nx), see `motion_of`."""
        n = x.shape[1]
        if isinstance(self.equations, Ode):
            values, J, _ = self._jacobian(self.at.t, x, p)
            return values[:, :n], J[:, :n, :n]
        state, slope = x, np.tile(np.eye(n), (len(x), 1, 1))
        for k in range(self.at.count):
            state, matrices, _, _ = self._period(k, state, p)
            slope = matrices[0] @ slope
        return state - x, slope - np.eye(n)

    def model(self, x: Array, p: Array) -> tuple[LoopModel, Array, Mask]:
        """The models, the outputs (N, ny) at the states, and the rows on a corner (N,), whose matrices are of none."""
        n, flow = x.shape[1], flow_of(self.equations)
        names = (labels_of(flow.states), input_labels(flow), labels_of(flow.outputs))
        if isinstance(self.equations, Ode):
            values, J, cornered = self._jacobian(self.at.t, x, p)
            matrices = (J[:, :n, :n], J[:, :n, n:], J[:, n:, :n], J[:, n:, n:])
            return LoopModel(*matrices, *names), values[:, n:], cornered
        maps, first, cornered, state = [], None, np.zeros(len(x), dtype=bool), x
        for k in range(self.at.count):
            state, matrices, output, on_corner = self._period(k, state, p)
            maps.append(matrices)
            first, cornered = output if first is None else first, cornered | on_corner
        assert first is not None
        return LoopModel(*lift_maps(maps), *names, self.equations.period, self.at.count), first, cornered

    @cached_property
    def _jacobian(self) -> KernelJacobian:
        return KernelJacobian(flow_of(self.equations))

    @cached_property
    def _jump(self) -> KernelJacobian:
        assert isinstance(self.equations, SampledSystem)
        return KernelJacobian(jump_of(self.equations))

    @cached_property
    def _flow(self) -> KernelFlow:
        assert isinstance(self.equations, SampledSystem)
        return KernelFlow(self.equations.flow, self.equations.period)

    def _period(self, k: int, x: Array, p: Array) -> tuple[Array, Matrices, Array, Mask]:
        """The state after one period, its matrices, the outputs that follow its jump, and the rows on a corner."""
        assert isinstance(self.equations, SampledSystem)
        n, t = x.shape[1], self.at.t + k * self.equations.period
        after, jump, jump_cornered = self._jump(round(t / self.equations.period), x, p)
        values, J, flow_cornered = self._jacobian(t, after, p)
        end, flow = self._flow(t, after, p, self.substeps)
        seen, by_x, by_u = J[:, n:], flow[:, :, :n], flow[:, :, n:]
        A, B = jump[:, :, :n], jump[:, :, n:]
        matrices = (by_x @ A, by_x @ B + by_u, seen[:, :, :n] @ A, seen[:, :, :n] @ B + seen[:, :, n:])
        return end, matrices, values[:, n:], np.asarray(jump_cornered | flow_cornered)

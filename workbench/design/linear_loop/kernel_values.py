"""Values and Jacobians of equations at thousands of rows of states and parameters, through the compiled kernel."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Ode, StepMap, StepRule, rk4, with_sensitivity
from workbench.core.validation.refusals import Array
from workbench.design.linear.linear_path import freeze
from workbench.design.linear.linear_period import FEWEST, MOST_STEPS, STEP_TOLERANCE
from workbench.design.linear.operating_point import places_of
from workbench.design.linear.switching_functions import REACH, Mask, SwitchingFunctions
from workbench.engine.batch import run_step

ROWS = 4096  # at once: their Jacobians take some hundred megabytes
TIME = Layout((Entry("linear_loop.time", np.zeros(()), ""),))  # the time, or the number of a jump, as a parameter


@dataclass(frozen=True, eq=False)
class KernelJacobian:
    """The rate (nx,), the outputs (ny,) and their Jacobian (nx + ny, nx + nu) of an `Ode` at many rows.

    `cornered` rows lie on a corner, where a derivative is that of no piece.
    """

    ode: Ode

    def __call__(self, t: float, x: Array, p: Array) -> tuple[Array, Array, Mask]:
        """Rates and outputs (N, nx + ny), Jacobians (N, nx + ny, nx + nu) and the mask of cornered rows (N,)."""
        sizes, slopes, step = self._step
        values = _evaluate(step, self.ode.states.size, t, x, p)
        heights, entries, sigma, size = np.split(values, np.cumsum(sizes)[:-1], axis=1)
        J = np.zeros((len(x), *slopes.shape))
        rows, columns = slopes.get_triplet()
        J[:, rows, columns] = entries
        return heights, J, np.asarray((np.abs(sigma) <= size).any(axis=1)) | self._cornered_in_loops(t, x, p)

    def _cornered_in_loops(self, t: float, x: Array, p: Array) -> Mask:
        """The mask of rows on a corner within a bounded loop (N,)."""
        corners = SwitchingFunctions.of(self.ode)
        if corners.of_loops is None:
            return np.zeros(len(x), dtype=bool)
        return np.array([corners.at(t, *row) is not corners for row in zip(x, p, strict=True)], dtype=bool)

    @cached_property
    def _step(self) -> tuple[list[int], ca.Sparsity, StepMap]:
        ode = self.ode
        z, both = ca.vertcat(ode.x, ode.input_symbols), ca.densify(ca.vertcat(ode.rate, ode.output))
        J, sigma = ca.jacobian(both, z), SwitchingFunctions.of(ode).sigma
        size = ca.fabs(ca.jacobian(sigma, z)) @ (REACH * (1 + ca.fabs(z)))
        parts = [both, J.nz[:], ca.densify(sigma), ca.densify(size)]
        return [part.numel() for part in parts], J.sparsity(), evaluation(ode, ca.vertcat(*parts))


@dataclass(frozen=True, eq=False)
class KernelFlow:
    """The state after a period of an `Ode`, and its Jacobian (nx, nx + nu), at many rows, by Runge-Kutta steps."""

    ode: Ode
    period: float

    def __call__(self, t: float, x: Array, p: Array, substeps: int | None) -> tuple[Array, Array]:
        """The states (N, nx) and Jacobians; without `substeps` they are doubled until no row changes."""
        if not self.moving_states:
            return x, np.tile(np.eye(x.shape[1], x.shape[1] + len(places_of(self.ode))), (len(x), 1, 1))
        steps, before = substeps or FEWEST, None
        while True:
            end, J = self._march(t, x, p, steps)
            now = np.concatenate([end[:, :, np.newaxis], J], axis=2)
            if substeps or (before is not None and self._has_settled(now, before)) or 2 * steps > MOST_STEPS:
                return end, J
            before, steps = now, 2 * steps

    def _has_settled(self, now: Array, before: Array) -> bool:
        """True if no row changes that is a number."""
        with np.errstate(invalid="ignore"):
            change = np.abs(now - before).max(axis=(1, 2)) / np.abs(now).max(axis=(1, 2))
        return bool((change[np.isfinite(now).all(axis=(1, 2))] <= STEP_TOLERANCE).all()) and bool(
            np.isfinite(now).any()
        )

    @cached_property
    def moving_states(self) -> list[str]:
        """The names of the states that move between two instants."""
        ode = self.ode
        moves = np.array(ca.DM(ca.densify(ode.rate).sparsity(), 1)).ravel() != 0
        moves &= np.array([not ca.SX(part).is_zero() for part in ca.vertsplit(ca.densify(ode.rate))])
        return [entry.name for entry in ode.states.entries if moves[ode.states.slice(entry.name)].any()]

    @cached_property
    def sensitive(self) -> tuple[Ode, list[int], list[int]]:
        """The states that move with their sensitivities, their places, and the columns that these have in J."""
        ode, n = self.ode, self.ode.states.size
        rest = [name for name in ode.states.names if name not in self.moving_states]
        alone = freeze(ode, rest) if rest else ode
        time = TIME.symbols()
        shifted = ca.substitute(alone.rate, alone.t, alone.t + time)
        alone = replace(
            alone,
            states=_without_bounds(alone.states),
            parameters=_without_bounds(alone.parameters + TIME),
            p=ca.vertcat(alone.p, time),
            rate=shifted,
            outputs=Layout(),
            output=ca.SX(0, 1),
            drawing=None,
            horizon=np.inf,
        )
        used = [name for name in rest if ca.depends_on(alone.rate, ode.x[ode.states.slice(name)])]
        columns = [i for name in (*self.moving_states, *used) for i in ode.states.indices(name)]
        driven: dict[str, list[int]] = {name: [] for name in ode.inputs}
        for k, place in enumerate(places_of(ode)):
            driven[next(name for name in driven if place in ode.parameters.indices(name))].append(n + k)
        acting = [name for name in driven if ca.depends_on(alone.rate, ode.p[ode.parameters.slice(name)])]
        columns += [k for name in acting for k in driven[name]]
        rows = [i for name in self.moving_states for i in ode.states.indices(name)]
        return with_sensitivity(alone, (*self.moving_states, *used, *acting)), rows, columns

    def _march(self, t: float, x: Array, p: Array, substeps: int) -> tuple[Array, Array]:
        ode, rows, columns = self.sensitive
        rest = [i for i in range(x.shape[1]) if i not in rows]
        given = np.concatenate([p, x[:, rest], np.full((len(x), 1), t)], axis=1)
        start = np.tile(ode.states.default, (len(x), 1))
        start[:, : len(rows)] = x[:, rows]
        final = _march(rk4(ode, self.period / substeps), given, start, self.period)
        end, J = x.copy(), np.tile(np.eye(x.shape[1], x.shape[1] + len(places_of(self.ode))), (len(x), 1, 1))
        end[:, rows] = final[:, : len(rows)]
        S = final[:, len(rows) :].reshape(len(x), len(columns), len(rows)).swapaxes(1, 2)
        J[:, rows] = 0.0
        J[:, np.array(rows)[:, np.newaxis], columns] = S
        return end, J


def evaluation(ode: Ode, values: ca.SX) -> StepMap:
    """A step after which a memory holds the values, at the time that is its parameter."""
    memory = Layout((Entry("linear_loop.values", np.zeros(values.numel())),))
    h, k, t, time = ca.SX.sym("h"), ca.SX.sym("k"), ca.SX.sym("t"), TIME.symbols()
    at_time = ca.substitute(values, ode.t, time)
    x, p = ca.vertcat(ode.x, memory.symbols()), ca.vertcat(ode.p, time)
    rule = StepRule(h, k, t, x, p, ca.SX(0, 1), ca.SX(0, 1), ca.vertcat(ode.x, at_time), ca.SX(0, 1))
    still = replace(ode, horizon=np.inf)
    states, parameters = _without_bounds(ode.states + memory), _without_bounds(ode.parameters + TIME)
    return StepMap(1.0, states, parameters, Layout(), rule, still, (1.0,))


def _evaluate(step: StepMap, n: int, t: float, x: Array, p: Array) -> Array:
    """The values (N, m) at rows of states and parameters."""
    given = np.concatenate([p, np.full((len(p), 1), t)], axis=1)
    start = np.concatenate([x, np.zeros((len(x), step.states.size - n))], axis=1)
    return _march(step, given, start, 1.0)[:, n:]


def _march(step: StepMap, p: Array, x: Array, until: float) -> Array:
    """The states (N, nx) at a time; NaN in the rows that are not finite."""
    end = np.full(x.shape, np.nan)
    sound = np.flatnonzero(np.isfinite(x).all(axis=1) & np.isfinite(p).all(axis=1))
    for start in range(0, len(sound), ROWS):
        few = sound[start : start + ROWS]
        end[few] = run_step(step, p[few], x[few], until=until, every=until).x[:, 1]
    return end


def _without_bounds(layout: Layout) -> Layout:
    """The same names without bounds, which have been checked, or which a search may leave for a moment."""
    return Layout(tuple(Entry(entry.name, entry.default, entry.unit) for entry in layout.entries))

"""Rows of limits: what a predictive controller must keep between two bounds at every stage of its horizon."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array, as_array, describe
from workbench.core.validation.signatures import check_arguments
from workbench.design.matrices import matrix
from workbench.planning.linear_mpc.array_doors import finite_vector
from workbench.planning.linear_mpc.cone_limits import ConeLimit, StageCone, stage_cones

RATE = "rate of "  # before the name of an input: the row of its change
NO_LIMIT = 1e30  # a bound of this size or larger is none
Pair = tuple[Numbers, Numbers]


@dataclass(frozen=True, eq=False)
@show
class LimitRows:
    """The limits low <= F x_k + E u_k <= high at the stages k = 0 ... N - 1, one row a limit.

    The first nu rows are the inputs themselves, with infinite bounds where an input has no limit. A limit on a state of
    the next stage is a row of it, too: F = A, E = B.

    Parameters
    ----------
    F, E
        (nc, nx) and (nc, nu).
    low, high
        (nc,), in the units of their rows.
    softness
        (nc,), 1 / w of a soft row, whose violation s costs w s^2 at every stage; 0 for a hard row.
    names
        One name a row.
    cones
        The cones among the rows. `low` and `high` of their rows are what other limits imply, for sizes alone.
    """

    F: Array
    E: Array
    low: Array
    high: Array
    softness: Array
    names: tuple[str, ...]
    cones: tuple[StageCone, ...] = ()

    @property
    def count(self) -> int:
        """The number of rows of a stage."""
        return len(self.low)

    @property
    def has_rates(self) -> bool:
        """True if the last rows limit the changes of the inputs."""
        return self.names[-1].startswith(RATE)

    def about(self, x0: Numbers, u0: Numbers) -> LimitRows:
        """The rows for deviations from x0 (nx,) and u0 (nu,)."""
        x0 = finite_vector("LimitRows.about(x0=...)", x0, self.F.shape[1], "states")
        u0 = finite_vector("LimitRows.about(u0=...)", u0, self.E.shape[1], "inputs")
        at = self.F @ x0 + self.E @ u0
        cones = tuple(cone.about(at) for cone in self.cones)
        return LimitRows(self.F, self.E, self.low - at, self.high - at, self.softness, self.names, cones)


def bounds(call: str, value: object, names: tuple[str, ...]) -> tuple[Array, Array]:
    """A pair (low, high), numbers or (n,), as two arrays with infinite entries where there is no bound."""
    n = len(names)
    if not isinstance(value, tuple | list) or len(value) != 2:
        raise ValueError(f"`{call}` must be a pair (low, high); got {describe(value)}.")
    ends = []
    for end in value:
        array = as_array(end)
        if array is None or array.shape not in ((), (n,)) or np.isnan(array).any():
            raise ValueError(f"`{call}` must hold two numbers or two arrays of shape ({n},); got {describe(end)}.")
        array = np.broadcast_to(array, (n,))
        ends.append(np.where(np.abs(array) >= NO_LIMIT, np.copysign(np.inf, array), array))
    low, high = ends
    crossing = [name for name, a, b in zip(names, low, high, strict=True) if not a < b]
    if crossing:
        i = names.index(crossing[0])
        raise ValueError(
            f"`{call}` must have its low end below its high end; '{crossing[0]}' has {low[i]:g} and {high[i]:g}."
        )
    return low, high


def softness(call: str, value: object, n: int) -> Array:
    """1 / w of a soft weight w > 0, a number or (n,); zeros for None, which keeps the rows hard."""
    if value is None:
        return np.zeros(n)
    array = as_array(value)
    if array is None or array.shape not in ((), (n,)) or not (array > 0).all():
        raise ValueError(f"`{call}` must be a weight above zero, or {n} of them; got {describe(value)}.")
    return np.broadcast_to(1 / array, (n,)).copy()


@dataclass(frozen=True, eq=False)
@check_arguments
@show
class MpcLimits:
    """The limits of a predictive controller, each a pair (low, high); bounds of size 1e30 or more are none.

    Parameters
    ----------
    inputs
        Numbers or arrays (nu,), kept at the stages 0 to N - 1.
    states
        Numbers or arrays (nx,), kept at 1 to N.
    outputs
        The pair (C, (low, high)) for C x at 1 to N, with C (ny, nx).
    rates
        Numbers or arrays (nu,) for u_k - u_{k-1}. The state of the problem is then (x_k, u_{k-1}), of size nx + nu.
    output_names
        Names of the outputs, for messages.
    soft_weight
        w > 0, a number or one for each limited state and output: its violation s costs w s^2 and is not forbidden. By
        default these limits are hard.
    cones
        Second-order cones of inputs, kept at 0 to N - 1, or of states, kept at 1 to N. They are hard.

    Examples
    --------
    >>> from workbench.planning.linear_mpc import MpcLimits
    >>> MpcLimits(inputs=(-1.0, 1.0)).inputs
    (-1.0, 1.0)
    """

    inputs: Pair | None = None
    states: Pair | None = None
    outputs: tuple[Numbers, Pair] | None = None
    rates: Pair | None = None
    soft_weight: Numbers | None = None
    output_names: tuple[str, ...] = ()
    cones: tuple[ConeLimit, ...] = ()


def limit_rows(
    A: Array, B: Array, limits: MpcLimits, state_names: tuple[str, ...], input_names: tuple[str, ...]
) -> LimitRows:
    """The rows of inputs, of states of the next stage, and of outputs C x of the next stage."""
    nx, nu = B.shape
    low, high = np.full(nu, -np.inf), np.full(nu, np.inf)
    if limits.inputs is not None:
        low, high = bounds("MpcLimits(inputs=...)", limits.inputs, input_names)
    C, ends, names = np.zeros((0, nx)), (np.zeros(0), np.zeros(0)), list(input_names)
    if limits.states is not None:
        ends = bounds("MpcLimits(states=...)", limits.states, state_names)
        has_limit = np.isfinite(ends[0]) | np.isfinite(ends[1])
        C, ends = np.eye(nx)[has_limit], (ends[0][has_limit], ends[1][has_limit])
        names += [name for name, has in zip(state_names, has_limit, strict=True) if has]
    if limits.outputs is not None:
        more = matrix("MpcLimits(outputs=...)", "C", limits.outputs[0], columns=nx)
        labels = output_labels(limits, len(more))
        own = bounds("MpcLimits(outputs=...)", limits.outputs[1], labels)
        C, ends = np.vstack([C, more]), (np.r_[ends[0], own[0]], np.r_[ends[1], own[1]])
        names += labels
    soft = np.r_[np.zeros(nu), softness("MpcLimits(soft_weight=...)", limits.soft_weight, len(C))]
    F, E = np.vstack([np.zeros((nu, nx)), C @ A]), np.vstack([np.eye(nu), C @ B])
    rows = LimitRows(F, E, np.r_[low, ends[0]], np.r_[high, ends[1]], soft, tuple(names))
    return with_cones(rows, A, B, limits.cones, state_names, input_names) if limits.cones else rows


def with_cones(
    rows: LimitRows,
    A: Array,
    B: Array,
    limits: tuple[ConeLimit, ...],
    state_names: tuple[str, ...],
    input_names: tuple[str, ...],
) -> LimitRows:
    """The rows with those of cones behind them, of inputs or of states of the next stage."""
    cones, of_states, of_inputs = stage_cones(limits, state_names, input_names, rows.count)
    own = {name: (low, high) for name, low, high in zip(rows.names, rows.low, rows.high, strict=True)}
    ends: list[tuple[float, float]] = []
    for limit, cone in zip(limits, cones, strict=True):
        low, high = own.get(limit.axial, (-np.inf, np.inf))
        radius = cone.slope * high + cone.offset if limit.axial else cone.offset
        ends += [(value - radius, value + radius) for value in cone.centre]
        ends += [(max(low, -cone.offset / cone.slope), high)] if limit.axial else []
    low, high = np.array(ends).T
    return LimitRows(
        np.vstack([rows.F, of_states @ A]),
        np.vstack([rows.E, of_states @ B + of_inputs]),
        np.r_[rows.low, low],
        np.r_[rows.high, high],
        np.r_[rows.softness, np.zeros(len(low))],
        rows.names + tuple(cone.name for cone in cones for _ in cone.rows),
        cones,
    )


def output_labels(limits: MpcLimits, count: int) -> tuple[str, ...]:
    """The names of the limited outputs."""
    return limits.output_names[:count] + tuple(f"output[{i}]" for i in range(len(limits.output_names), count))

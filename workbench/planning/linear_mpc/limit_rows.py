"""Rows of limits: what a predictive controller must keep between two bounds at every stage of its horizon."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array, as_array, describe
from workbench.design.matrices import matrix

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
    """

    F: Array
    E: Array
    low: Array
    high: Array
    softness: Array
    names: tuple[str, ...]

    @property
    def count(self) -> int:
        """The number of rows of a stage."""
        return len(self.low)

    def shifted(self, x0: Array, u0: Array) -> LimitRows:
        """The rows for deviations from x0 (nx,) and u0 (nu,)."""
        at = self.F @ x0 + self.E @ u0
        return LimitRows(self.F, self.E, self.low - at, self.high - at, self.softness, self.names)


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
        ends.append(np.where(np.abs(array) >= NO_LIMIT, np.sign(array) * np.inf, array))
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


def limit_rows(
    A: Array,
    B: Array,
    input_limits: Pair | None,
    state_limits: Pair | None,
    outputs: tuple[Numbers, Pair] | None,
    soft_weight: Numbers | None,
    state_names: tuple[str, ...],
    input_names: tuple[str, ...],
) -> LimitRows:
    """The rows of inputs, of states of the next stage, and of outputs C x of the next stage."""
    nx, nu = B.shape
    low, high = np.full(nu, -np.inf), np.full(nu, np.inf)
    if input_limits is not None:
        low, high = bounds("linear_mpc(input_limits=...)", input_limits, input_names)
    C, ends, names = np.zeros((0, nx)), (np.zeros(0), np.zeros(0)), list(input_names)
    if state_limits is not None:
        ends = bounds("linear_mpc(state_limits=...)", state_limits, state_names)
        limited = np.isfinite(ends[0]) | np.isfinite(ends[1])
        C, ends = np.eye(nx)[limited], (ends[0][limited], ends[1][limited])
        names += [name for name, is_limited in zip(state_names, limited, strict=True) if is_limited]
    if outputs is not None:
        more = matrix("linear_mpc(outputs=...)", "C", outputs[0], columns=nx)
        labels = tuple(f"output[{i}]" for i in range(len(more)))
        own = bounds("linear_mpc(outputs=...)", outputs[1], labels)
        C, ends = np.vstack([C, more]), (np.r_[ends[0], own[0]], np.r_[ends[1], own[1]])
        names += labels
    soft = np.r_[np.zeros(nu), softness("linear_mpc(soft_weight=...)", soft_weight, len(C))]
    F, E = np.vstack([np.zeros((nu, nx)), C @ A]), np.vstack([np.eye(nu), C @ B])
    return LimitRows(F, E, np.r_[low, ends[0]], np.r_[high, ends[1]], soft, tuple(names))

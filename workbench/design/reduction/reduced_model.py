"""A model of lower order with the H-infinity norm of its error, and the search for the order that a tolerance needs."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from workbench.core import Entry, Layout
from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array
from workbench.design.control_system import System
from workbench.design.frequency import CertifiedPeak, CertifiedValue, hinf_norm
from workbench.design.frequency.exact_systems import is_stable
from workbench.design.frequency.hinf_norm import MOST_STATES
from workbench.design.linear.operating_point import state_space
from workbench.design.matrices import Complex, DesignError
from workbench.design.reduction.balanced_realization import BalancedRealization, HankelValues, balanced_realization

Matrices: TypeAlias = tuple[Array, Array, Array, Array]
Reduction: TypeAlias = Callable[[BalancedRealization, int], tuple[Matrices, float]]
EQUAL = 1e-10  # relative: two Hankel values that are nearer to each other count as one
ROUNDING = 1e-12  # of the largest Hankel value: what the doubles of a reduced model cost
GRID = 200  # frequencies of the lower side of an error without a certified norm


@dataclass(frozen=True, eq=False)
@show
class ReducedModel:
    """A stable `system` of lower order, a `StateSpace` with the same inputs and outputs, about the same point.

    `error` is the H-infinity norm of the difference of both systems, enclosed by `wb.hinf_norm`. If that proves none,
    its lower bound is a gain at one frequency, and its upper bound is `bound` with an allowance for rounding. `bound`
    is that of the theorem for the `method`; it counts each Hankel value as often as it occurs.
    """

    system: System
    method: str
    hankel: HankelValues
    error: CertifiedPeak
    bound: float
    poles: Complex

    @property
    def order(self) -> int:
        """The number of states of the reduced system."""
        return len(self.poles)

    @property
    def within_bound(self) -> bool:
        """True if the error does not exceed the bound, but for the rounding of the reduced matrices."""
        rounding = ROUNDING * float(self.hankel.values.max(initial=0.0))
        return self.error.gain.low <= self.bound * (1 + 1e-9) + rounding


def reduced_model(
    call: str, method: str, system: System, order: int | None, tolerance: float | None, reduce: Reduction
) -> ReducedModel:
    """The reduced model of an order, or of the least order whose proved error is at most a tolerance."""
    n = len(state_space(call, system)[0])
    if (order is None) == (tolerance is None):
        raise ValueError(f"`{call}(system, order, tolerance)` takes either an order or a tolerance of the error.")
    if order is not None and not 0 <= order <= n:
        raise ValueError(f"`{call}(order=...)` must lie between 0 and the {n} states; got {order}.")
    if tolerance is not None and not 0 < tolerance < np.inf:
        raise ValueError(f"`{call}(tolerance=...)` must be a finite number above zero; got {tolerance}.")
    realization = balanced_realization(call, system)
    if order is not None:
        order = min(order, realization.hankel.minimal_order)
        _refuse_cut(call, realization.values, order)
        return _model(call, method, system, realization, order, reduce)
    assert tolerance is not None
    for order in range(realization.hankel.minimal_order + 1):
        # no model of this order has a smaller error than the first value that it leaves out
        if _is_cut(realization.values, order) or max(realization.values[order:], default=0.0) > tolerance:
            continue
        model = _model(call, method, system, realization, order, reduce)
        if model.error.gain.high <= tolerance:
            return model
    raise DesignError(
        f"`{call}(system, tolerance={tolerance:g})`: rounding alone leaves a larger error at full order; choose a "
        "larger tolerance."
    )


def _is_cut(values: Array, order: int) -> bool:
    return 0 < order < len(values) and bool(values[order - 1] - values[order] <= EQUAL * values[order - 1])


def _refuse_cut(call: str, values: Array, order: int) -> None:
    if not _is_cut(values, order):
        return
    free = [k for k in range(len(values) + 1) if not _is_cut(values, k)]
    near = max(k for k in free if k < order), min(k for k in free if k > order)
    raise DesignError(
        f"`{call}(system, order={order})` would cut between equal Hankel values of {values[order]:.6g}, so that the "
        f"model is not unique and may be unstable; take order {near[0]} or {near[1]}."
    )


def _model(
    call: str, method: str, system: System, realization: BalancedRealization, order: int, reduce: Reduction
) -> ReducedModel:
    matrices, bound = reduce(realization, order)
    A = matrices[0]
    if not is_stable(A, realization.discrete):
        raise DesignError(
            f"`{call}(system, order={order})`: the reduced model is not stable in doubles, as a mode decays too "
            "slowly; take another order."
        )
    poles = np.asarray(np.linalg.eigvals(A), dtype=complex) if len(A) else np.zeros(0, dtype=complex)
    rounding = ROUNDING * float(realization.values.max(initial=0.0))
    error = _error(system, matrices, bound, rounding)
    return ReducedModel(_space(system, matrices), method, realization.hankel, error, bound, poles)


def _space(system: System, matrices: Matrices) -> System:
    import control

    from workbench.design.linear.pointed_systems import PointedSpace, point_of

    states = [f"balanced_{i + 1}" for i in range(len(matrices[0]))]
    names = {"states": states, "inputs": list(system.input_labels), "outputs": list(system.output_labels)}
    name = f"{system.name} of order {len(states)}"
    reduced = control.StateSpace(*matrices, system.dt, name=name, remove_useless_states=False, **names)
    point = point_of(system)
    if point is None:
        return reduced
    layout = Layout(tuple(Entry(state, np.zeros(())) for state in states))
    return PointedSpace(reduced, replace(point, states=layout, x0=np.zeros(len(states))))


def _error(system: System, matrices: Matrices, bound: float, rounding: float) -> CertifiedPeak:
    """The H-infinity norm of the difference of both systems."""
    import control

    (A, B, C, D), n = matrices, system.nstates
    both = np.zeros((n + len(A), n + len(A)))
    both[:n, :n], both[n:, n:] = system.A, A
    matrix_rows = np.vstack([system.B, B]), np.hstack([system.C, -C]), system.D - D
    difference = control.StateSpace(both, *matrix_rows, system.dt, remove_useless_states=False)
    if len(both) <= MOST_STATES:
        with suppress(DesignError):
            return hinf_norm(difference)
    discrete = bool(system.isdtime(strict=True))
    step = 1.0 if system.dt is True else float(system.dt or 0)
    poles = np.linalg.eigvals(system.A)
    rates = np.abs(np.log(poles[poles != 0])) / step if discrete else np.abs(poles)
    grid = np.geomspace(rates.min() / 100, rates.max() * 100, GRID)
    omega = np.unique(np.concatenate([[0.0], grid, np.abs(poles.imag), rates]))
    points = np.exp(1j * step * omega) if discrete else 1j * omega
    gains = np.linalg.norm(np.moveaxis(difference(points, squeeze=False), 2, 0), 2, axis=(1, 2))
    low = float(gains.max()) * (1 - 1e-9)
    high = max(low, bound) * (1 + 1e-9) + rounding
    return CertifiedPeak(CertifiedValue(low, low, high), float(omega[gains.argmax()]))

"""The stability of a step: the eigenvalues along a run, and the longest step that keeps its decaying modes decaying."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np

from workbench.core import Ode, StepMap
from workbench.core.expressions import rows
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments


@dataclass(frozen=True)
@check_arguments
class StepLimit:
    """The longest step that keeps every decaying mode of a run decaying; NaN where no state has a Jacobian."""

    h: float  # s, the step that was taken, or a substep of it
    limit: float  # s
    at: float  # s, when the limit is reached
    eigenvalue: complex  # 1/s, of the mode that sets it
    checked_states: int  # states of the run at which the eigenvalues were taken

    @property
    def holds(self) -> bool:
        """True if the step is within the limit."""
        return self.h <= self.limit


def limit_along(step: StepMap, t: Array, x: Array, p: Array, points: int) -> StepLimit:
    """The limit of a step along a run with times t (N,), states x (N, nx) and parameters p (np,): see `step_limit`."""
    h = step.h / step.substeps
    good = np.flatnonzero(np.isfinite(x).all(axis=1))
    picked = good[np.unique(np.linspace(0, len(good) - 1, min(points, len(good))).astype(int))]
    modes = modes_at(step.flow, t[picked], x[picked], np.repeat(p[np.newaxis], len(picked), axis=0))
    if len(picked) and not modes.shape[1]:  # no rate depends on a state: nothing decays
        return StepLimit(h, np.inf, float(t[picked[0]]), 0j, len(picked))
    finite = np.isfinite(modes).all(axis=1)
    picked, modes = picked[finite], modes[finite]
    if modes.size == 0:
        return StepLimit(h, np.nan, np.nan, complex(np.nan, np.nan), 0)
    limits = longest_steps(modes, step.amplification)
    where = np.unravel_index(np.argmin(limits), limits.shape)
    return StepLimit(h, float(limits[where]), float(t[picked[where[0]]]), complex(modes[where]), len(picked))


def beyond(limit: StepLimit) -> str:
    """The sentence that says that a step is beyond its limit, or could not be checked; empty if it holds."""
    if limit.holds:
        return ""
    if not limit.checked_states:
        return f"the step of {span(limit.h)} is checked at no state: none has a finite Jacobian"
    return f"the step of {span(limit.h)} is beyond its stability limit of {span(limit.limit)} (at {limit.at:.4g} s)"


def span(seconds: float) -> str:
    """A span of time in ms if it is short, else in s."""
    return f"{1000 * seconds:.3g} ms" if seconds < 1 else f"{seconds:.3g} s"


def tightest(limits: Sequence[StepLimit]) -> StepLimit:
    """The limit that is nearest to its step, or farthest below it; one of NaN only where all are."""
    return max(limits, key=lambda limit: np.nan_to_num(limit.h / limit.limit, nan=-1.0))


def modes_at(flow: Ode, t: Array, x: Array, p: Array) -> Array:
    """The eigenvalues of df/dx at n instants t (n,) and states x (n, >= nx) with parameters p (n, np): (n, m).

    A state on which no rate depends is left out, so that m <= nx. A row with a value that is not finite is NaN.
    """
    n, jacobian = len(t), _jacobian(flow)
    m = jacobian.size1_out(0)
    A = rows(jacobian, t[:, np.newaxis], x[:, : flow.states.size], p).reshape(n, m, m).transpose(0, 2, 1)
    acts = np.any(A, axis=(0, 1))
    A = A[:, acts][:, :, acts]
    finite = np.isfinite(A).all(axis=(1, 2))
    modes = np.full(A.shape[:2], np.nan, dtype=complex)
    modes[finite] = np.linalg.eigvals(A[finite])
    modes[~np.isfinite(modes).all(axis=1)] = np.nan  # an eigenvalue of a huge matrix may overflow by itself
    return modes


@lru_cache(maxsize=64)
def _jacobian(flow: Ode) -> ca.Function:
    """df/dx as a function (t, x, p), of those states alone on which some rate depends."""
    A = ca.jacobian(flow.rate, flow.x)
    acts = sorted({column for _, column in zip(*A.sparsity().get_triplet(), strict=True)})
    return ca.Function("workbench_acting", [flow.t, flow.x, flow.p], [ca.densify(A[acts, acts])])


def longest_steps(modes: Array, amplification: tuple[float, ...]) -> Array:
    """For each mode the longest step h with |R(h lambda)| <= 1; infinite where the mode does not decay."""
    size = np.abs(modes)
    decays = (modes.real < 0) & (size > 0)
    angles, reach = _region(amplification)
    radius = np.interp(np.abs(np.where(decays, np.angle(modes), np.pi)), angles, reach)
    with np.errstate(over="ignore"):  # no step is too long for the slowest modes
        return np.where(decays, radius / np.where(decays, size, 1.0), np.inf)


@lru_cache
def _region(amplification: tuple[float, ...]) -> tuple[Array, Array]:
    """The reach of the stability region along rays: the first r > 0 with |R(r e^(i angle))| > 1."""
    stages = len(amplification) - 1
    angles, r = np.linspace(np.pi / 2, np.pi, 361), np.linspace(0, stages**2 + 2, 2001)[1:]
    excess = np.abs(np.polyval(amplification, r * np.exp(1j * angles[:, np.newaxis]))) - 1 - 1e-9
    first = np.maximum(np.argmax(excess > 0, axis=1), 1)
    row = np.arange(len(angles))
    before, after = excess[row, first - 1], excess[row, first]
    crossing = r[first] - (r[1] - r[0]) * np.clip(after / (after - before), 0, 1)
    return angles, np.where(before > 0, 0.0, crossing)

"""The inputs and free states at which an equation rests: a trimmed state."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from workbench.core import Ode
from workbench.design.linear.arguments import inputs_of, jacobians, places_of, row_of, time_of
from workbench.design.matrices import Refused
from workbench.validation.refusals import Array, as_array, described, require
from workbench.validation.signatures import door
from workbench.validation.views import show

# A rate counts as zero below this share of the terms that could have made it: rounding of some thousand operations
# is 1e-13 of them, and a state printed to nine digits leaves 1e-9.
AT_REST = 1e-8
GAUSS_NEWTON_STEPS, HALVINGS = 50, 30
SMALL = 1e-7  # a relative step that is taken whole, as the next one may be nothing but rounding


def rate_terms(A: Array, x: Array) -> Array:
    """A scale for each rate, (nx,): |A| (1 + |x|) + 1, the size of its terms at a state of order one or larger."""
    return np.asarray(np.abs(A) @ (1 + np.abs(x)) + 1)


@dataclass(frozen=True, eq=False)
@show
class OperatingPoint:
    """A state at rest x (nx,), and the inputs u (nu,) that hold it there, also in their places in p (np,).

    Attributes
    ----------
    residual
        The largest rate that remains, as a share of the size of its terms.
    condition
        Of the Jacobian by all that was free: how many times a relative error of the equations may grow.
    error
        The last step of Newton's method, relative to the size of the free numbers: an estimate of their error.
    """

    x: Array
    u: Array
    p: Array
    residual: float
    condition: float
    error: float


@door
def operating_point(
    ode: Ode, wanted: Mapping[str, Any], p: Any = None, t: float = 0.0, u: Any = None
) -> OperatingPoint:
    """The inputs u and the free states at which f(t, x, p, u) = 0, with the other states as given: a trimmed state.

    Gauss-Newton on all rates from the defaults, its step halved while the next one would be longer. Where inputs and
    free states are more than the rates fix, the one nearest to the start in each step is taken.

    Parameters
    ----------
    wanted
        Names of states or inputs, or of single numbers (`q[0]`), with the values that they must have.
    u
        Where the inputs start, (nu,).

    Raises
    ------
    LookupError
        If a name is neither a state's nor an input's.
    ValueError
        If a value is not of its shape, or no input and no state is free.
    Refused
        If no such point is found: the rate that remains is named.
    """
    row, time = row_of(ode, p, u), time_of(t)
    x, fixed = _wanted(ode, wanted, row)
    free = [i for i in range(ode.states.size + inputs_of(ode).size) if i not in fixed]
    driven = places_of(ode)
    if not free:
        raise ValueError(f"`operating_point(...)` must have an input or a free state to find; '{ode.name}' has none.")
    step, slope = _descend(ode, time, x, row, free)
    A = np.array(ode.A(time, x, row))
    rate = ode.rate_at(time, x, row)
    share = np.abs(rate) / (rate_terms(A, x) + np.abs(np.array(ode.B(time, x, row))) @ np.abs(row[driven]))
    worst = int(np.argmax(share))
    if not share[worst] <= AT_REST:
        sought = [(*ode.states.labels, *inputs_of(ode).labels)[i] for i in free]
        raise Refused(
            f"`operating_point(wanted=...)` found no {', '.join(sought)} that hold '{ode.name}' there: "
            f"'{ode.states.labels[worst]}' still changes by {rate[worst]:.3g} a second."
        )
    ode.parameters.check(row[np.newaxis])
    return OperatingPoint(x, row[driven], row, float(share[worst]), float(np.linalg.cond(slope)), step)


def _descend(ode: Ode, t: float, x: Array, p: Array, free: list[int]) -> tuple[float, Array]:
    """Gauss-Newton on the free states and inputs, in place; its last step, relative, and its last Jacobian."""
    driven, n = places_of(ode), len(x)
    step, slope = np.inf, np.zeros((n, 0))
    for _ in range(GAUSS_NEWTON_STEPS):
        A, B, _, _ = jacobians("operating_point", ode, t, x, p)
        slope, at = np.hstack([A, B])[:, free], np.concatenate([x, p[driven]])
        change = _towards_rest(slope, ode.rate_at(t, x, p))
        step = _share(change, at[free])
        if not np.isfinite(step) or np.abs(at[free] + change).max() > 1e12:
            break
        for share in 0.5 ** np.arange(HALVINGS):  # a root of a level, say, ends where the level is negative
            ahead = at.copy()
            ahead[free] += share * change
            x[:], p[driven] = ahead[:n], ahead[n:]
            rate = ode.rate_at(t, x, p)
            # the step that would be left has no units of the rates: a fast state does not hide a slow one
            left = _share(_towards_rest(slope, rate), at[free]) if np.isfinite(rate).all() else np.inf
            if step < SMALL or left < step:
                break
        if step < 1e-14:
            break
    return step, slope


def _share(change: Array, at: Array) -> float:
    return float((np.abs(change) / (1 + np.abs(at))).max())


def _towards_rest(slope: Array, rate: Array) -> Array:
    """The least change that makes the rates zero to first order, each in parts of its own steepest slope."""
    steepest = np.abs(slope).max(axis=1)
    size = np.where(steepest > 0, steepest, 1.0)
    return np.asarray(np.linalg.lstsq(slope / size[:, np.newaxis], -rate / size, rcond=1e-12)[0])


def _wanted(ode: Ode, wanted: Mapping[str, Any], row: Array) -> tuple[Array, set[int]]:
    """The wanted state, with the wanted inputs put into the row, and the places of both."""
    require("operating_point(wanted=...)", wanted, Mapping)
    x, fixed, inputs, driven = ode.states.default.copy(), set(), inputs_of(ode), places_of(ode)
    at = np.concatenate([x, row[driven]])
    for name, value in wanted.items():
        is_input = isinstance(name, str) and name.partition("[")[0] in inputs
        places = [len(x) + place for place in inputs.indices(name)] if is_input else ode.states.indices(name)
        fit = as_array(value)
        if fit is None or fit.size != len(places) or not np.isfinite(fit).all():
            must = f"{len(places)} finite numbers"
            raise ValueError(f"`operating_point(wanted=...)`: '{name}' must be {must}; got {described(value)}.")
        at[places] = fit.ravel(order="F")
        fixed.update(places)
    row[driven] = at[len(x) :]
    return at[: len(x)], fixed

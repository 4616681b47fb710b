"""Rest points of an equation, and their stability, proved by interval or rational arithmetic."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from workbench.core import Ode
from workbench.core.validation.refusals import Array, known_name, vector
from workbench.core.validation.signatures import check_arguments
from workbench.proofs.bounds import extreme_eigenvalue
from workbench.proofs.exact_arithmetic import characteristic_polynomial, exact_values, unstable_modes
from workbench.proofs.interval import NoBound
from workbench.proofs.newton_operator import NewtonOperator

NEWTON_STEPS = 60
RADII = (1e-9, 1e-8, 1e-7, 1e-6)  # half-widths of boxes about a zero, as shares of its size
LOOSE, BOXES = 0.1, 256  # how loose a bound of an eigenvalue may be, as a share of it; and its boxes


@dataclass(frozen=True, eq=False)
class RestPoint:
    """A state x (nx,) at which f(x, p) = 0, to rounding.

    A rest point lies within `radius` of x in each state; None if that was not proved, for the reason `why`. `attracts`
    is True if it is proved that every solution that starts near enough tends to it exponentially. The `modes`
    (nx,) are the eigenvalues of df/dx, as computed, in 1/s.
    """

    x: Array
    radius: float | None
    attracts: bool
    modes: NDArray[np.complex128]
    why: str = ""


@check_arguments
def rest_point(ode: Ode, near: Array) -> RestPoint:
    """The rest point of `ode` at default parameters that Newton's method finds from a guess (nx,).

    It is proved by the interval Newton operator, which carries a small box about it into itself.
    """
    _refuse_time("rest_point", ode)
    near = vector("rest_point(near=...)", near, ode.states.size, "states")
    x = ode.x
    f, p = ca.densify(ode.rate), ode.parameters.default
    slope = ca.densify(ca.jacobian(f, x))
    numbers = dict(zip((ode.p[i].name() for i in range(len(p))), p.tolist(), strict=True))
    rate = ca.Function("rate", [x, ode.p], [f, slope])
    point = _newton(lambda at: rate.call([at, p]), near, ode.name)
    A = np.array(rate(point, p)[1])
    modes = np.linalg.eigvals(A).astype(complex)
    try:
        radius = _radius(f, x, point, numbers)
        attracts = _attracts(slope, x, point, radius, A, numbers)
    except NoBound as none:
        return RestPoint(point, None, False, modes, str(none))
    return RestPoint(point, radius, attracts, modes)


@check_arguments
def growing_modes(ode: Ode, at: Mapping[str, Fraction] | None = None) -> int | None:
    """The number of eigenvalues of df/dx with a positive real part at a rest point with rational numbers: exact.

    None where Routh's array is not regular, as with a mode that neither grows nor decays. `at` gives states and
    parameters by label; all others have their defaults, as the fractions that these doubles are.
    """
    _refuse_time("growing_modes", ode)
    labels = (*ode.states.labels, *ode.parameters.labels)
    defaults = np.concatenate([ode.states.default, ode.parameters.default])
    for label in at or {}:
        known_name(label, labels, f"numbers of '{ode.name}'")
    values = {n: Fraction(float(v)) for n, v in zip(labels, defaults, strict=True)} | dict(at or {})
    if any(value for row in exact_values(ode.rate, values) for value in row):
        raise ValueError(
            f"`growing_modes(at=...)` must be a rest point of '{ode.name}', but its rate is not zero there."
        )
    return unstable_modes(characteristic_polynomial(exact_values(ca.jacobian(ode.rate, ode.x), values)))


def _refuse_time(call: str, ode: Ode) -> None:
    if ca.depends_on(ode.rate, ode.t):
        raise ValueError(f"`{call}(ode=...)` must have a rate that does not depend on time; that of '{ode.name}' does.")


def _newton(rate: Callable[[Array], Iterable[ca.DM]], guess: Array, name: str) -> Array:
    x = guess
    for _ in range(NEWTON_STEPS):
        value, slope = (np.array(part) for part in rate(x))
        try:
            change = np.linalg.solve(slope, value).ravel()
        except np.linalg.LinAlgError:
            must = f"must be near a rest point of '{name}' at which df/dx is regular, as Newton's method divides by it"
            raise ValueError(f"`rest_point(near=...)` {must}; it is singular at {x.tolist()}.") from None
        x = x - change
        if not np.isfinite(x).all():
            break
        if np.abs(change).max() <= 1e-13 * (1 + np.abs(x).max()):
            return np.asarray(x)
    raise ValueError(f"`rest_point(near=...)` found no rest point of '{name}' from there by Newton's method.")


def _radius(f: ca.SX, x: ca.SX, point: Array, numbers: Mapping[str, float]) -> float:
    """The half-width of the smallest box about a point, of those tried, that is proved to hold a zero of f."""
    operator = NewtonOperator.of(f, x, point, numbers)
    for share in RADII:
        radius = share * (1 + float(np.abs(point).max()))
        if operator.has_zero(radius):
            return radius
    raise NoBound(f"No box of {RADII[0]:g} to {RADII[-1]:g} of the point's size is proved to be mapped into itself.")


def _attracts(slope: ca.SX, x: ca.SX, point: Array, radius: float, A: Array, numbers: Mapping[str, float]) -> bool:
    """True if P A(x) + A(x)^T P < 0 is proved in the box of the rest point, with a P that is proved definite."""
    if np.linalg.eigvals(A).real.max() >= 0:
        return False
    n = len(point)
    eye = np.eye(n)
    lyapunov = np.kron(A.T, eye) + np.kron(eye, A.T)
    P = np.linalg.solve(lyapunov, -eye.ravel()).reshape(n, n)
    P = (P + P.T) / 2
    exact = [[Fraction(float(v)) for v in row] for row in P]
    minors = [characteristic_polynomial([row[:k] for row in exact[:k]])[-1] * (-1) ** k for k in range(1, n + 1)]
    form = ca.SX(P) @ slope
    ends = point - radius, point + radius
    greatest = extreme_eigenvalue(form + form.T, x, *ends, -1, tolerance=LOOSE, boxes=BOXES, numbers=numbers)
    return all(minor > 0 for minor in minors) and greatest.bound is not None and greatest.bound < 0

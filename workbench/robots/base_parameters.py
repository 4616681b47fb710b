"""The combinations of an arm's numbers that its motion can tell: the fewest that make the same torques.

References
----------
Gautier (1991), Numerical calculation of the base inertial parameters of robots, J. Robotic Systems 8(4), 485-506.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from workbench.robots.regressor import names, regressor
from workbench.robots.spatial import SpatialArm
from workbench.validation.refusals import Array, Integers
from workbench.validation.signatures import door
from workbench.validation.views import show

ROWS = 4  # of torque for each entry of theta
CLEAR = 1e10  # how many times the last kept singular value must stand above the first dropped one
SMALL = 1e-9  # the part of a column off the span of those before it, below which it lies in it


@dataclass(frozen=True, eq=False)
@show
class BaseParameters:
    """theta_b = K theta, with Y theta = Y_b theta_b where Y_b are the columns `kept` of Y.

    Attributes
    ----------
    names
        (b,): the entry of theta that each base parameter is, but for what is added to it.
    kept
        (b,): the columns of Y.
    K
        (b, k), the identity on the columns kept.
    gap
        The certificate of the rank: the smallest singular value kept over the largest dropped, of Y with unit columns.
    residual
        The largest entry of Y - Y_b K at states that K was not made from, over the largest of Y.
    condition
        Of the stacked Y_b with unit columns.
    """

    names: tuple[str, ...]
    kept: Integers
    K: Array
    gap: float
    residual: float
    condition: float


@door
def base_parameters(arm: SpatialArm, rng: np.random.Generator) -> BaseParameters:
    """The base parameters of an arm, found at random states.

    The first entries of theta are kept, and later ones that act as they do are added to them.

    Raises
    ------
    ValueError
        If the singular values have no clear gap, so that the number of base parameters is in doubt.
    """
    Y, fresh = _stacked(arm, rng), _stacked(arm, rng)
    size = np.linalg.norm(Y, axis=0)
    size[size <= SMALL * size.max()] = np.inf  # an entry that no torque feels
    W = Y / size
    kept = _independent(W)
    values = np.linalg.svd(W, compute_uv=False)
    dropped = max(float(values[len(kept)]) if len(kept) < len(values) else 0.0, np.finfo(float).eps * float(values[0]))
    gap = float(values[len(kept) - 1]) / dropped
    if not gap > CLEAR:
        raise ValueError(
            f"`base_parameters(...)`: singular values must fall by more than {CLEAR:g} where the rank ends, and here "
            f"fall by {gap:.3g} after {len(kept)}: the arm is too close to one of a special shape to count them."
        )
    in_units = np.linalg.lstsq(W[:, kept], W, rcond=None)[0]
    in_units[np.abs(in_units) < SMALL] = 0.0
    felt = np.where(np.isinf(size), 0.0, size)
    K = in_units * felt / size[kept][:, np.newaxis]
    residual = float(np.abs(fresh - fresh[:, kept] @ K).max() / np.abs(fresh).max())
    own = names(arm)
    return BaseParameters(tuple(own[i] for i in kept), kept, K, gap, residual, float(np.linalg.cond(W[:, kept])))


def _stacked(arm: SpatialArm, rng: np.random.Generator) -> Array:
    """Y at random states, one above the other, (N, k)."""
    q, qd, qdd = (ca.SX.sym(letter, arm.dof) for letter in ("q", "qd", "qdd"))
    Y = ca.Function("Y", [q, qd, qdd], [regressor(arm, q, qd, qdd)])
    states = 1 + ROWS * len(names(arm)) // arm.dof
    return np.vstack([np.array(Y(*rng.uniform(-np.pi, np.pi, (3, arm.dof)))) for _ in range(states)])


def _independent(W: Array) -> Integers:
    """The columns that lie off the span of those before them, by Gram and Schmidt, each column twice."""
    span = np.zeros((len(W), 0))
    kept: list[int] = []
    for j, column in enumerate(W.T):
        rest = column - span @ (span.T @ column)
        rest -= span @ (span.T @ rest)
        length = float(np.linalg.norm(rest))
        if length > SMALL:
            span, kept = np.column_stack([span, rest / length]), [*kept, j]
    return np.array(kept)

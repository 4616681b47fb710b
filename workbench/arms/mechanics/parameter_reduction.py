"""Base parameters of an arm: the smallest set of combinations of its numbers that gives the same torques."""

from dataclasses import dataclass

import numpy as np

from workbench.arms.mechanics.inertial_regressor import Regressor, regressor
from workbench.arms.mechanics.planar_arm import PlanarArm
from workbench.arms.mechanics.spatial import SpatialArm
from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array, Integers
from workbench.core.validation.refusals import seed as check_seed
from workbench.core.validation.signatures import check_arguments

ROWS = 4  # of torque for each entry of theta
ROOM = np.pi  # of positions, speeds and accelerations of the drawn states, in rad or m
CLEAR = 1e10  # the least share of the last kept singular value and the first dropped one
EXACT = 1e-12  # the most that the torque may differ, as a share of the largest entry of Y: some thousand roundings
SMALL = 1e-9  # the part of a column off the span of those before it, below which it lies in it


@dataclass(frozen=True, eq=False)
@show
@check_arguments
class BaseParameters:
    """The b base parameters of an arm: theta_b = K theta with Y theta = Y_b theta_b.

    Y is the regressor of all k inertial parameters theta. Y_b has the columns `kept_columns` of Y.

    Attributes
    ----------
    names, units
        (b,). Name and unit of the entry of theta that each base parameter contains with the factor 1.
    combinations
        (b,). Each base parameter as a sum, as `link1.I_zz + 0.49 link2.m`.
    theta
        (b,). The values of theta_b for this arm.
    kept_columns
        (b,). The indices of the columns of Y that are in Y_b.
    K
        (b, k). The matrix of theta_b = K theta. It is the identity on the kept columns.
    gap
        The smallest kept singular value over the largest dropped one, for Y with unit columns at random states. A large
        gap confirms the number b. It is infinite if none is dropped.
    residual
        The largest entry of Y - Y_b K over the largest entry of Y, at other random states than those that gave K.
    condition
        The condition number of Y_b with unit columns, at the random states.
    regressor
        The regressor Y.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    combinations: tuple[str, ...]
    theta: Array
    kept_columns: Integers
    K: Array
    gap: float
    residual: float
    condition: float
    regressor: Regressor

    @check_arguments
    def at(self, q: object, qd: object, qdd: object) -> Array:
        """Y_b at one state, (n, b), for q, qd and qdd of shape (n,); stacked for N states, (N n, b), for (N, n)."""
        return np.asarray(self.regressor.at(q, qd, qdd)[:, self.kept_columns])


@check_arguments
def base_parameters(arm: PlanarArm | SpatialArm, seed: int = 0) -> BaseParameters:
    """The base parameters of an arm: the fewest combinations of inertial parameters that determine its torques.

    They are computed numerically at random states. The first independent entries of theta are kept. Later entries,
    which depend on them, are added to them. The answer is a `wb.arms.mechanics.BaseParameters`.

    Parameters
    ----------
    arm
        A planar or spatial arm, as of `wb.robot` or `wb.read_urdf`.
    seed
        The seed of the random states.

    Raises
    ------
    ValueError
        If the singular values have no clear gap, or the torques differ, so that the number of base parameters is in
        doubt.

    References
    ----------
    Gautier (1991), Numerical calculation of the base inertial parameters of robots, J. Robotic Systems 8(4), 485-506.

    Examples
    --------
    >>> base = wb.base_parameters(wb.robot("planar-2r"))
    >>> len(base.theta), len(base.regressor.theta)
    (6, 8)
    >>> print(base.combinations[0])
    link1.mc_x + link2.m
    """
    return reduce_regressor(regressor(arm), check_seed("base_parameters(seed=...)", seed))


def reduce_regressor(Y: Regressor, seed: int) -> BaseParameters:
    """The base parameters of a regressor, which may have columns beside those of the arm's bodies."""
    rng = np.random.default_rng(seed)
    W, fresh = _random_rows(Y, rng), _random_rows(Y, rng)
    size = np.linalg.norm(W, axis=0)
    felt = size > SMALL * size.max()  # an entry that no torque feels has a column of zeros
    unit = np.where(felt, size, np.inf)
    W = W / unit
    kept = _independent(W)
    values = np.linalg.svd(W, compute_uv=False)
    rounding = np.finfo(float).eps * float(values[0])
    dropped = float(values[len(kept)]) if len(kept) < len(values) else 0.0
    gap = float(values[len(kept) - 1]) / max(dropped, rounding) if len(kept) < len(values) else np.inf
    parts = np.linalg.lstsq(W[:, kept], W, rcond=None)[0]
    parts[np.abs(parts) < SMALL] = 0.0
    K = parts * np.where(felt, size, 0.0) / unit[kept][:, np.newaxis]
    K[:, kept] = np.eye(len(kept))
    residual = float(np.abs(fresh - fresh[:, kept] @ K).max() / np.abs(fresh).max())
    if not gap > CLEAR or not residual < EXACT:
        raise ValueError(
            f"`base_parameters(...)` must find where the rank of Y ends: singular values fall there by more than "
            f"{CLEAR:g}, and what is left out makes less than {EXACT:g} of the torque; after {len(kept)} they fall by "
            f"{gap:.3g}, and {residual:.2g} is left: the arm is too near to one of a special shape. Give that exactly."
        )
    names, units = (tuple(np.array(each)[kept].tolist()) for each in (Y.names, Y.units))
    combined = tuple(_sum(Y.names, row, i) for i, row in zip(kept, K, strict=True))
    condition = float(np.linalg.cond(W[:, kept]))
    return BaseParameters(names, units, combined, K @ Y.theta, kept, K, gap, residual, condition, Y)


def _random_rows(Y: Regressor, rng: np.random.Generator) -> Array:
    """Y at random states below one another, (N, k)."""
    states = 1 + ROWS * len(Y.names) // Y.dof
    return Y.at(*rng.uniform(-ROOM, ROOM, (3, states, Y.dof)))


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


def _sum(names: tuple[str, ...], factors: Array, first: int) -> str:
    """A combination in words, with the entry that has the factor 1 at its head."""
    text = names[first]
    for i, (name, factor) in enumerate(zip(names, factors, strict=True)):
        if i != first and factor:
            size = f"{abs(factor):.6g}"
            text += f" {'-' if factor < 0 else '+'} {'' if size == '1' else f'{size} '}{name}"
    return text

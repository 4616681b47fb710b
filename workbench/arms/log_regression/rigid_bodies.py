"""Physical consistency: whether rigid bodies have a set of base parameters, by pseudo-inertia matrices.

References
----------
Wensing, Kim and Slotine (2018), Linear matrix inequalities for physically consistent inertial parameter identification,
IEEE Robotics and Automation Letters 3(1), 60-67, section III. Sousa and Cortesao (2014), Physical feasibility of robot
base inertial parameter identification, Int. J. Robotics Research 33(6), 931-944.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from workbench.arms.mechanics.inertial_regressor import FIRST, MOMENTS
from workbench.arms.mechanics.parameter_reduction import BaseParameters
from workbench.arms.observer_gains.matrix_inequalities import solvers
from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array, vector
from workbench.core.validation.signatures import check_arguments
from workbench.design.matrices import DesignError

if TYPE_CHECKING:
    from collections.abc import Mapping

POSITIVE = ("drive", "viscous", "coulomb")  # no drive or friction has such a number below zero
MARGIN = 1e-7  # of the size of the numbers: the room that the solver's rounding may take
PULL = 1e-9  # toward zero, of the numbers that the torques do not feel
BASIS = {  # of a body in space: the entry of its pseudo-inertia matrix by each number
    "m": [(3, 3, 1.0)],
    "mc_x": [(0, 3, 1.0)],
    "mc_y": [(1, 3, 1.0)],
    "mc_z": [(2, 3, 1.0)],
    "I_xx": [(0, 0, -0.5), (1, 1, 0.5), (2, 2, 0.5)],
    "I_yy": [(0, 0, 0.5), (1, 1, -0.5), (2, 2, 0.5)],
    "I_zz": [(0, 0, 0.5), (1, 1, 0.5), (2, 2, -0.5)],
    "I_xy": [(0, 1, -1.0)],
    "I_xz": [(0, 2, -1.0)],
    "I_yz": [(1, 2, -1.0)],
}
FLAT = {  # of a body that is seen in its plane
    "I_zz": [(0, 0, 1.0)],
    "mc_x": [(0, 1, 1.0)],
    "mc_y": [(0, 2, 1.0)],
    "m": [(1, 1, 1.0), (2, 2, 1.0)],
}


@dataclass(frozen=True, eq=False)
@show
class RigidBodies:
    """Rigid bodies whose base parameters are the nearest to an estimate, and how near they are.

    Attributes
    ----------
    theta
        (k,). Numbers of bodies, drives and frictions. Those that the torques do not feel are one choice of many.
    base
        (b,). Their base parameters.
    least_eigenvalues
        The least eigenvalue of the pseudo-inertia matrix of each link, computed from `theta` without the solver.
    least_number
        The least of the drives' inertias and the frictions, which must not be negative; infinite if there is none.
    distance
        The distance from the estimate in standard errors: the root of d' P^-1 d. An error is at least that of a number
        whose torque is a thousandth of all.
    """

    theta: Array
    base: Array
    least_eigenvalues: Mapping[str, float]
    least_number: float
    distance: float

    @property
    def is_checked(self) -> bool:
        """True if all eigenvalues and numbers are at least zero."""
        return min(*self.least_eigenvalues.values(), self.least_number) >= 0


def _bases(names: tuple[str, ...]) -> dict[str, dict[int, Array]]:
    """For each link the matrix by which each entry of theta enters its pseudo-inertia matrix."""
    result: dict[str, dict[int, Array]] = {}
    for link in dict.fromkeys(name.rpartition(".")[0] for name in names):
        words = {name.rpartition(".")[2]: i for i, name in enumerate(names) if name.rpartition(".")[0] == link}
        if "m" not in words:
            continue
        table, size = (BASIS, 4) if set(MOMENTS + FIRST) <= set(words) else (FLAT, 3)
        entries = {}
        for word, places in table.items():
            part = np.zeros((size, size))
            for i, j, value in places:
                part[i, j] = part[j, i] = value
            entries[words[word]] = part
        result[link] = entries
    return result


@check_arguments
def pseudo_inertias(names: tuple[str, ...], theta: Array) -> dict[str, Array]:
    """The pseudo-inertia matrix of each link, which is positive definite for a body of positive density.

    In space it is [[tr(I)/2 E - I, m c], [(m c)', m]], (4, 4), with I about the origin of the link's frame. Of a link
    that is seen in its plane it is [[I_zz, m c'], [m c, m E]], (3, 3). `names` and `theta` (k,) are as `Regressor` has
    them.

    Examples
    --------
    >>> Y = wb.regressor(wb.robot("planar-2r"))
    >>> matrices = wb.arms.log_regression.pseudo_inertias(Y.names, Y.theta)
    >>> [bool(np.linalg.eigvalsh(matrix)[0] > 0) for matrix in matrices.values()]
    [True, True]
    """
    theta = vector("pseudo_inertias(names, theta)", theta, len(names), "names")
    return {
        link: np.sum([theta[i] * part for i, part in entries.items()], axis=0)
        for link, entries in _bases(names).items()
    }


def nearest_rigid_bodies(base: BaseParameters, estimate: Array, covariance: Array) -> RigidBodies:
    """The rigid bodies whose base parameters are the nearest to an estimate (b,) with a covariance (b, b).

    Raises
    ------
    DesignError
        If CVXPY or Clarabel is not here, or the answer fails the check of its eigenvalues.
    """
    cp, names = solvers("fit_inverse_dynamics"), base.regressor.names
    errors = np.sqrt(np.diag(covariance))
    size = np.maximum(np.abs(estimate), errors)
    felt = [float(np.max(np.abs(column) / size)) for column in base.K.T]
    lengths = np.array([1.0 / part if part else 1.0 for part in felt])
    white = np.linalg.inv(np.linalg.cholesky(covariance / np.outer(errors, errors))) / errors
    x = cp.Variable(len(names))
    theta, gap = cp.multiply(lengths, x), white @ (base.K @ np.diag(lengths))
    constraints = [x[i] >= MARGIN for i, name in enumerate(names) if name.rpartition(".")[2] in POSITIVE]
    for entries in _bases(names).values():
        scales = _scales(entries, lengths)
        matrix = sum(theta[i] * (part / np.outer(scales, scales)) for i, part in entries.items())
        constraints.append(matrix >> MARGIN * np.eye(len(scales)))
    weight = np.linalg.norm(gap, 2)
    cost = cp.sum_squares((gap @ x - white @ estimate) / weight) + PULL * cp.sum_squares(x)
    problem = cp.Problem(cp.Minimize(cost), constraints)
    with warnings.catch_warnings():  # an inaccurate answer is checked below like any other
        warnings.simplefilter("ignore")
        problem.solve(solver=cp.CLARABEL)
    if x.value is None:
        raise DesignError(f"`fit_inverse_dynamics(...)` found no rigid bodies: the problem is {problem.status}.")
    return _checked(base, np.asarray(x.value * lengths, dtype=float), estimate, white)


def _scales(entries: Mapping[int, Array], lengths: Array) -> Array:
    """The root of the size of each diagonal entry of a pseudo-inertia matrix."""
    total = np.sum([lengths[i] * np.abs(part) for i, part in entries.items()], axis=0)
    return np.sqrt(np.diag(total))


def _checked(base: BaseParameters, theta: Array, estimate: Array, white: Array) -> RigidBodies:
    names = base.regressor.names
    least = {link: float(np.linalg.eigvalsh(one)[0]) for link, one in pseudo_inertias(names, theta).items()}
    beside = [theta[i] for i, name in enumerate(names) if name.rpartition(".")[2] in POSITIVE]
    nearest = base.K @ theta
    distance = float(np.linalg.norm(white @ (nearest - estimate)))
    bodies = RigidBodies(theta, nearest, least, float(min(beside, default=np.inf)), distance)
    if not bodies.is_checked:
        raise DesignError(
            f"`fit_inverse_dynamics(...)` found no rigid bodies: the solver's answer has the least eigenvalues {least} "
            f"and the least number {bodies.least_number:.3g}, of which none may be negative."
        )
    return bodies

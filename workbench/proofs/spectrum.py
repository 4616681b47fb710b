"""The eigenvalues of M over positions q, at nominal parameters."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from workbench.core import Dynamics
from workbench.validation.refusals import Array, matrix
from workbench.validation.signatures import door

Joints = np.ndarray[Any, np.dtype[np.intp]]


def nominal(dynamics: Dynamics) -> dict[str, float]:
    """The nominal value of each parameter, by the name of its symbol.

    Proofs take the values so, and not folded into the matrices, where their sums and products would be rounded.
    """
    names = [dynamics.symbols[i].name() for i in range(dynamics.p.size)]
    return dict(zip(names, dynamics.p.default.tolist(), strict=True))


@door
def eigenvalues(dynamics: Dynamics, q: Array) -> Array:
    """The eigenvalues (N, n), ascending, in kg m^2, of the symmetric part of M at positions q (N, n).

    Raises
    ------
    ValueError
        If M is not finite at one of them.
    """
    n = dynamics.dof
    q = matrix("eigenvalues(q=...)", q, columns=n)
    mass = ca.Function("mass", [dynamics.q, dynamics.symbols], [ca.vec(ca.densify(dynamics.M))])
    M = np.array(mass(q.T, dynamics.p.default)).T.reshape(-1, n, n)
    if not (finite := np.isfinite(M).all(axis=(1, 2))).all():
        where = q[np.flatnonzero(~finite)[0]].tolist()
        raise ValueError(f"`eigenvalues(q)` needs a mass matrix of finite numbers; it is not so at q = {where}.")
    return np.asarray(np.linalg.eigvalsh((M + M.transpose(0, 2, 1)) / 2))


def free_joints(dynamics: Dynamics) -> Joints:
    """The joints (from 0) that M depends on."""
    pattern = np.array(ca.DM(ca.jacobian(ca.vec(dynamics.M), dynamics.q).sparsity(), 1))
    return np.flatnonzero(pattern.any(axis=0))


def of_joints(unit: str, dynamics: Dynamics) -> str:
    """The unit of a norm over all joints, which is told for hinges; none where some joints turn and others slide."""
    if len(set(dynamics.units)) > 1:
        return "in mixed units"
    slides = dynamics.units[0] == "m"
    return unit.replace("N m", "N").replace("kg m^2", "kg").replace("rad", "m") if slides else unit

"""The eigenvalues of M over positions q: sampled, extreme, and bounded between the samples."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from workbench.core import Dynamics
from workbench.core.layout import Array
from workbench.notation.normal_form import NormalForm, NotInClass, normal_forms

Joints = np.ndarray[Any, np.dtype[np.intp]]

# Grid points in all, and how often the grid is halved round its best point: 2^-40 of a cell is 1e-13 rad.
GRID, HALVINGS = 20_000, 40
# What an eigenvalue of a matrix of doubles can be wrong by, as a share of the largest: a few dozen roundings.
ROUNDING = 1e-14


@dataclass(frozen=True, eq=False)
class Extreme:
    """The least or greatest eigenvalue that was seen, at `q`, after so many samples.

    `on_grid` is the best of the grid alone, and `beyond` a value that no eigenvalue in the whole box
    lies beyond: None where no bound on the slope of M is known.
    """

    value: float
    q: Array
    samples: int
    on_grid: float
    beyond: float | None


def eigenvalues(dynamics: Dynamics, q: Array) -> Array:
    """The eigenvalues (N, n), ascending, in kg m^2, of the symmetric part of M at positions q (N, n), p nominal.

    Raises
    ------
    ValueError
        If M is not finite at one of them.
    """
    n = dynamics.dof
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


def extreme(dynamics: Dynamics, low: Array, high: Array, sign: int) -> Extreme:
    """The least (sign 1) or greatest (sign -1) eigenvalue over the box low <= q <= high, each (n,)."""
    free = free_joints(dynamics)
    middle, half = (low + high) / 2, (high - low) / 2
    # the middle and the quarters of the box are among the points of the grid
    points = max(int(GRID ** (1 / len(free))) // 4, 1) * 4 + 1 if len(free) else 1
    best, value, first, samples = middle, np.inf, np.inf, 0
    for level in range(HALVINGS + 1 if len(free) else 1):
        grid = np.linspace(-1, 1, points) if level == 0 else np.linspace(-2, 2, 5) / (points - 1) / 2.0 ** (level - 1)
        steps = np.stack(np.meshgrid(*[grid] * len(free), indexing="ij"), axis=-1) if len(free) else np.zeros((1, 0))
        q = np.tile(best, (steps.size // max(len(free), 1) or 1, 1))
        q[:, free] = np.clip(best[free] + steps.reshape(len(q), -1) * half[free], low[free], high[free])
        values = (sign * eigenvalues(dynamics, q)).min(axis=1)
        samples += len(q)
        if values.min() < value:
            value, best = float(values.min()), q[values.argmin()]
        first = value if level == 0 else first
    reach = np.zeros(dynamics.dof)
    reach[free] = half[free] / max(points - 1, 1)  # no point of the box is farther from the grid
    change = most_change(dynamics, reach)
    size = ROUNDING * float(np.abs(eigenvalues(dynamics, best[None])).max())
    beyond = None if change is None else sign * (first - change) - sign * size
    return Extreme(sign * value, best, samples, sign * first, beyond)


def most_change(dynamics: Dynamics, reach: Array) -> float | None:
    """How much an eigenvalue of M can change when no joint moves more than `reach` (n,) rad; None if unknown.

    Each entry of M is a sum of sines and cosines, whose slopes are bounded by their coefficients; by
    Weyl's inequality no eigenvalue changes by more than the 2-norm of the matrix of those bounds.
    """
    values = dict(zip(_names(dynamics.symbols), dynamics.p.default, strict=True))
    joints = dict(zip(_names(dynamics.q), reach, strict=True))
    try:
        symmetric = (dynamics.M + dynamics.M.T) / 2
        changes = [[_change(form, values, joints) for form in row] for row in normal_forms(ca.densify(symmetric))]
    except (NotInClass, KeyError):  # no trigonometric polynomial in q: no such bound
        return None
    return float(np.linalg.norm(np.array(changes), 2))


def _change(form: NormalForm, values: dict[str, float], joints: dict[str, float]) -> float:
    """The sum of |coefficient| |slope of the angle|; KeyError where q or qd stands outside a sine or cosine."""
    total = 0.0
    for (monomial, (_, angle)), coefficient in form.terms.items():
        size = abs(float(coefficient)) * math.prod(abs(values[name]) ** power for name, power in monomial)
        for factor, slope in angle:
            if not factor:
                continue  # a constant phase
            if len(factor) != 1 or factor[0][1] != 1:
                raise KeyError(factor)
            total += size * abs(float(slope)) * joints[factor[0][0]]
    return total


def _names(symbols: ca.SX) -> list[str]:
    return [symbols[i].name() for i in range(symbols.numel())]

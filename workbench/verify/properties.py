"""The structure that proofs of robot control lean on: M symmetric, M' - 2C skew, M positive definite."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from workbench.core import Dynamics
from workbench.core.layout import Array
from workbench.verify.identity import Kind, judge_zero
from workbench.verify.spectrum import Joints, eigenvalues, extreme, free_joints
from workbench.verify.witness import Witness


@dataclass(frozen=True, eq=False)
class PropertyVerdict:
    """How it stands with a property of an arm's matrices.

    `residual` is the matrix (n, n) that ought to be zero, at the witness; both are None unless the
    property is refuted.
    """

    statement: str
    kind: Kind
    evidence: str
    witness: Witness | None = None
    residual: Array | None = None


@dataclass(frozen=True, eq=False)
class DefinitenessVerdict:
    """How it stands with alpha1 I <= M(q) <= alpha2 I, alpha1 > 0.

    `alpha1` and `alpha2` are the least and greatest eigenvalue of M that were seen, in kg m^2, at
    `q_least` and `q_greatest` (n,); `samples` mass matrices were looked at, at nominal parameters.
    `refined` is how much the refinement moved the two beyond the best of the grid, `beyond` what no
    eigenvalue in the box lies below and above (None where no bound on the slope of M is known): with the
    first of these positive the property is proved.
    """

    statement: str
    kind: Kind
    evidence: str
    alpha1: float
    alpha2: float
    q_least: Array
    q_greatest: Array
    samples: int
    refined: tuple[float, float]
    beyond: tuple[float | None, float | None]
    witness: Witness | None = None


def symmetric(dynamics: Dynamics) -> PropertyVerdict:
    """M(q) = M(q)^T, for all q and all parameters."""
    M = dynamics.M
    return _vanishes("M is symmetric", M - M.T, M, dynamics)


def skew(dynamics: Dynamics) -> PropertyVerdict:
    """N = M' - 2C is skew-symmetric, N + N^T = 0, for all q, qd and all parameters.

    It is a property of the factorisation C qd as well as of the arm: of all matrices C that give the
    same torque, that of the Christoffel symbols has it.
    """
    rate = dynamics.mass_matrix_rate
    N = rate - 2 * dynamics.C
    terms = ca.vertcat(ca.vec(rate), ca.vec(2 * dynamics.C))
    return _vanishes("M' - 2C is skew-symmetric", N + N.T, terms, dynamics)


def _vanishes(statement: str, residual: ca.SX, terms: ca.SX, dynamics: Dynamics) -> PropertyVerdict:
    judgement = judge_zero(residual, terms, dynamics)
    found = judgement.search
    if found is None or found.witness is None:
        return PropertyVerdict(statement, judgement.kind, judgement.evidence)
    matrix = found.values.reshape(dynamics.dof, dynamics.dof, order="F") + 0.0  # no negative zeros
    return PropertyVerdict(statement, judgement.kind, judgement.evidence, found.witness, matrix)


def positive_definite(
    dynamics: Dynamics, low: float | Array = -np.pi, high: float | Array = np.pi
) -> DefinitenessVerdict:
    """M(q) is positive definite at nominal parameters, for low <= q <= high (rad, a number or (n,)).

    The extreme eigenvalues of the symmetric part of M are sought on a grid over the joints that M
    depends on, which is then halved round its best point again and again. What is seen is a fact; that
    nothing was missed between the points is proved only where the slope of M is known to be too small.

    Raises
    ------
    ValueError
        If the box is not one of finite numbers, or M is not finite somewhere in it.
    """
    first, last = (np.broadcast_to(np.asarray(side, dtype=float), dynamics.dof) for side in (low, high))
    if not (np.isfinite([first, last]).all() and (first < last).all()):
        raise ValueError(f"`positive_definite(low=..., high=...)` needs finite low < high; got {low} and {high}.")
    least, greatest = (extreme(dynamics, first, last, sign) for sign in (1, -1))
    samples = least.samples + greatest.samples
    kind: Kind = "refuted" if least.value <= 0 else "not refuted"
    evidence = f"smallest eigenvalue {least.value:.6g} kg m^2 at q = {(np.round(least.q, 6) + 0.0).tolist()}"
    evidence += _where(free_joints(dynamics), first, last)
    if least.value > 0 and least.beyond is not None and least.beyond > 0:
        kind = "proved"
        evidence += f", and none below {least.beyond:.6g} between the points of the grid, by the slope of M"
    elif least.value > 0:
        evidence = f"not refuted in {samples} samples: {evidence}"
    return DefinitenessVerdict(
        "M is positive definite at nominal parameters",
        kind,
        evidence,
        least.value,
        greatest.value,
        least.q,
        greatest.q,
        samples,
        (abs(least.value - least.on_grid), abs(greatest.value - greatest.on_grid)),
        (least.beyond, greatest.beyond),
        Witness(least.q, np.zeros(dynamics.dof), dynamics.p.default) if kind == "refuted" else None,
    )


def _where(free: Joints, low: Array, high: Array) -> str:
    box = " x ".join(f"q{i + 1} in [{low[i]:.4g}, {high[i]:.4g}]" for i in free)
    return f" over {box}" if box else " (M depends on no joint)"


def eigenvalues_along(dynamics: Dynamics, joint: int, angles: Array) -> Array:
    """The eigenvalues of M, ascending, (N, n), over angles (N,) of joint number `joint` (from 1), others at 0.

    Raises
    ------
    LookupError
        If there is no such joint.
    """
    if not 1 <= joint <= dynamics.dof:
        raise LookupError(f"`eigenvalues_along(joint=...)` counts joints from 1 to {dynamics.dof}; got {joint}.")
    q = np.zeros((len(angles), dynamics.dof))
    q[:, joint - 1] = angles
    return eigenvalues(dynamics, q)

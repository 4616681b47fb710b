"""The structure that proofs of robot control lean on: M symmetric, M' - 2C skew, M positive definite."""

from __future__ import annotations

from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from workbench.core import Dynamics
from workbench.proofs.bounds import TOLERANCE, box_of, by_intervals, extreme_eigenvalue, shown
from workbench.proofs.identity import Kind, judge_zero, zero_at
from workbench.proofs.spectrum import Joints, eigenvalues, free_joints, nominal, of_joints
from workbench.proofs.witness import Witness
from workbench.validation.refusals import Array, numbers
from workbench.validation.signatures import door

RANK: dict[Kind, int] = {"proved": 0, "not refuted": 1, "refuted": 2}


@dataclass(frozen=True, eq=False)
class PropertyVerdict:
    """How it stands with a property of an arm's matrices.

    `residual` is what ought to be zero, (n, n) or (1, 1), at the witness; both are None unless the
    property is refuted.
    """

    statement: str
    kind: Kind
    evidence: str
    witness: Witness | None = None
    residual: Array | None = None


@dataclass(frozen=True, eq=False)
class DefinitenessVerdict:
    """How it stands with alpha1 I <= M(q) <= alpha2 I, alpha1 > 0, at nominal parameters.

    Attributes
    ----------
    alpha1, alpha2
        The least and greatest eigenvalue of M that were seen, in kg m^2 of an arm whose joints all turn.
    q_least, q_greatest
        Where, (n,) in rad or m.
    samples, boxes
        The mass matrices that were looked at, and the boxes of positions.
    beyond
        What is proved: no eigenvalue in the box lies below the first or above the second; None where
        nothing was. With the first of these positive the property is proved.
    digits
        How many decimal digits of alpha1 and alpha2 are proved right.
    """

    statement: str
    kind: Kind
    evidence: str
    alpha1: float
    alpha2: float
    q_least: Array
    q_greatest: Array
    samples: int
    boxes: int
    beyond: tuple[float | None, float | None]
    digits: tuple[int, int]
    witness: Witness | None = None

    @property
    def replay(self) -> str:
        """The line of Python that gives the eigenvalues of M where the least was seen."""
        seen = Witness(self.q_least, np.zeros_like(self.q_least), np.zeros(0))
        return f"{seen.replay}; numpy.linalg.eigvalsh(M)"


@door
def symmetric(dynamics: Dynamics) -> PropertyVerdict:
    """M(q) = M(q)^T, for all q and all parameters."""
    M = dynamics.M
    return _vanishes("M is symmetric", M - M.T, M, dynamics)


@door
def skew(dynamics: Dynamics) -> PropertyVerdict:
    """N = M' - 2C is skew-symmetric, N + N^T = 0, for all q, qd and all parameters.

    It is a property of the factorisation C qd as well as of the arm: of all matrices C that give the
    same torque, that of the Christoffel symbols has it.
    """
    rate = dynamics.mass_matrix_rate
    N = rate - 2 * dynamics.C
    terms = ca.vertcat(ca.vec(rate), ca.vec(2 * dynamics.C))
    return _vanishes("M' - 2C is skew-symmetric", N + N.T, terms, dynamics)


@door
def passive(dynamics: Dynamics) -> PropertyVerdict:
    """T' + U' = qd^T tau: no power but that of the torque, for all q, qd and all parameters.

    It says two things: qd^T (M' - 2C) qd = 0, which is weaker than skewness as it is true of every right
    factorisation of C qd; and that G is the gradient of some U(q), dG/dq = (dG/dq)^T. With M positive
    definite and U bounded from below, the arm is then passive from tau to qd.

    References
    ----------
    Ortega and Spong (1989), Adaptive motion control of rigid robots: a tutorial, Automatica 25, section 2.
    """
    rate, qd, slope = dynamics.mass_matrix_rate, dynamics.qd, ca.jacobian(dynamics.G, dynamics.q)
    power = qd.T @ (rate - 2 * dynamics.C) @ qd
    spent = ca.vertcat(qd.T @ rate @ qd, qd.T @ dynamics.C @ qd)
    statement = "T' + U' = qd^T tau: the energy balance"
    balance = _vanishes(statement, power, spent, dynamics)
    gradient = _vanishes(statement, slope - slope.T, slope, dynamics)
    if balance.kind == "proved" and gradient.kind == "proved":
        return PropertyVerdict(statement, "proved", f"power of M' - 2C and curl of G: {balance.evidence}")
    worse, of = (balance, "power of M' - 2C") if RANK[balance.kind] >= RANK[gradient.kind] else (gradient, "curl of G")
    return replace(worse, evidence=f"{of}: {worse.evidence}")


def _vanishes(statement: str, residual: ca.SX, terms: ca.SX, dynamics: Dynamics) -> PropertyVerdict:
    judgement = judge_zero(residual, terms, dynamics)
    found = judgement.search
    if found is None:
        return PropertyVerdict(statement, judgement.kind, judgement.evidence)
    if found.witness is None:
        if not zero_at(residual, nominal(dynamics)):
            return PropertyVerdict(statement, judgement.kind, judgement.evidence)
        evidence = "equal normal forms at nominal parameters: an identity in all states"
        return PropertyVerdict(f"{statement}, at nominal parameters", "proved", evidence)
    matrix = found.values.reshape(residual.shape, order="F") + 0.0  # no negative zeros
    return PropertyVerdict(statement, judgement.kind, judgement.evidence, found.witness, matrix)


@door
def positive_definite(
    dynamics: Dynamics,
    low: float | Array = -np.pi,
    high: float | Array = np.pi,
    *,
    tolerance: float = TOLERANCE,
    boxes: int | None = None,
) -> DefinitenessVerdict:
    """M(q) is positive definite at nominal parameters, for low <= q <= high (rad, a number or (n,)).

    The extreme eigenvalues of the symmetric part of M are sought by samples and proved by branch and
    bound, each within `tolerance` of itself, with a budget of `boxes` for each (by itself, so many as
    take some ten seconds).

    Raises
    ------
    ValueError
        If the box is not one of finite numbers, or M has no finite value or bound somewhere in it.
    """
    first, last = box_of("positive_definite", low, high, dynamics.dof)
    least, greatest = (
        extreme_eigenvalue(
            dynamics.M, dynamics.q, first, last, s, tolerance=tolerance, boxes=boxes, numbers=nominal(dynamics)
        )
        for s in (1, -1)
    )
    samples = least.samples + greatest.samples
    kind: Kind = "refuted" if least.reached <= 0 else "not refuted"
    place, unit = (np.round(least.x, 6) + 0.0).tolist(), of_joints("kg m^2", dynamics)
    evidence = f"smallest eigenvalue {least.value:.9g} {unit} at q = {place}"
    evidence += _where(free_joints(dynamics), first, last)
    if least.beyond is not None and least.beyond > 0:
        kind = "proved"
        evidence += f", and none below {shown(least.beyond, 1)}{by_intervals(least.boxes)}"
    elif kind == "not refuted":
        evidence = f"not refuted in {samples} samples: {evidence}; not proved: {least.why or 'it is zero to rounding'}"
    return DefinitenessVerdict(
        "M is positive definite at nominal parameters",
        kind,
        evidence,
        least.value,
        greatest.value,
        least.x,
        greatest.x,
        samples,
        least.boxes + greatest.boxes,
        (least.beyond, greatest.beyond),
        (least.digits, greatest.digits),
        Witness(least.x, np.zeros(dynamics.dof), dynamics.p.default) if kind == "refuted" else None,
    )


def _where(free: Joints, low: Array, high: Array) -> str:
    box = " x ".join(f"q{i + 1} in [{low[i]:.4g}, {high[i]:.4g}]" for i in free)
    return f" over {box}" if box else " (M depends on no joint)"


@door
def eigenvalues_along(dynamics: Dynamics, joint: int, angles: Array) -> Array:
    """The eigenvalues of M, ascending, (N, n), over angles (N,) of joint number `joint` (from 1), others at 0.

    Raises
    ------
    LookupError
        If there is no such joint.
    """
    if not 1 <= joint <= dynamics.dof:
        raise LookupError(f"`eigenvalues_along(joint=...)` counts joints from 1 to {dynamics.dof}; got {joint}.")
    angles = numbers("eigenvalues_along(angles=...)", angles, 1)
    q = np.zeros((len(angles), dynamics.dof))
    q[:, joint - 1] = angles
    return eigenvalues(dynamics, q)

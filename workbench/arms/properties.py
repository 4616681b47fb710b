"""The properties on which proofs in robot control rest: M symmetric, M' - 2C skew, M positive definite."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from workbench.arms.dynamics import Dynamics
from workbench.arms.identity_proofs import Witness, judge_zero
from workbench.core.validation.refusals import Array, matrix, numbers
from workbench.core.validation.signatures import check_arguments
from workbench.proofs.bounds import bound_text, box_of, by_intervals, extreme_eigenvalue
from workbench.proofs.equality import Kind


def nominal(dynamics: Dynamics) -> dict[str, float]:
    """The nominal value of each parameter by its symbol, which a proof inserts so that no sum of them is rounded."""
    names = [dynamics.symbols[i].name() for i in range(dynamics.p.size)]
    return dict(zip(names, dynamics.p.default.tolist(), strict=True))


@check_arguments
def eigenvalues(dynamics: Dynamics, q: Array) -> Array:
    """The eigenvalues (N, n), ascending, in kg m^2, of the symmetric part of M at positions q (N, n)."""
    n = dynamics.dof
    q = matrix("eigenvalues(q=...)", q, columns=n)
    mass = ca.Function("mass", [dynamics.q, dynamics.symbols], [ca.vec(ca.densify(dynamics.M))])
    M = np.array(mass(q.T, dynamics.p.default)).T.reshape(-1, n, n)
    if not (finite := np.isfinite(M).all(axis=(1, 2))).all():
        where = q[np.flatnonzero(~finite)[0]].tolist()
        raise ValueError(f"`eigenvalues(q)` needs a mass matrix of finite numbers; it is not so at q = {where}.")
    return np.asarray(np.linalg.eigvalsh((M + M.transpose(0, 2, 1)) / 2))


@dataclass(frozen=True, eq=False)
class PropertyVerdict:
    """The verdict on a property; if it is refuted, with a witness and what ought to be zero there, (n, n)."""

    statement: str
    kind: Kind
    evidence: str
    witness: Witness | None = None
    residual: Array | None = None


@dataclass(frozen=True, eq=False)
class DefinitenessVerdict:
    """The verdict on alpha1 I <= M(q) <= alpha2 I, alpha1 > 0, at nominal parameters.

    `alpha1` and `alpha2` are the least and greatest eigenvalue of M that were seen, in kg m^2 of an arm whose joints
    all turn, at `q_least` and `q_greatest` (n,), in so many `samples`. No eigenvalue in the box lies `beyond` the
    two, proved on so many `boxes`; None where nothing was. So many decimal `digits` of the two are proved right.
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


@check_arguments
def symmetric(dynamics: Dynamics) -> PropertyVerdict:
    """M(q) = M(q)^T, for all q and all parameters."""
    M = dynamics.M
    return _vanishes("M is symmetric", M - M.T, M, dynamics)


@check_arguments
def skew(dynamics: Dynamics) -> PropertyVerdict:
    """N = M' - 2C is skew-symmetric for all q, qd and parameters, as with the C of the Christoffel symbols."""
    rate = dynamics.mass_matrix_rate
    N = rate - 2 * dynamics.C
    terms = ca.vertcat(ca.vec(rate), ca.vec(2 * dynamics.C))
    return _vanishes("M' - 2C is skew-symmetric", N + N.T, terms, dynamics)


def _vanishes(statement: str, residual: ca.SX, terms: ca.SX, dynamics: Dynamics) -> PropertyVerdict:
    judgement = judge_zero(residual, terms, dynamics)
    found = judgement.search
    if found is None or found.witness is None:
        return PropertyVerdict(statement, judgement.kind, judgement.evidence)
    matrix = found.values.reshape(residual.shape, order="F") + 0.0  # no negative zeros
    return PropertyVerdict(statement, judgement.kind, judgement.evidence, found.witness, matrix)


@check_arguments
def positive_definite(
    dynamics: Dynamics, low: float | Array = -np.pi, high: float | Array = np.pi
) -> DefinitenessVerdict:
    """M(q) is positive definite at nominal parameters, for low <= q <= high (rad, a number or (n,))."""
    first, last = box_of("positive_definite", low, high, dynamics.dof)
    least, greatest = (
        extreme_eigenvalue(dynamics.M, dynamics.q, first, last, sign, numbers=nominal(dynamics)) for sign in (1, -1)
    )
    samples = least.samples + greatest.samples
    kind: Kind = "refuted" if least.value_bound <= 0 else "not refuted"
    place = (np.round(least.x, 6) + 0.0).tolist()
    unit = {frozenset(["rad"]): "kg m^2", frozenset("m"): "kg"}.get(frozenset(dynamics.units), "in mixed units")
    evidence = f"smallest eigenvalue {least.value:.9g} {unit} at q = {place}"
    moves = np.array(ca.DM(ca.jacobian(ca.vec(dynamics.M), dynamics.q).sparsity(), 1)).any(axis=0)
    box = " x ".join(f"q{i + 1} in [{first[i]:.4g}, {last[i]:.4g}]" for i in np.flatnonzero(moves))
    evidence += f" over {box}" if box else " (M depends on no joint)"
    if least.bound is not None and least.bound > 0:
        kind = "proved"
        evidence += f", and none below {bound_text(least.bound, 1)}{by_intervals(least.boxes)}"
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
        (least.bound, greatest.bound),
        (least.digits, greatest.digits),
        Witness(least.x, np.zeros(dynamics.dof), dynamics.p.default) if kind == "refuted" else None,
    )


@check_arguments
def eigenvalues_along(dynamics: Dynamics, joint: int, angles: Array) -> Array:
    """The eigenvalues of M, ascending, (N, n), over angles (N,) of joint number `joint` (from 1), others at 0."""
    if not 1 <= joint <= dynamics.dof:
        raise LookupError(f"`eigenvalues_along(joint=...)` counts joints from 1 to {dynamics.dof}; got {joint}.")
    angles = numbers("eigenvalues_along(angles=...)", angles, 1)
    q = np.zeros((len(angles), dynamics.dof))
    q[:, joint - 1] = angles
    return eigenvalues(dynamics, q)

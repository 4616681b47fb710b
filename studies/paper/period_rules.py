"""The two rules that give a period from a run in continuous time: by the eigenvalues of M^-1 K, and by a bound."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

import workbench as wb
from studies.paper.card import CARD as PAPER
from studies.paper.laws import mass_matrices

GAINLESS = ("PID", "super-twisting")  # these have no gain K, so no rule
MATRIX = wb.notation.Product(
    (wb.notation.Power(wb.notation.symbol("M"), wb.notation.Number(Fraction(-1))), wb.notation.symbol("K"))
)  # whose largest eigenvalue is rho
TWO_PHI = (wb.notation.Number(Fraction(2)), wb.notation.symbol("phi"))
BOUND = wb.notation.Quotient(
    wb.notation.Product((*TWO_PHI, wb.notation.symbol("lambda_min"))), wb.notation.symbol("K")
)  # in s
RULE = wb.notation.Quotient(wb.notation.Product(TWO_PHI), wb.notation.symbol("rho"))  # in s
HALF = wb.notation.Quotient(
    wb.notation.symbol("phi"), wb.notation.symbol("rho")
)  # in s, with a torque that is a period late


@dataclass(frozen=True)
class PeriodRules:
    """Within the layer of a run: the largest gain `K` in N m, and two periods in s.

    `rule` is the least 2 phi / rho, where rho is the largest eigenvalue of M^-1 K. `bound` is the least
    2 phi lambda_min(M) / |K|, which is at most as long.
    """

    K: float
    rule: float
    bound: float


def period_rules(law: str, still: wb.metrics.Measurement) -> PeriodRules | None:
    """The rules of a law from its run in continuous time, at each kept state; None for a law without a gain K."""
    if law in GAINLESS:
        return None
    run = still.trajectories
    inside = (np.abs(run["s"][0]) < PAPER["phi"]).all(axis=1)
    M = mass_matrices(run["q"][0][inside])
    K = gains(law, run["controller.K"][0][inside] if law != "SMC" else np.full((len(M), 2), PAPER["SMC: K"]))
    sizes = np.linalg.norm(K, 2, axis=(1, 2))
    rho = np.abs(np.linalg.eigvals(np.linalg.solve(M, K))).max(axis=1)
    phi = PAPER["phi"]
    bounds = 2 * phi * np.linalg.eigvalsh(M)[:, 0] / sizes
    return PeriodRules(float(sizes.max()), float((2 * phi / rho).min()), float(bounds.min()))


def gains(law: str, K: np.ndarray) -> np.ndarray:
    """The gains (N, 2, 2) of a law that has a matrix, or a number for each joint, (N, 2)."""
    return K if K.ndim == 3 else K[:, :, np.newaxis] * np.eye(2)

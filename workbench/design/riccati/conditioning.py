"""How far the solution of a Riccati equation moves, and whether it stays, when its data move a little.

The inverse of the derivative of Res at a stabilising solution, with its sign turned, maps positive
semidefinite matrices to such. So a change of the equation between -M and M moves X by no more than H(M), the
image of M, and bounds come from a few Lyapunov or Stein equations. A change of a matrix enters as
P' dZ + dZ' P, which lies between both signs of c r^2 Z'Z + P'P / c for every c > 0, r being the norm of d.

All this is the linear picture. It ends where the curvature of Res along H(M) reaches M / 4: for one state that
is Kantorovich's condition, beyond which an equation with the changed data may have no solution; for more
states it is an estimate of the same distance. For a continuous equation there is another: the least singular
value of H - i omega over the frequencies of the slow poles, H being the Hamiltonian matrix. Smaller changes of H
move no eigenvalue onto the imaginary axis. Both err on the side of fear, so the larger one counts.

References
----------
Kenney, Hewer (1990), The sensitivity of the algebraic and differential Riccati equations, SIAM J. Control
Optim. 28: the bound by H0, H1, H2, here with all matrices instead of A, G and Q.
Kantorovich's theorem, in Kantorovich, Akilov (1964), Functional Analysis in Normed Spaces, XVIII.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import linalg

from workbench.core.layout import Array
from workbench.design.matrices import EPS
from workbench.design.riccati.algebraic_equation import Continuous, Data, Equation, hamiltonian, size
from workbench.design.riccati.balancing import Units
from workbench.design.riccati.newton import Refined

ENOUGH = 0.25  # x = h + x^2 has a real solution up to h = 1/4
MOST_POLES = 12  # whose frequencies are looked at: each asks for singular values


@dataclass(frozen=True)
class Conditioning:
    """The effect of small changes of the data.

    `condition` and `in_good_units` bound the relative change of X, in the 2-norm, over that of every matrix in good
    units: as the caller measures X, and as it is in good units. `reach` estimates the relative change of every matrix
    up to which there is a stabilising solution. `response` is how far X moves, in the 2-norm, when the equation in
    good units is changed by a matrix of norm one.
    """

    condition: float
    in_good_units: float
    reach: float
    response: float


def conditioning(equation: Equation, found: Refined, units: Units) -> Conditioning:
    """The effect of relative changes of A, B, Q, R, S and E in their 2-norms."""
    d, point = equation.data, found.point
    one = np.eye(d.n)
    changes = [
        (size(d.A), point.beside_A, one),
        (size(d.B), point.beside_A, point.K),
        (size(d.Q) / 2, one, one),
        (size(d.R) / 2, point.K, point.K),
        (size(d.S), one, point.K),
        (0.0 if d.E is None else size(d.E), point.beside_E, one),
    ]
    moved: dict[int, Array] = {}

    def most(P: Array) -> Array:
        """H(P'P)."""
        if id(P) not in moved:
            moved[id(P)] = found.operator.solve(-P.T @ P)
        return moved[id(P)]

    whole, X = size(units.out_of(point.X)), size(point.X)
    total, inside, M = 0.0, 0.0, np.zeros((d.n, d.n))
    for r, P, Z in changes:
        by_P, by_Z = size(most(P)), size(most(Z))
        if not r * by_P * by_Z > 0:
            continue
        total += 2 * r * np.sqrt(size(units.out_of(most(P)))) * np.sqrt(size(units.out_of(most(Z))))
        inside += 2 * r * np.sqrt(by_P) * np.sqrt(by_Z)
        c = np.sqrt(by_P / by_Z) / r
        M += c * r**2 * Z.T @ Z + P.T @ P / c
    reach = _reach(equation, found, M)
    if reach <= EPS**0.75 and isinstance(equation, Continuous):
        reach = max(reach, _distance(d, found))
    response = size(units.out_of(most(one)))
    return Conditioning(total / whole if whole > 0 else 0.0, inside / X if X > 0 else 0.0, reach, response)


def _reach(equation: Equation, found: Refined, M: Array) -> float:
    """The largest t with curvature(H(t M)) <= t M / 4."""
    if not M.any():
        return 1.0
    bent = equation.curvature(found.point, found.operator.solve(-M))
    values, vectors = np.linalg.eigh(M)
    root = vectors / np.sqrt(np.maximum(values, EPS * values[-1]))
    most = float(linalg.eigvalsh(root.T @ bent @ root)[-1])
    return min(1.0, ENOUGH / most) if most > 0 else 1.0


def _distance(d: Data, found: Refined) -> float:
    """The least singular value of H - i omega at the frequencies of the slowest poles, over the norm of H."""
    H, one = hamiltonian(d), np.eye(2 * d.n)
    slow = found.operator.poles[np.argsort(found.operator.margins())[:MOST_POLES]]
    least = [np.linalg.svd(H - 1j * omega * one, compute_uv=False)[-1] for omega in np.unique(np.abs(slow.imag))]
    return float(min(least)) / size(H)

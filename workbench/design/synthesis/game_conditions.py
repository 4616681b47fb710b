"""The conditions for a gamma: two Riccati equations with stabilising solutions X, Y >= 0, and rho(X Y) < gamma^2.

A stabilising solution is X = X2 X1^-1, with an orthonormal basis [X1; X2] of the stable invariant subspace of a
Hamiltonian matrix. X1 + i X2 is unitary then, and X has the eigenvalues tan(theta) of its phases theta. So X >= 0 is
decided where X is nearly infinite, too.

References
----------
Glover, Doyle (1988), State-space formulae for all stabilizing controllers that satisfy an H-infinity norm bound,
Systems Control Lett. 11. Benner, Byers, Losse, Mehrmann, Xu (2011), Robust formulas for H-infinity optimal
controllers, Automatica 47 (conditions by bases of subspaces).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import linalg

from workbench.core.validation.refusals import Array
from workbench.design.riccati.algebraic_equation import Data, hamiltonian
from workbench.design.synthesis.generalized_plant import PlantParts

ISOTROPY = 1e-7  # of a basis: if eigenvalues lie on the axis, no choice of them makes X1'X2 symmetric
NEGATIVE = 1e-7  # a phase below this, with its sign turned, is that of a negative eigenvalue
DIRECT = "the direct term D11"
CONTROL, FILTER, COUPLING = "X", "Y", "rho(XY)"


@dataclass(frozen=True)
class GameVerdict:
    """The condition that fails for a gamma, or an empty text, its sentence, and rho(XY) / gamma^2 where it is known."""

    failure: str
    text: str = ""
    coupling: float = np.nan

    @property
    def holds(self) -> bool:
        """True if a controller reaches this gamma."""
        return not self.failure


def direct_bound(p: PlantParts) -> float:
    """The gamma that no controller can beat at infinite frequency, for a plant in normal form."""
    rows, columns = len(p.D11) - p.D12.shape[1], p.D11.shape[1] - len(p.D21)
    sizes = [np.linalg.norm(part, 2) for part in (p.D11[:rows], p.D11[:, :columns]) if part.size]
    return float(max(sizes, default=0.0))


def game_data(p: PlantParts, gamma: float) -> Data:
    """The equation of X for a plant in normal form; that of its dual is the equation of Y."""
    D1 = np.hstack([p.D11, p.D12])
    R = D1.T @ D1
    nw = p.D11.shape[1]
    R[:nw, :nw] -= gamma**2 * np.eye(nw)
    return Data(p.A, np.hstack([p.B1, p.B2]), p.C1.T @ p.C1, R, p.C1.T @ D1, None)


def stable_basis(d: Data) -> tuple[Array, Array] | None:
    """An orthonormal basis (X1, X2) of the stable subspace, or None if eigenvalues lie on the imaginary axis."""
    H = hamiltonian(d)
    if not np.isfinite(H).all():
        return None
    try:
        _, U, stable = linalg.schur(H, sort="lhp")
    except linalg.LinAlgError:  # eigenvalues so near to the axis that putting them in order moves them across
        return None
    n = d.n
    if stable != n:
        return None
    X1, X2 = U[:n, :n], U[n:, :n]
    across = X1.T @ X2
    return (X1, X2) if float(np.abs(across - across.T).max()) <= ISOTROPY else None


def phases(basis: tuple[Array, Array]) -> Array:
    """The angles theta (n,) with X = tan(theta), between -pi/2 and pi/2."""
    U = basis[0] + 1j * basis[1]
    values = linalg.eigvals(U @ U.T)
    return np.asarray(np.angle(values) / 2)


def judge_gamma(p: PlantParts, gamma: float, bound: float) -> GameVerdict:
    """The first condition that fails for a gamma, of a plant in normal form with this `direct_bound`."""
    if not gamma > bound:
        return GameVerdict(DIRECT, f"{DIRECT} needs a gamma above {bound:.9g}, at infinite frequency")
    bases = []
    for name, part in ((CONTROL, p), (FILTER, p.dual())):
        basis = stable_basis(game_data(part, gamma))
        which = "control" if name == CONTROL else "filter"
        if basis is None:
            text = f"the Riccati equation of {name} ({which}) has no stabilising solution: its Hamiltonian matrix has "
            return GameVerdict(name, text + "eigenvalues on the imaginary axis")
        lowest = float(phases(basis).min())
        if lowest < -NEGATIVE:
            text = f"the stabilising solution {name} ({which}) is not positive semidefinite: it has the eigenvalue "
            return GameVerdict(name, f"{text}{np.tan(lowest):.3g}")
        bases.append(basis)
    rho = spectral_radius(*bases) / gamma**2
    if not rho < 1:
        text = f"the spectral radius of X Y is {rho:.12g} gamma^2, and must be below gamma^2"
        return GameVerdict(COUPLING, text, rho)
    return GameVerdict("", "", rho)


def spectral_radius(x: tuple[Array, Array], y: tuple[Array, Array]) -> float:
    """The largest eigenvalue of X Y, from the pencil Y2'X2 - lambda Y1'X1."""
    alpha, beta = linalg.eigvals(y[1].T @ x[1], y[0].T @ x[0], homogeneous_eigvals=True)
    with np.errstate(all="ignore"):
        ratios = np.abs(alpha) / np.abs(beta)
    return float(np.max(ratios[~np.isnan(ratios)], initial=0.0))

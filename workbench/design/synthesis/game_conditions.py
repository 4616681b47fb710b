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
from workbench.design.matrices import Complex
from workbench.design.riccati.algebraic_equation import Data, hamiltonian
from workbench.design.riccati.conditioning import BinaryUnits, Exponents, good_units
from workbench.design.synthesis.generalized_plant import PlantParts

OFF_AXIS = 0.5  # of its distance from the axis: most that an eigenvalue may lie from the mirror image of another
ISOTROPY = 1e-3  # of a basis: with it X1'X2 is symmetric
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


def regulator_units(p: PlantParts) -> Exponents:
    """The exponents of units of the states in which the equation of X has entries alike, by that without w."""
    data = Data(p.A, p.B2, p.C1.T @ p.C1, p.D12.T @ p.D12, p.C1.T @ p.D12, None)
    return good_units(data).states


@dataclass(frozen=True)
class StableBasis:
    """An orthonormal basis [X1; X2] (2 n, n) of a stable subspace, of states x = 2^units z: there X2 X1^-1 solves."""

    X1: Array
    X2: Array
    units: Exponents

    @staticmethod
    def of(data: Data, units: Exponents) -> StableBasis | None:
        """The basis for an equation, or None if its Hamiltonian matrix has eigenvalues on the imaginary axis."""
        H = hamiltonian(BinaryUnits(units, np.zeros(len(data.R), dtype=int)).into(data))
        if not np.isfinite(H).all():
            return None
        try:
            T, U, stable = linalg.schur(H, sort="lhp")
        except linalg.LinAlgError:  # eigenvalues so near to the axis that putting them in order moves them across
            return None
        n = data.n
        if stable != n or not _is_off_axis(np.asarray(linalg.eigvals(T), dtype=complex)):
            return None
        basis = StableBasis(U[:n, :n], U[n:, :n], units)
        across = basis.X1.T @ basis.X2
        return basis if float(np.abs(across - across.T).max()) <= ISOTROPY else None

    def phases(self) -> Array:
        """The angles theta (n,), from -pi/2 to pi/2, with the eigenvalues tan(theta) of X in these units."""
        U = self.X1 + 1j * self.X2
        return np.asarray(np.angle(linalg.eigvals(U @ U.T)) / 2)

    def solution(self) -> Array:
        """X in the units of the caller."""
        X = np.linalg.solve(self.X1.T, self.X2.T)
        factor = np.exp2(-self.units.astype(float))
        return np.asarray((X + X.T) / 2 * factor * factor[:, None])


@dataclass(frozen=True)
class Game:
    """A plant in normal form and its dual, with the units of both equations and the `direct_bound`."""

    plant: PlantParts
    dual: PlantParts
    units: tuple[Exponents, Exponents]
    bound: float

    @staticmethod
    def of(plant: PlantParts) -> Game:
        """The game of a plant in normal form."""
        dual = plant.dual()
        return Game(plant, dual, (regulator_units(plant), regulator_units(dual)), direct_bound(plant))

    def judge(self, gamma: float) -> GameVerdict:
        """The first condition that fails for a gamma."""
        if not gamma > self.bound:
            return GameVerdict(DIRECT, f"{DIRECT} needs a gamma above {self.bound:.9g}, at infinite frequency")
        bases = []
        for name, which, part, units in (
            (CONTROL, "control", self.plant, self.units[0]),
            (FILTER, "filter", self.dual, self.units[1]),
        ):
            basis = StableBasis.of(game_data(part, gamma), units)
            if basis is None:
                text = f"the Riccati equation of {name} ({which}) has no stabilising solution: its Hamiltonian matrix "
                return GameVerdict(name, text + "has eigenvalues on the imaginary axis")
            if float(basis.phases().min()) < -NEGATIVE:
                return GameVerdict(name, f"the stabilising solution {name} ({which}) is not positive semidefinite")
            bases.append(basis)
        rho = spectral_radius(*bases) / gamma**2
        if not rho < 1:
            text = f"the spectral radius of X Y is {rho:.12g} gamma^2, and must be below gamma^2"
            return GameVerdict(COUPLING, text, rho)
        return GameVerdict("", "", rho)


def _is_off_axis(values: Complex) -> bool:
    """True if eigenvalues of a Hamiltonian matrix come in pairs about the imaginary axis, and not on it one by one.

    Rounding moves two eigenvalues on the axis to either side, but not towards each other.
    """
    left, right = values[values.real < 0], values[values.real >= 0]
    apart = np.abs(left[:, None] + right.conj()[None, :]).min(axis=1)
    return bool((apart <= -OFF_AXIS * left.real).all())


def spectral_radius(x: StableBasis, y: StableBasis) -> float:
    """The largest eigenvalue of X Y, from the pencil Y2'X2 - lambda Y1'X1."""
    units = x.units + y.units
    middle = int(np.round(np.mean(units)))
    factor = np.exp2((units - middle).astype(float))
    left, right = y.X2.T @ (x.X2 / factor[:, None]), y.X1.T @ (x.X1 * factor[:, None])
    alpha, beta = linalg.eigvals(left, right, homogeneous_eigvals=True)
    with np.errstate(all="ignore"):
        ratios = np.abs(alpha) / np.abs(beta) * np.exp2(-2.0 * middle)
    return float(np.max(ratios[~np.isnan(ratios)], initial=0.0))

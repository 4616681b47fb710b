"""The central controller of Glover and Doyle for a gamma, of a plant in normal form, from the solutions X and Y."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import linalg

from workbench.core.validation.refusals import Array
from workbench.design.matrices import DesignError
from workbench.design.riccati.stabilising_solution import stabilising_solution
from workbench.design.synthesis.game_conditions import StableBasis, game_data, regulator_units
from workbench.design.synthesis.generalized_plant import PlantParts
from workbench.design.synthesis.normal_plant import Controller


@dataclass(frozen=True)
class GameSolution:
    """The stabilising X (n, n), or Y, of a game, and its gain."""

    X: Array
    K: Array


def solve_game(call: str, p: PlantParts, gamma: float) -> GameSolution:
    """X with its gain, refined where that can be trusted, or else from the subspace of the Hamiltonian matrix."""
    data = game_data(p, gamma)
    try:
        found = stabilising_solution(call, data, discrete=False)
        return GameSolution(found.X, np.asarray(found.K))
    except DesignError as refused:
        basis = StableBasis.of(data, regulator_units(p))
        if basis is None:
            raise refused
    X = basis.solution()
    return GameSolution(X, np.asarray(np.linalg.solve(data.R, data.B.T @ X + data.S.T)))


def central_controller(call: str, p: PlantParts, gamma: float) -> Controller:
    """A, B, C, D of the central controller; `LinAlgError` if rounding leaves none.

    References
    ----------
    Zhou, Doyle, Glover (1996), Robust and Optimal Control, theorem 17.1.
    """
    x, y = solve_game(call, p, gamma), solve_game(call, p.dual(), gamma)
    nw, nu, nz, ny = p.B1.shape[1], p.B2.shape[1], len(p.C1), len(p.C2)
    a, b = nz - nu, nw - ny  # errors that u does not reach, disturbances that y does not show
    F, L = -x.K, -y.K.T
    F12, F2 = F[b:nw], F[nw:]
    L12, L2 = L[:, a:nz], L[:, nz:]
    D1111, D1112, D1121, D1122 = p.D11[:a, :b], p.D11[:a, b:], p.D11[a:, :b], p.D11[a:, b:]
    across = np.linalg.solve(gamma**2 * np.eye(a) - D1111 @ D1111.T, D1112)
    D11 = -D1121 @ D1111.T @ across - D1122
    D12 = _root(np.eye(nu) - D1121 @ np.linalg.solve(gamma**2 * np.eye(b) - D1111.T @ D1111, D1121.T))
    D21 = _root(np.eye(ny) - D1112.T @ across).T
    # Z = (I - Y X / gamma^2)^-1 stands before all that enters the controller's states
    Z = np.eye(len(p.A)) - y.X @ x.X / gamma**2
    entering = np.linalg.solve(Z, np.hstack([(p.B2 + L12) @ D12, L2]))
    B2, ZL2 = entering[:, :nu], entering[:, nu:]
    C2 = -D21 @ (p.C2 + F12)
    B1 = np.asarray(-ZL2 + B2 @ np.linalg.solve(D12, D11))
    C1 = np.asarray(F2 + D11 @ np.linalg.solve(D21, C2))
    A = p.A + np.hstack([p.B1, p.B2]) @ F + B1 @ np.linalg.solve(D21, C2)
    return A, B1, C1, D11


def _root(square: Array) -> Array:
    """The lower triangular L with L L' = a positive definite matrix."""
    return np.asarray(linalg.cholesky(square, lower=True))

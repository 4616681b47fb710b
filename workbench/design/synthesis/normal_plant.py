"""A generalized plant in coordinates in which D12 is [0; I] and D21 is [0, I], and the way back for a controller."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import linalg

from workbench.core.validation.refusals import Array
from workbench.design.matrices import EPS, DesignError
from workbench.design.riccati.conditioning import nearest
from workbench.design.synthesis.generalized_plant import NEAR_SINGULAR, PlantParts

SWEEPS = 6  # of balancing; each brings rows and columns nearer to each other

Controller = tuple[Array, Array, Array, Array]


@dataclass(frozen=True)
class NormalPlant:
    """The plant `parts` without D22, in balanced states, with u = `from_u` u~ and y~ = `to_y` y; D22 is kept aside.

    Disturbances and errors are turned, which changes no norm.
    """

    parts: PlantParts
    from_u: Array
    to_y: Array
    D22: Array

    @staticmethod
    def of(plant: PlantParts) -> NormalPlant:
        """The normal form of a plant with a D12 of full column rank and a D21 of full row rank."""
        turn_z, from_u = _normal_columns(plant.D12)
        turn_w, columns = _normal_columns(plant.D21.T)
        to_y = columns.T
        p = balanced_states(plant)
        ny, nu = len(to_y), len(from_u)
        D12 = np.vstack([np.zeros((len(turn_z) - nu, nu)), np.eye(nu)])
        D21 = np.hstack([np.zeros((ny, len(turn_w) - ny)), np.eye(ny)])
        turned = PlantParts(
            A=p.A,
            B1=p.B1 @ turn_w.T,
            B2=p.B2 @ from_u,
            C1=turn_z @ p.C1,
            C2=to_y @ p.C2,
            D11=turn_z @ p.D11 @ turn_w.T,
            D12=D12,
            D21=D21,
            D22=np.zeros((ny, nu)),
        )
        return NormalPlant(turned, from_u, to_y, plant.D22)

    def controller(self, call: str, K: Controller) -> Controller:
        """The controller of the plant as it was, with D22, from one of the normal plant."""
        A, B, C, D = K
        B, C, D = B @ self.to_y, self.from_u @ C, self.from_u @ D @ self.to_y
        return without_direct_path(call, (A, B, C, D), self.D22)


def without_direct_path(call: str, K: Controller, D22: Array) -> Controller:
    """The controller u = K (y - D22 u) from y to u, for one that was designed without D22."""
    A, B, C, D = K
    W = np.eye(len(D)) + D @ D22
    if np.linalg.cond(W) * NEAR_SINGULAR > 1:
        raise DesignError(
            f"`{call}`: the loop of D22 and the controller's direct term is not well-posed. Take the direct term out "
            "of the plant, by the lag that it has in truth, or ask for a larger gamma."
        )
    gain = np.asarray(np.linalg.solve(W, np.hstack([C, D])))
    C, D = gain[:, : C.shape[1]], gain[:, C.shape[1] :]
    return A - B @ D22 @ C, B - B @ D22 @ D, C, D


def _normal_columns(D: Array) -> tuple[Array, Array]:
    """An orthogonal T and an invertible V with T D V = [0; I]."""
    U, values, Vt = linalg.svd(D)
    m = len(Vt)
    turn = np.vstack([U[:, m:].T, U[:, :m].T])
    return turn, Vt.T / values


def balanced_states(p: PlantParts) -> PlantParts:
    """The plant with its states in units, powers of two, in which each has a row and a column of one size."""
    n = len(p.A)
    units = np.zeros(n, dtype=int)
    for _ in range(SWEEPS):
        scaled = scale_states(p, units)
        off = scaled.A - np.diag(np.diag(scaled.A))
        rows = np.linalg.norm(np.hstack([off, scaled.B1, scaled.B2]), axis=1)
        columns = np.linalg.norm(np.vstack([off, scaled.C1, scaled.C2]), axis=0)
        least = EPS * max(float(rows.max()), float(columns.max()), 1e-300)
        units = units + nearest((np.maximum(rows, least)) / np.maximum(columns, least), 2)
    return scale_states(p, units)


def scale_states(p: PlantParts, units: Array) -> PlantParts:
    """The plant with the states x = 2^units x~."""
    factor = np.exp2(units.astype(float))
    return replace(
        p,
        A=p.A * factor / factor[:, None],
        B1=p.B1 / factor[:, None],
        B2=p.B2 / factor[:, None],
        C1=p.C1 * factor,
        C2=p.C2 * factor,
    )

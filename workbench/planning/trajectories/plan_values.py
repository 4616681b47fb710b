"""The numbers of a trajectory in a search: durations, states at nodes and inside intervals, inputs; new meshes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.planning.trajectories.collocation import STAGES, radau_points


@dataclass(frozen=True, eq=False)
class ArcValues:
    """One phase: N intervals with shares `mesh` (N,) of its duration T [s].

    x (N + 1, nx) at the nodes, `inner` (N, d - 1, nx) at the points inside; u (N, nu) held or (N + 1, nu) at the nodes.
    """

    mesh: Array
    T: float
    x: Array
    inner: Array
    u: Array

    @property
    def shares(self) -> Array:
        """The nodes (N + 1,) as shares of the duration."""
        nodes = np.concatenate([[0.0], np.cumsum(self.mesh)])
        return np.asarray(nodes / nodes[-1])

    @property
    def is_held(self) -> bool:
        """True if the input is constant in each interval."""
        return len(self.u) == len(self.mesh)

    @property
    def begins(self) -> Array:
        """The inputs (N, nu) at the begin of each interval."""
        return self.u if self.is_held else self.u[:-1]

    @property
    def ends(self) -> Array:
        """The inputs (N, nu) at the end of each interval."""
        return self.u if self.is_held else self.u[1:]

    def states_at(self, shares: Array) -> Array:
        """The states (M, nx) at shares of the duration, by the polynomial of each interval."""
        nodes = self.shares
        k = np.clip(np.searchsorted(nodes, shares, side="right") - 1, 0, len(self.mesh) - 1)
        s = (shares - nodes[k]) / (nodes[k + 1] - nodes[k])
        places = np.concatenate([[0.0], radau_points()])
        values = np.concatenate([self.x[:-1, None], self.inner, self.x[1:, None]], axis=1)
        basis = np.array([_lagrange(places, j, s) for j in range(STAGES + 1)])
        return np.asarray(np.einsum("jm,mjn->mn", basis, values[k]))

    def powers(self, k: int) -> Array:
        """(nx, d + 1), coefficients of 1, s, s^2, ... of the states in interval k, s being the share from 0 to 1."""
        places = np.concatenate([[0.0], radau_points()])
        values = np.vstack([self.x[k], self.inner[k], self.x[k + 1]])
        return np.asarray(np.linalg.solve(np.vander(places, increasing=True), values).T)

    def inputs_at(self, shares: Array) -> Array:
        """The inputs (M, nu) at shares of the duration; at a node, those of the interval behind it."""
        nodes = self.shares
        k = np.clip(np.searchsorted(nodes, shares, side="right") - 1, 0, len(self.mesh) - 1)
        s = ((shares - nodes[k]) / (nodes[k + 1] - nodes[k]))[:, None]
        return np.asarray(self.begins[k] + s * (self.ends - self.begins)[k])

    def on_mesh(self, mesh: Array, hold: str) -> ArcValues:
        """The same trajectory on another mesh, whose inputs are held or linear."""
        nodes = np.concatenate([[0.0], np.cumsum(mesh)]) / mesh.sum()
        x = self.states_at(nodes)
        places = (nodes[:-1, None] + np.diff(nodes)[:, None] * radau_points()[:-1]).ravel()
        inner = self.states_at(places).reshape(len(mesh), STAGES - 1, -1)
        u = self.inputs_at((nodes[:-1] + nodes[1:]) / 2 if hold == "zero" else nodes)
        return replace(self, mesh=mesh, x=x, inner=inner, u=u)


Values = tuple[ArcValues, ...]


def _lagrange(places: Array, j: int, s: Array) -> Array:
    others = np.delete(places, j)
    return np.asarray(np.prod([(s - place) / (places[j] - place) for place in others], axis=0))


def linear_inner(x: Array) -> Array:
    """The states (N, d - 1, nx) inside intervals on straight lines between the nodes x (N + 1, nx)."""
    c = radau_points()[:-1]
    return np.asarray(x[:-1, None] + c[:, None] * np.diff(x, axis=0)[:, None])

"""The base of the Kalman filters of any plant: a covariance, readings of several rates, steps between readings."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Signals
from workbench.core.block import Matrix, Number
from workbench.core.numbers import Bounds
from workbench.core.port import ANY
from workbench.loop.contracts import Inputs, Parts, Reads
from workbench.observers.model import MOST_SUBSTEPS, AbstractModelObserver, refuse_unfit, stacked, with_hats
from workbench.validation.refusals import known, seconds, whole
from workbench.validation.signatures import door

COVARIANCE, PIVOT = "P", "pivot"  # beside the estimated states in the memory


class AbstractKalmanFilter(AbstractModelObserver):
    """An observer that corrects x_hat and P at each instant by the new readings, and moves both to the next."""

    Q: Matrix
    R: Matrix
    P: Matrix
    period: float
    every: Mapping[str, int]
    substeps: int

    @property
    def memory(self) -> Layout:
        """The estimated states and P before the readings of the next instant, and the least pivot of P so far."""
        P = Entry(COVARIANCE, self.P, ANY, Bounds(symmetric=True, definite="semi"))
        return with_hats(self.model.states) + Layout((P, Entry(PIVOT, np.array(1.0))))

    @door
    def estimate(self, t: Number, z: Parts, y: Reads) -> Signals:
        return self._estimates(t, self._read(t, z, y)[0])

    @door
    def update(self, t: Number, z: Parts, y: Reads, est: Signals, u: Inputs) -> Parts:
        """The states and P before the readings of the next instant."""
        x, P, pivot = self._read(t, z, y)
        step = self.period / self.substeps
        for i in range(self.substeps):
            x, P = self._moved(t + i * step, x, P, u, step)
        P = symmetric(P)
        return {**self._parts(x), COVARIANCE: P, PIVOT: ca.fmin(ca.fmin(z[PIVOT], pivot), cholesky(P)[1])}

    def _read(self, t: ca.SX, z: Parts, y: Signals) -> tuple[ca.SX, ca.SX, ca.SX]:
        """The correction of a memory by `_corrected`, from which a reading that is not new is left out exactly."""
        new = self._new(t)
        R = ca.SX(self.R) * (new @ new.T) + ca.diag(1 - new)
        x, P, pivot = self._corrected(t, self._column(z), symmetric(z[COVARIANCE]), stacked(y, self.reads), R, new)
        return x, symmetric(P), pivot

    def _new(self, t: ca.SX) -> ca.SX:
        """1 for each number that is read anew at a time, else 0, (ny, 1)."""
        k = ca.floor(t / self.period + 0.5)
        each = [(self.every.get(entry.name, 1), entry.size) for entry in self.reads.entries]
        parts = [ca.SX(1) if n == 1 else ca.if_else(ca.fmod(k, n) == 0, 1, 0) for n, size in each for _ in range(size)]
        return ca.vertcat(*parts)

    @abstractmethod
    def _corrected(self, t: ca.SX, x: ca.SX, P: ca.SX, y: ca.SX, R: ca.SX, new: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
        """x_hat and P after readings y, and the least pivot of their covariance.

        A reading that is not new has 0 in `new`, (ny, 1), and a row of the identity in R.
        """

    @abstractmethod
    def _moved(self, t: ca.SX, x: ca.SX, P: ca.SX, u: Signals, step: float) -> tuple[ca.SX, ca.SX]:
        """x_hat and P after a step in s."""


def symmetric(P: ca.SX) -> ca.SX:
    """The symmetric matrix that has the upper triangle of P."""
    return ca.triu2symm(ca.triu(ca.densify(P)))


def cholesky(P: ca.SX) -> tuple[ca.SX, ca.SX]:
    """The factor G of P = G G', lower triangular, and the least of its pivots as a share of the diagonal of P.

    The share is 1 for a diagonal matrix, and that part of a variance which those before it leave open; it is 0 where
    P is singular and negative where P is indefinite. A pivot that is not positive makes a column of zeros, so that G
    is always a number.
    """
    n = P.shape[0]
    G, least = ca.SX(n, n), ca.SX(1)
    for j in range(n):
        rest = P[j:, j] - (G[j:, :j] @ G[j, :j].T if j else 0)
        positive, size = rest[0] > 0, ca.fabs(P[j, j])
        least = ca.fmin(least, rest[0] / ca.if_else(size > 0, size, 1))
        root = ca.sqrt(ca.if_else(positive, rest[0], 1))  # nothing is ever divided by 0
        G[j, j] = ca.if_else(positive, root, 0)
        for i in range(1, n - j):
            G[j + i, j] = ca.if_else(positive, rest[i] / root, 0)
    return G, least


def gain(across: ca.SX, S: ca.SX) -> tuple[ca.SX, ca.SX]:
    """K = across S^-1 and the least pivot of S; where that is not positive S is no covariance, and K is 0."""
    G, least = cholesky(S)
    G = ca.if_else(least > 0, G, ca.SX.eye(S.shape[0]))
    return ca.if_else(least > 0, ca.solve(G.T, ca.solve(G, across.T)).T, 0), least


def refuse_unfit_filter(observer: AbstractKalmanFilter) -> None:
    """Refuse numbers of a filter that do not fit its model, and a P that is no covariance."""
    name, states = type(observer).__name__, observer.model.states
    refuse_unfit(observer, Q=(states, states), R=(observer.reads, observer.reads), P=(states, states))
    semi, positive = Bounds(symmetric=True, definite="semi"), Bounds(symmetric=True, definite="positive")
    for letter, bounds in (("Q", semi), ("R", positive), ("P", semi)):
        bounds.refuse_unsymmetric(f"{name}({letter}=...)", getattr(observer, letter)[np.newaxis])
    seconds(f"{name}(period=...)", observer.period)
    whole(f"{name}(substeps=...)", observer.substeps, most=MOST_SUBSTEPS)
    for output, count in observer.every.items():
        known(output, observer.reads.names, f"outputs that `{name}` reads")
        whole(f"{name}(every=...)", count, of=f" of instants for '{output}'")

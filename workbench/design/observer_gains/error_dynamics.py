"""The error of an observer with arm, estimate and torque frozen, or where the model adds nothing:

    x~' = A0 x~ + [0; I] Delta - L v,    A0 = [[-L1, I], [-L2, 0]],  x~ = (q - q_hat, qd - qd_hat),

with v the noise of the measured positions. Frozen poles may all decay and the error grow, or the reverse.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from workbench.design.matrices import Refused, matrix
from workbench.design.observer_gains.gains import Gains, Region
from workbench.design.observer_gains.inequality import bears_mismatch
from workbench.design.observer_gains.mismatch import Mismatch, refuse_unfit
from workbench.design.riccati import lyapunov
from workbench.proofs.branch_and_bound import sequence
from workbench.validation.refusals import Array, whole
from workbench.validation.signatures import door
from workbench.validation.views import show

SAMPLES = 20_000
# Instants at which a transient is looked at, from a thousandth of the fastest time constant to ten of the slowest:
# a step of 1 %, so its peak is met within 1e-4 of itself.
INSTANTS, HALVINGS = 2000, 60


@dataclass(frozen=True, eq=False)
@show
class Frozen:
    """Poles at N states of a region.

    Parameters
    ----------
    q, qd, tau
        (N, n), in rad, rad/s, N m.
    poles
        (N, 2n), in 1/s.
    """

    q: Array
    qd: Array
    tau: Array
    poles: Array

    @property
    def rates(self) -> Array:
        """The decay of the slowest mode at each state, in 1/s, (N,); negative where it grows."""
        return np.asarray(-self.poles.real.max(axis=1))

    @property
    def slowest(self) -> float:
        """The least of the rates."""
        return float(self.rates.min())

    @property
    def unstable(self) -> float:
        """The share of the states at which a mode grows."""
        return float((self.rates < 0).mean())


@door
def frozen_poles(mismatch: Mismatch, gains: Gains, q: Array, qd: Array, tau: Array) -> Array:
    """The eigenvalues (N, 2n) of the exact error Jacobian [[-L1, I], [df/dq - L2, df/dqd]] at N states, in 1/s.

    Raises
    ------
    ValueError
        If the states are not a row of n finite numbers each.
    """
    q, qd, tau = _rows("frozen_poles", mismatch, q, qd, tau)
    return np.asarray(np.linalg.eigvals(gains.error_matrix(mismatch.at(q, qd, tau))))


@door
def over(mismatch: Mismatch, gains: Gains, region: Region, samples: int = SAMPLES) -> Frozen:
    """The frozen poles at states spread evenly over a region, which are samples and no bound.

    Raises
    ------
    ValueError
        If region or gains are those of another arm, or there are no samples.
    """
    whole("over(samples=...)", samples)
    refuse_unfit("over", mismatch, gains, region)
    n, (low, high) = region.joints, region.box
    u = sequence(samples, 3 * n)
    q = low + u[:, :n] * (high - low)
    qd, tau = (2 * u[:, n : 2 * n] - 1) * region.speed, (2 * u[:, 2 * n :] - 1) * region.torque
    return Frozen(q, qd, tau, frozen_poles(mismatch, gains, q, qd, tau))


@door
def along(mismatch: Mismatch, gains: Gains, region: Region, q: Array, qd: Array, tau: Array) -> Frozen:
    """The frozen poles along a path (N, n) of positions, velocities and torques.

    Raises
    ------
    ValueError
        If the path has not a row of n finite numbers each, or leaves the region.
    """
    refuse_unfit("along", mismatch, gains, region)
    path = _rows("along", mismatch, q, qd, tau)
    if (gone := region.outside(*path)).any():
        row = int(np.argmax(gone))
        raise ValueError(
            f"`along(q, qd, tau)` must stay in the region; its row {row} leaves it, with q = {path[0][row].tolist()}, "
            f"qd = {path[1][row].tolist()}, tau = {path[2][row].tolist()}."
        )
    return Frozen(*path, frozen_poles(mismatch, gains, *path))


def _rows(call: str, mismatch: Mismatch, *given: Array) -> tuple[Array, Array, Array]:
    """States and torques (N, n), checked."""
    path = list(given)
    shapes = {part.shape for part in path}
    if len(shapes) > 1 or path[0].ndim != 2 or path[0].shape[1] != mismatch.joints or not len(path[0]):
        raise ValueError(
            f"`{call}(q, qd, tau)` must be {mismatch.joints} numbers a row each; got shapes "
            f"{[part.shape for part in path]}."
        )
    if not all(np.isfinite(part).all() for part in path):
        raise ValueError(f"`{call}(q, qd, tau)` must be finite numbers; it holds NaN or infinity.")
    q, qd, tau = path
    return q, qd, tau


@dataclass(frozen=True)
@show
class Noise:
    """H2 norms from the noise of the positions to the errors: `position` in s^(-1/2), `velocity` in s^(-3/2).

    White noise of spectral density S (rad^2/Hz, two-sided) gives errors of sqrt(S) times these, in rad and rad/s.
    """

    position: float
    velocity: float


@door
def noise(gains: Gains, J: Array | None = None) -> Noise:
    """The H2 norms from v to q~ and to qd~: the roots of the traces of X, A X + X A' + L L' = 0.

    Parameters
    ----------
    J
        The Jacobian [df/dq, df/dqd] (n, 2n) of a state; where the model adds nothing if not given.

    Raises
    ------
    Refused
        If the error does not decay there.
    """
    n, A = gains.joints, _decaying("noise", gains, J)
    L = gains.stacked
    X = lyapunov(A, L @ L.T).X
    return Noise(float(np.sqrt(np.trace(X[:n, :n]))), float(np.sqrt(np.trace(X[n:, n:]))))


@door
def peaking(gains: Gains, J: Array | None = None) -> float:
    """The worst transient: the greatest |qd~(t)| for qd~(0) = 0 and |q~(0)| = 1 rad, in 1/s, to 1e-4 of itself.

    Raises
    ------
    Refused
        If the error does not decay there.
    """
    n, A = gains.joints, _decaying("peaking", gains, J)
    poles = np.linalg.eigvals(A)
    t = np.geomspace(1e-3 / np.abs(poles).max(), 10 / -poles.real.max(), INSTANTS)
    part = expm(t[:, None, None] * A)[:, n:, :n]
    return float(np.linalg.norm(part, 2, axis=(1, 2)).max())


@door
def tolerated(gains: Gains) -> tuple[float, Array]:
    """The largest rho such that one P (2n, 2n) proves a decay for every Delta with |Delta| <= rho |x~|, and that P.

    It is 1 / max |[0; I] to x~ at i w| over all frequencies w, found by bisection on the imaginary eigenvalues of a
    Hamiltonian matrix. P solves A0' P + P A0 + rho^2 I + P [0; I] [0; I]' P < 0, which is checked in rational
    arithmetic: so V = x~' P x~ falls.

    Raises
    ------
    Refused
        If the check fails.

    References
    ----------
    Boyd, Balakrishnan and Kabamba (1989), A bisection method for computing the H-infinity norm, Math. Control Signals
    Systems 2. Rajamani (1998), Observers for Lipschitz nonlinear systems, IEEE Trans. Automatic Control 43.
    """
    n, A = gains.joints, gains.error_matrix()
    B = np.eye(2 * n)[:, n:]
    low, high = 0.0, 1 / float(np.linalg.norm(np.linalg.solve(A, B), 2))
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        poles = np.linalg.eigvals(_hamiltonian(A, B, middle))
        crossing = np.abs(poles.real).min() < 1e-9 * np.abs(poles).max()
        low, high = (low, middle) if crossing else (middle, high)
    room = 1e-6
    P = _riccati(A, B, (1 - room) * low)
    rho = (1 - 2 * room) * low
    if not bears_mismatch(P, A, B, rho):
        raise Refused("The certificate of the tolerated mismatch fails its check in rational arithmetic.")
    return rho, P


def _decaying(call: str, gains: Gains, J: Array | None) -> Array:
    shape = (gains.joints, 2 * gains.joints)
    A = gains.error_matrix(None if J is None else matrix(f"{call}(J=...)", "J", J, *shape))
    if (slowest := float(np.linalg.eigvals(A).real.max())) >= 0:
        raise Refused(f"`{call}(...)` needs an error that decays; a mode grows here at {slowest:.3g} 1/s.")
    return A


def _hamiltonian(A: Array, B: Array, rho: float) -> Array:
    return np.block([[A, B @ B.T], [-(rho**2) * np.eye(len(A)), -A.T]])


def _riccati(A: Array, B: Array, rho: float) -> Array:
    """The stabilising P of A' P + P A + rho^2 I + P B B' P = 0, from the decaying modes of the Hamiltonian matrix."""
    poles, vectors = np.linalg.eig(_hamiltonian(A, B, rho))
    modes = vectors[:, np.argsort(poles.real)[: len(A)]]
    P = np.real(modes[len(A) :] @ np.linalg.inv(modes[: len(A)]))
    return np.asarray((P + P.T) / 2)

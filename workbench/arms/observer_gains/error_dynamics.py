"""The error of an observer with arm, estimate and torque frozen, or where the model adds nothing, and its audit:

    x~' = A0 x~ + [0; I] Delta - L v,    A0 = [[-L1, I], [-L2, 0]],  x~ = (q - q_hat, qd - qd_hat),

with v the noise of the measured positions. Frozen poles may all decay and the error grow, or the reverse.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import expm

from workbench.arms.dynamics import Dynamics
from workbench.arms.observer_gains.decay_certificate import AdmittedErrors, RateCertificate, check
from workbench.arms.observer_gains.gains import Gains, Region
from workbench.arms.observer_gains.inequality import bears_mismatch
from workbench.arms.observer_gains.matrix_inequalities import lyapunov_matrix
from workbench.arms.observer_gains.mismatch import Mismatch, refuse_unfit
from workbench.core.validation.notebook_display import show
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array, positive, vector, whole
from workbench.core.validation.signatures import check_arguments
from workbench.design.linear.feedback_loops import largest_state_gain
from workbench.design.matrices import DesignError, matrix
from workbench.design.riccati import care, lqe, lyapunov
from workbench.proofs.branch_and_bound import sequence

SAMPLES = 20_000
MOST_SAMPLES = 10_000_000
# Instants of a transient in steps of 1 %, from a thousandth of the fastest time constant to ten of the slowest.
INSTANTS = 2000
# How often the share of a region with a P is halved, and the fractions of it of which the first to be proved counts.
HALVINGS, SURE = 6, (1.0, 0.9, 0.8, 0.6)
ROOM = 1e-6  # of a tolerated mismatch, which is given away for the exact check


@dataclass(frozen=True, eq=False)
@show
class FrozenPoles:
    """Poles (N, 2n) in 1/s at N states q, qd, tau of a region, (N, n) each."""

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


@check_arguments
def frozen_poles(mismatch: Mismatch, gains: Gains, q: Array, qd: Array, tau: Array) -> Array:
    """The eigenvalues (N, 2n) of the exact error Jacobian [[-L1, I], [df/dq - L2, df/dqd]] at N states, in 1/s."""
    q, qd, tau = _rows("frozen_poles", mismatch, q, qd, tau)
    return np.asarray(np.linalg.eigvals(gains.error_matrix(mismatch.at(q, qd, tau))))


@check_arguments
def frozen_poles_over(mismatch: Mismatch, gains: Gains, region: Region, samples: int = SAMPLES) -> FrozenPoles:
    """The frozen poles at states spread evenly over a region, which are samples and no bound."""
    whole("over(samples=...)", samples, most=MOST_SAMPLES)
    refuse_unfit("over", mismatch, gains, region)
    n, (low, high) = region.joints, region.box
    u = sequence(samples, 3 * n)
    q = low + u[:, :n] * (high - low)
    qd, tau = (2 * u[:, n : 2 * n] - 1) * region.speed, (2 * u[:, 2 * n :] - 1) * region.torque
    return FrozenPoles(q, qd, tau, frozen_poles(mismatch, gains, q, qd, tau))


@check_arguments
def frozen_poles_along(
    mismatch: Mismatch, gains: Gains, region: Region, q: Array, qd: Array, tau: Array
) -> FrozenPoles:
    """The frozen poles along a path (N, n) of positions, velocities and torques, which must stay in the region."""
    refuse_unfit("along", mismatch, gains, region)
    path = q, qd, tau = _rows("along", mismatch, q, qd, tau)
    gone = (np.abs(qd) > region.speed) | (np.abs(tau) > region.torque)
    if region.low is not None and region.high is not None:
        gone |= (q < region.low) | (q > region.high)
    if gone.any():
        row = int(np.argmax(gone.any(axis=1)))
        state = ", ".join(f"{name} = {part[row].tolist()}" for name, part in zip(("q", "qd", "tau"), path, strict=True))
        raise ValueError(f"`along(q, qd, tau)` must stay in the region; its row {row} leaves it, with {state}.")
    return FrozenPoles(*path, frozen_poles(mismatch, gains, *path))


def _rows(call: str, mismatch: Mismatch, q: Array, qd: Array, tau: Array) -> tuple[Array, Array, Array]:
    path = q, qd, tau
    shapes = [part.shape for part in path]
    if len(set(shapes)) > 1 or q.ndim != 2 or q.shape[1] != mismatch.joints or not len(q):
        raise ValueError(f"`{call}(q, qd, tau)` must be {mismatch.joints} numbers a row each; got shapes {shapes}.")
    if not all(np.isfinite(part).all() for part in path):
        raise ValueError(f"`{call}(q, qd, tau)` must be finite numbers; it holds NaN or infinity.")
    return path


@dataclass(frozen=True)
@show
class Noise:
    """H2 norms from the noise of the positions to the errors: `position` in s^(-1/2), `velocity` in s^(-3/2).

    White noise of spectral density S (rad^2/Hz, two-sided) gives errors of sqrt(S) times these, in rad and rad/s.
    """

    position: float
    velocity: float


@check_arguments
def noise(gains: Gains, J: Array | None = None) -> Noise:
    """The H2 norms from v to q~ and to qd~: the roots of the traces of X, A X + X A' + L L' = 0.

    J is the Jacobian [df/dq, df/dqd] (n, 2n) of a state; where the model adds nothing if not given. `DesignError` if
    the error does not decay there.
    """
    n = gains.joints
    A, L = gains.error_matrix(None if J is None else matrix("noise(J=...)", "J", J, n, 2 * n)), gains.L
    if (slowest := float(np.linalg.eigvals(A).real.max())) >= 0:
        raise DesignError(f"`noise(...)` needs an error that decays; a mode grows here at {slowest:.3g} 1/s.")
    X = lyapunov(A, L @ L.T).X
    return Noise(float(np.sqrt(np.trace(X[:n, :n]))), float(np.sqrt(np.trace(X[n:, n:]))))


@check_arguments
def peaking(gains: Gains) -> float:
    """The worst transient: the greatest |qd~(t)| for qd~(0) = 0 and |q~(0)| = 1 rad, in 1/s, to 1e-4 of itself."""
    n, A = gains.joints, gains.error_matrix()
    poles = np.linalg.eigvals(A)
    t = np.geomspace(1e-3 / np.abs(poles).max(), 10 / -poles.real.max(), INSTANTS)
    part = expm(t[:, None, None] * A)[:, n:, :n]
    return float(np.linalg.norm(part, 2, axis=(1, 2)).max())


@check_arguments
def tolerated_mismatch(gains: Gains) -> tuple[float, Array]:
    """The largest rho such that one P (2n, 2n) proves a decay for every Delta with |Delta| <= rho |x~|, and that P.

    It is 1 / max |[0; I] to x~ at i w| over all frequencies w. P solves
    A0' P + P A0 + rho^2 I + P [0; I] [0; I]' P < 0, which is checked in rational arithmetic: so V = x~' P x~ falls.

    Raises
    ------
    DesignError
        If the check fails.

    References
    ----------
    Rajamani (1998), Observers for Lipschitz nonlinear systems, IEEE Trans. Automatic Control 43.
    """
    n, A = gains.joints, gains.error_matrix()
    B = np.eye(2 * n)[:, n:]
    most = 1 / largest_state_gain(A, B).above
    rho = (1 - 2 * ROOM) * most
    P = -care(A, B, -(((1 - ROOM) * most) ** 2) * np.eye(2 * n), np.eye(n)).X
    if not bears_mismatch(P, A, B, rho):
        raise DesignError("The certificate of the tolerated mismatch fails its check in rational arithmetic.")
    return rho, P


@check_arguments
def kalman(dynamics: Dynamics, q: Numbers, qd: Numbers, tau: Numbers, Qn: Numbers, Rn: Numbers) -> Gains:
    """The steady Kalman gain of the arm linearised at a state, for accelerations and measurements with white noise.

    Parameters
    ----------
    q, qd, tau
        (n,), the state and torque.
    Qn, Rn
        (n, n), the spectral densities of the accelerations that the model lacks, in (rad/s^2)^2 s, and of the noise of
        the positions, in rad^2 s.

    Raises
    ------
    ValueError
        If a vector or matrix is not of its shape, or Rn is not definite.
    """
    n = dynamics.dof
    state = [vector(f"kalman({name}=...)", x, n, "joints")[None] for name, x in (("q", q), ("qd", qd), ("tau", tau))]
    A = np.vstack([np.eye(n, 2 * n, n), Mismatch.of(dynamics).at(*state)[0]])
    L = lqe(A, np.eye(2 * n)[:, n:], np.eye(n, 2 * n), Qn, Rn).K
    return Gains(L[:n], L[n:])


@dataclass(frozen=True, eq=False)
@show
class Audit:
    """The sampled poles and the proved decay of a set of gains in a region.

    The certificate proves a decay at the asked rate in the region with its speeds and torques times `share`: 1 where
    the whole region is certified; None, with no certificate, where nothing was, and `why` says so. `admitted_errors`
    are the initial errors admitted while the arm keeps the inner region, of the same share. Every Delta with |Delta|
    <= `tolerated_mismatch` |x~| is proved to let the error decay. `noise` and `peaking` hold for a model without terms.
    """

    gains: Gains
    frozen_poles: FrozenPoles
    certificate: RateCertificate | None
    share: float | None
    admitted_errors: AdmittedErrors | None
    tolerated_mismatch: float
    noise: Noise
    peaking: float
    why: str


@check_arguments
def audit(
    dynamics: Dynamics,
    gains: Gains,
    region: Region,
    inner: float,
    rate: float,
    known_certificate: RateCertificate | None = None,
) -> Audit:
    """Judge the gains L1, L2 of an observer of this arm in a region.

    Parameters
    ----------
    inner
        The share of the region's speeds that the arm itself keeps; the rest is room for the estimate's error.
    rate
        The decay in 1/s that is to be proved, in the whole region or else in as large a share of it as can be.
    known_certificate
        The certificate of these gains in the whole region, whose P is proved again; else one is sought (extra `lmi`).

    Raises
    ------
    ValueError
        If sizes differ, a number is out of its range, or `known_certificate` is the certificate of something else.
    DesignError
        If the P of `known_certificate` is not proved here.

    Examples
    --------
    >>> from workbench.arms.dynamics import Dynamics
    >>> from workbench.arms.observer_gains import Region, audit, by_poles
    >>> arm, region = Dynamics.of(wb.robot("planar-1r")), Region([3.0], [7.0])
    >>> audit(arm, by_poles(1, -40.0, -40.0), region, 0.5, 1.0).gains
    Gains(L1=[[80]], L2=[[1600]])
    """
    positive("audit(rate=...)", rate, " of 1/s")
    if not 0 < positive("audit(inner=...)", inner) < 1:
        raise ValueError(f"`audit(inner=...)` is a share, so it lies between 0 and 1; got {inner}.")
    known = known_certificate
    if known is not None and (known.gains is not gains or known.region is not region or known.rate != rate):
        raise ValueError(
            "`audit(known_certificate=...)` must be the certificate of these gains, in this region, of this rate."
        )
    mismatch = Mismatch.of(dynamics)
    seen = frozen_poles_over(mismatch, gains, region)
    certificate, share, why = (
        (check(mismatch, gains, region, known.P, rate), 1.0, "")
        if known
        else _largest_certificate(mismatch, gains, region, rate)
    )
    admitted = None
    if certificate is not None:
        admitted = certificate.admitted_errors(replace(certificate.region, speed=inner * certificate.region.speed))
    tolerated, _ = tolerated_mismatch(gains)
    return Audit(gains, seen, certificate, share, admitted, tolerated, noise(gains), peaking(gains), why)


def _largest_certificate(
    mismatch: Mismatch, gains: Gains, region: Region, rate: float
) -> tuple[RateCertificate | None, float | None, str]:
    """A certificate in the whole region, or in the largest share of it that halving finds."""
    try:
        return check(mismatch, gains, region, lyapunov_matrix(mismatch, gains, region, rate), rate), 1.0, ""
    except DesignError as none:
        why = str(none)
    low, high = 0.0, 1.0
    for _ in range(HALVINGS):
        share = (low + high) / 2 if low else high / 4
        try:
            lyapunov_matrix(mismatch, gains, region.scale(share), rate)
            low = share
        except DesignError:
            high = share
    for part in SURE if low else ():
        smaller = region.scale(part * low)
        try:
            P = lyapunov_matrix(mismatch, gains, smaller, rate)
            return check(mismatch, gains, smaller, P, rate), part * low, ""
        except DesignError as none:
            why = str(none)
    return None, None, why

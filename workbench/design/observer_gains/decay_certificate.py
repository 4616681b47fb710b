"""The proof that an observer's error decays in a region, and the audit of one set of gains:

    V = x~' P x~,    V' <= -2 rate V    as long as the arm and its estimate stay in the region.

It holds if P A + A' P + 2 rate P < 0 for the error's matrix A = [[-L1, I], [-L2, 0] + J] at all Jacobians J of the
region: these are convex inequalities, so they hold for means of such J, and the mismatch is one times the error.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.core import Dynamics
from workbench.design.matrices import Refused, symmetric
from workbench.design.observer_gains.error_dynamics import Frozen, Noise, noise, over, peaking, tolerated
from workbench.design.observer_gains.gains import Gains, Region
from workbench.design.observer_gains.inequality import Inequality, exactly_definite, prove
from workbench.design.observer_gains.matrix_inequalities import lyapunov_matrix
from workbench.design.observer_gains.mismatch import Mismatch, refuse_unfit
from workbench.validation.refusals import Array, positive
from workbench.validation.signatures import door
from workbench.validation.views import show

# How often the share of a region with a P is halved, and the fractions of it of which the first to be proved counts.
HALVINGS, SURE = 6, (1.0, 0.9, 0.8, 0.6)


@dataclass(frozen=True, eq=False)
@show
class Reach:
    """The initial errors that are admitted: x~' P x~ <= level; with qd~ = 0 or q~ = 0 of these sizes, in rad and rad/s.

    `peaking` bounds |qd~(t)| / |q~(0)| for qd~(0) = 0, in 1/s.
    """

    level: float
    position: float
    velocity: float
    peaking: float


@dataclass(frozen=True, eq=False)
@show
class RateCertificate:
    """V = x~' P x~ falls at least as exp(-2 rate t), in 1/s, while arm and estimate stay in the region: proved.

    P is (2n, 2n) and symmetric; the proof took so many `boxes` of positions.
    """

    gains: Gains
    region: Region
    P: Array
    rate: float
    boxes: int

    @door
    def reach(self, arm: Region) -> Reach:
        """The initial errors with which the estimate stays in the region while the arm stays in `arm`, inside it."""
        room = self._room(arm)
        inverse = np.linalg.inv(self.P)
        n, bounded = self.gains.joints, np.isfinite(room)
        level = float((room[bounded] ** 2 / np.diag(inverse)[bounded]).min())
        largest = [float(np.linalg.eigvalsh(part)[-1]) for part in (self.P[:n, :n], self.P[n:, n:], inverse[n:, n:])]
        position, velocity = (float(np.sqrt(level / value)) for value in largest[:2])
        return Reach(level, position, velocity, float(np.sqrt(largest[0] * largest[2])))

    def _room(self, arm: Region) -> Array:
        """The room of the estimate in each state, (2n,)."""
        mine, whose = self.region, arm
        if whose.joints != mine.joints:
            raise ValueError(
                f"`reach(arm)` must be for the {mine.joints} joints of the certificate; got {whose.joints}."
            )
        room = np.full(2 * self.gains.joints, np.inf)
        room[self.gains.joints :] = mine.speed - whose.speed
        if mine.low is not None and mine.high is not None:
            if whose.low is None or whose.high is None:
                raise ValueError("`reach(arm)` must lie in the certificate's region, which bounds the positions.")
            room[: self.gains.joints] = np.minimum(whose.low - mine.low, mine.high - whose.high)
        if (whose.torque > mine.torque).any() or not (room > 0).all():
            raise ValueError(
                "`reach(arm)` must lie inside the certificate's region, with room for the estimate's error in every "
                f"speed and bounded position; it leaves {room.tolist()} rad, rad/s, at torques {whose.torque.tolist()} "
                "N m."
            )
        return room


@door
def check(mismatch: Mismatch, gains: Gains, region: Region, P: Array, rate: float) -> RateCertificate:
    """Prove that P is a certificate of a rate in a region.

    P > 0 is decided by its leading minors in rational arithmetic, the inequality by intervals of the exact Jacobian.

    Raises
    ------
    ValueError
        If the sizes differ, the rate is not positive, or any position is allowed to equations that do not repeat.
    Refused
        If P is not positive definite, or the inequality is not proved.
    """
    P = symmetric("check", "P", P, 2 * gains.joints)
    positive("check(rate=...)", rate, " of 1/s")
    refuse_unfit("check", mismatch, gains, region)
    if not exactly_definite(P):
        raise Refused("The certificate's P is not positive definite: a leading minor is not positive, exactly.")
    boxes = prove(_inequality(gains, P, rate, mismatch, region), mismatch, region, f"A decay at {rate:.4g} 1/s")
    return RateCertificate(gains, region, P, rate, boxes)


def _inequality(gains: Gains, P: Array, rate: float, mismatch: Mismatch, region: Region) -> Inequality:
    """-(P A + A' P + 2 rate P) > 0 in coordinates W in which it is near I at the mean of the region."""
    n, A0 = gains.joints, gains.error_matrix()
    held = P @ A0
    Z0, F = -(held + held.T + 2 * rate * P), -P[:, n:]
    low, high = region.box
    middle, still = ((low + high) / 2)[None], np.zeros((1, n))
    part = F @ mismatch.at(middle, still, still)[0]
    values, U = np.linalg.eigh(Z0 + part + part.T)
    W = U / np.sqrt(np.maximum(values, 1e-6 * np.abs(values).max()))
    grown = np.abs(P) @ (np.abs(A0) + abs(rate) * np.eye(2 * n))
    size = np.abs(W).T @ (grown + grown.T) @ np.abs(W)
    return Inequality(W.T @ Z0 @ W, W.T @ F, W, size)


@dataclass(frozen=True, eq=False)
@show
class Audit:
    """The sampled poles and the proved decay of a set of gains in a region.

    Parameters
    ----------
    frozen
        The poles with state and torque frozen: seen.
    certificate
        A proof of a decay at the asked rate, in the region with its speeds and torques times `share`.
    share
        1 where the whole region is certified; None, with no certificate, where nothing was, and `why` says so.
    reach
        The initial errors that are admitted while the arm keeps the inner region, of the same share.
    tolerated
        The largest rho such that every Delta with |Delta| <= rho |x~| is proved to let the error decay.
    noise, peaking
        Where the model adds nothing.
    """

    gains: Gains
    frozen: Frozen
    certificate: RateCertificate | None
    share: float | None
    reach: Reach | None
    tolerated: float
    noise: Noise
    peaking: float
    why: str


@door
def audit(
    dynamics: Dynamics, gains: Gains, region: Region, inner: float, rate: float, known: RateCertificate | None = None
) -> Audit:
    """Judge the gains L1, L2 of an observer of this arm in a region.

    Parameters
    ----------
    inner
        The share of the region's speeds that the arm itself keeps; the rest is room for the estimate's error.
    rate
        The decay in 1/s that is to be proved, in the whole region or else in as large a share of it as can be.
    known
        The certificate of these gains in the whole region, if there is one, whose P is proved again; else one is sought
        (extra `lmi`).

    Raises
    ------
    ValueError
        If sizes differ, a number is out of its range, or `known` is the certificate of something else.
    Refused
        If the P of `known` is not proved here.
    """
    positive("audit(rate=...)", rate, " of 1/s")
    if not 0 < positive("audit(inner=...)", inner) < 1:
        raise ValueError(f"`audit(inner=...)` is a share, so it lies between 0 and 1; got {inner}.")
    if known is not None and (known.gains is not gains or known.region is not region or known.rate != rate):
        raise ValueError("`audit(known=...)` must be the certificate of these gains, in this region, of this rate.")
    mismatch = Mismatch.of(dynamics)
    seen = over(mismatch, gains, region)
    certificate, share, why = (
        (check(mismatch, gains, region, known.P, rate), 1.0, "") if known else _certified(mismatch, gains, region, rate)
    )
    reach = None
    if certificate is not None:
        whole = certificate.region
        reach = certificate.reach(Region(inner * whole.speed, whole.torque, whole.low, whole.high))
    return Audit(gains, seen, certificate, share, reach, tolerated(gains)[0], noise(gains), peaking(gains), why)


def _certified(
    mismatch: Mismatch, gains: Gains, region: Region, rate: float
) -> tuple[RateCertificate | None, float | None, str]:
    """A certificate in the whole region, or in the largest share of it that halving finds."""
    try:
        return check(mismatch, gains, region, lyapunov_matrix(mismatch, gains, region, rate), rate), 1.0, ""
    except Refused as none:
        why = str(none)
    low, high = 0.0, 1.0
    for _ in range(HALVINGS):
        share = (low + high) / 2 if low else high / 4
        try:
            lyapunov_matrix(mismatch, gains, region.scaled(share), rate)
        except Refused:
            high = share
        else:
            low = share
    for part in SURE if low else ():
        smaller = region.scaled(part * low)
        try:
            found = check(mismatch, gains, smaller, lyapunov_matrix(mismatch, gains, smaller, rate), rate)
        except Refused as none:
            why = str(none)
        else:
            return found, part * low, ""
    return None, None, why

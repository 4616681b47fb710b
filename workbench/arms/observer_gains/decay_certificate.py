"""The proof that an observer's error decays in a region, and gains that come with one:

    V = x~' P x~,    V' <= -2 rate V    as long as the arm and its estimate stay in the region.

It holds if P A + A' P + 2 rate P < 0 for the error's matrix A = [[-L1, I], [-L2, 0] + J] at all Jacobians J of the
region: these are convex inequalities, so they hold for means of such J, and the mismatch is one times the error.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.arms.dynamics import Dynamics
from workbench.arms.observer_gains.gains import Gains, Region, by_poles
from workbench.arms.observer_gains.inequality import Inequality, exactly_definite, prove
from workbench.arms.observer_gains.matrix_inequalities import least_noise, lyapunov_matrix, solvers
from workbench.arms.observer_gains.mismatch import Mismatch, refuse_unfit
from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array, positive, require
from workbench.core.validation.signatures import check_arguments
from workbench.design.matrices import DesignError, symmetric

# The least double pole is found to this factor, and sought up to so many times the rate.
FINE, FARTHEST = 1.05, 1000.0


@dataclass(frozen=True, eq=False)
@show
class AdmittedErrors:
    """The initial errors from which the estimate stays in the region: all with x~' P x~ <= `level`.

    For qd~ = 0 these are all |q~| <= `position` (rad), and for q~ = 0 all |qd~| <= `velocity` (rad/s). `peaking` bounds
    |qd~(t)| / |q~(0)| for qd~(0) = 0, in 1/s.
    """

    level: float
    position: float
    velocity: float
    peaking: float


@dataclass(frozen=True, eq=False)
@show
class RateCertificate:
    """A proof that V = x~' P x~ falls at least as exp(-2 rate t) while arm and estimate stay in the region.

    `rate` is in 1/s. P is (2n, 2n) and symmetric. `boxes` is the number of boxes of positions that the proof took.
    """

    gains: Gains
    region: Region
    P: Array
    rate: float
    boxes: int

    @check_arguments
    def admitted_errors(self, arm: Region) -> AdmittedErrors:
        """The initial errors with which the estimate stays in the region while the arm stays in `arm`, inside it."""
        room = self._room(arm)
        inverse = np.linalg.inv(self.P)
        n, bounded = self.gains.joints, np.isfinite(room)
        level = float((room[bounded] ** 2 / np.diag(inverse)[bounded]).min())
        largest = [float(np.linalg.eigvalsh(part)[-1]) for part in (self.P[:n, :n], self.P[n:, n:], inverse[n:, n:])]
        position, velocity = (float(np.sqrt(level / value)) for value in largest[:2])
        return AdmittedErrors(level, position, velocity, float(np.sqrt(largest[0] * largest[2])))

    def _room(self, arm: Region) -> Array:
        """The room of the estimate in each state, (2n,)."""
        mine, whose = self.region, arm
        if whose.joints != mine.joints:
            raise ValueError(
                f"`admitted_errors(arm)` must be for the {mine.joints} joints of the certificate; got {whose.joints}."
            )
        room = np.full(2 * self.gains.joints, np.inf)
        room[self.gains.joints :] = mine.speed - whose.speed
        if mine.low is not None and mine.high is not None:
            if whose.low is None or whose.high is None:
                raise ValueError(
                    "`admitted_errors(arm)` must lie in the certificate's region, which bounds the positions."
                )
            room[: self.gains.joints] = np.minimum(whose.low - mine.low, mine.high - whose.high)
        if (whose.torque > mine.torque).any() or not (room > 0).all():
            raise ValueError(
                "`admitted_errors(arm)` must lie inside the certificate's region, with room for the estimate's error "
                f"in every speed and bounded position; it leaves {room.tolist()} rad, rad/s, at torques "
                f"{whose.torque.tolist()} N m."
            )
        return room


@check_arguments
def check(mismatch: Mismatch, gains: Gains, region: Region, P: Array, rate: float) -> RateCertificate:
    """Prove that P is a certificate of a rate in a region.

    P > 0 is decided by its leading minors in rational arithmetic, the inequality by intervals of the exact Jacobian.

    Raises
    ------
    ValueError
        If the sizes differ, the rate is not positive, or any position is allowed to equations that do not repeat.
    DesignError
        If P is not positive definite, or the inequality is not proved.
    """
    P = symmetric("check", "P", P, 2 * gains.joints)
    positive("check(rate=...)", rate, " of 1/s")
    refuse_unfit("check", mismatch, gains, region)
    if not exactly_definite(P):
        raise DesignError("The certificate's P is not positive definite: a leading minor is not positive, exactly.")
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


@check_arguments
def by_lmi(dynamics: Dynamics, region: Region, rate: float) -> RateCertificate:
    """The gains with the least bound of noise of all that share one P for a rate in a region (extra `lmi`).

    Raises
    ------
    DesignError
        If there are none, the proof fails, or the extra is not installed.

    Examples
    --------
    >>> from workbench.arms.dynamics import Dynamics
    >>> from workbench.arms.observer_gains import Region, by_lmi
    >>> arm = Dynamics.of(wb.robot("planar-1r"))
    >>> by_lmi(arm, Region([3.0], [7.0]), 1.0).gains.L1.shape
    (1, 1)
    """
    positive("by_lmi(rate=...)", rate, " of 1/s")
    mismatch = Mismatch.of(dynamics)
    gains, P = least_noise(mismatch, region, rate)
    return check(mismatch, gains, region, P, rate)


@check_arguments
def least_double_pole(dynamics: Dynamics, region: Region, rate: float) -> RateCertificate:
    """L1 = 2 p I, L2 = p^2 I with the least p, to some percent, that is certified a rate in a region (extra `lmi`).

    Raises
    ------
    DesignError
        If no p up to a thousand times the rate is, or the extra is not installed.

    Examples
    --------
    >>> from workbench.arms.dynamics import Dynamics
    >>> from workbench.arms.observer_gains import Region, least_double_pole
    >>> arm = Dynamics.of(wb.robot("planar-1r"))
    >>> least_double_pole(arm, Region([3.0], [7.0]), 1.0)
    RateCertificate(gains=Gains(...), region=Region(speed=[3], torque=[7]), P=<2 x 2>, rate=1, boxes=15)
    """
    solvers("least_double_pole")
    mismatch, low = Mismatch.of(dynamics), positive("least_double_pole(rate=...)", rate, " of 1/s")
    p = low
    while not _has_proposal(mismatch, region, rate, p):
        low, p = p, 2 * p
    while p > FINE * low:
        middle = float(np.sqrt(low * p))
        low, p = (low, middle) if _has_proposal(mismatch, region, rate, middle) else (middle, p)
    while True:
        gains = by_poles(mismatch.joints, -p, -p)
        try:
            return check(mismatch, gains, region, lyapunov_matrix(mismatch, gains, region, rate), rate)
        except DesignError:
            p = _bound_pole(FINE * p, rate)


def _has_proposal(mismatch: Mismatch, region: Region, rate: float, p: float) -> bool:
    """True if a P is found for the double pole -p."""
    try:
        lyapunov_matrix(mismatch, by_poles(mismatch.joints, -_bound_pole(p, rate), -p), region, rate)
    except DesignError:
        return False
    return True


def _bound_pole(p: float, rate: float) -> float:
    if p > FARTHEST * rate:
        raise ValueError(f"No double pole up to {FARTHEST:g} times the rate of {rate:g} 1/s is certified there.")
    return p


@check_arguments
def certify(dynamics: Dynamics, gains: Gains, region: Region, rate: float) -> RateCertificate:
    """A certificate that the error of given gains decays at a rate in a region; refusals are those of `by_lmi`.

    Examples
    --------
    >>> from workbench.arms.dynamics import Dynamics
    >>> from workbench.arms.observer_gains import Gains, Region, certify
    >>> arm = Dynamics.of(wb.robot("planar-1r"))
    >>> certify(arm, Gains(np.array([[80.0]]), np.array([[1600.0]])), Region([3.0], [7.0]), 1.0).rate
    1.0
    """
    require("certify(region=...)", region, Region)
    positive("certify(rate=...)", rate, " of 1/s")
    mismatch = Mismatch.of(dynamics)
    return check(mismatch, gains, region, lyapunov_matrix(mismatch, gains, region, rate), rate)

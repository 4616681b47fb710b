r"""The promise that an observer's error decays in a region, and its proof:

    V = x~' P x~,    V' <= -2 rate V    as long as the arm and its estimate stay in the region.

It holds if P A + A' P + 2 rate P < 0 for the error's matrix A = [[-L1, I], [-L2, 0] + J] at all Jacobians J of the
region: these are convex inequalities, so they hold for means of such J, and the mismatch is one times the error.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.design.certificates import Refused
from workbench.design.matrices import symmetric
from workbench.design.observer_gains.exactly import definite
from workbench.design.observer_gains.gains import Gains
from workbench.design.observer_gains.inequality import Inequality, prove
from workbench.design.observer_gains.mismatch import Mismatch
from workbench.design.observer_gains.region import Region
from workbench.validation.refusals import Array, positive
from workbench.validation.signatures import door
from workbench.validation.views import show


@dataclass(frozen=True, eq=False)
@show
class Reach:
    """Which initial errors are admitted: x~' P x~ <= level; with qd~ = 0 or q~ = 0 those of these sizes, in rad, rad/s.

    `peaking` bounds |qd~(t)| / |q~(0)| for qd~(0) = 0, in 1/s.
    """

    level: float
    position: float
    velocity: float
    peaking: float


@dataclass(frozen=True, eq=False)
@show
class RateCertificate:
    """V = x~' P x~ falls at least as exp(-2 rate t) while arm and estimate stay in the region: proved.

    Parameters
    ----------
    P
        (2n, 2n), symmetric.
    rate
        In 1/s.
    boxes
        How many boxes of positions the proof took.
    """

    gains: Gains
    region: Region
    P: Array
    rate: float
    boxes: int

    @door
    def reach(self, arm: Region) -> Reach:
        """The initial errors with which the estimate stays in the certificate's region while the arm stays in `arm`.

        Raises
        ------
        ValueError
            If `arm` does not lie within the region, or leaves the estimate no room.
        """
        room = self._room(arm)
        inverse = np.linalg.inv(self.P)
        n, bounded = self.gains.joints, np.isfinite(room)
        level = float((room[bounded] ** 2 / np.diag(inverse)[bounded]).min())
        largest = [float(np.linalg.eigvalsh(part)[-1]) for part in (self.P[:n, :n], self.P[n:, n:], inverse[n:, n:])]
        position, velocity = (float(np.sqrt(level / value)) for value in largest[:2])
        return Reach(level, position, velocity, float(np.sqrt(largest[0] * largest[2])))

    def _room(self, arm: Region) -> Array:
        """How far the estimate may be off in each state, (2n,)."""
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
    """Prove that P is a certificate of a rate in a region, whoever proposed it.

    P > 0 is decided by its leading minors in rational arithmetic, the inequality by intervals of the exact Jacobian.

    Raises
    ------
    ValueError
        If the sizes differ, the rate is not positive, or any position is allowed to equations that do not repeat
        after a turn.
    Refused
        If P is not positive definite, or the inequality is not proved.
    """
    P = symmetric("check", "P", P, 2 * gains.joints)
    positive("check(rate=...)", rate, " of 1/s")
    refuse_unfit("check", mismatch, gains, region)
    if not definite(P):
        raise Refused("The certificate's P is not positive definite: a leading minor is not positive, exactly.")
    boxes = prove(_inequality(gains, P, rate, mismatch, region), mismatch, region, f"A decay at {rate:.4g} 1/s")
    return RateCertificate(gains, region, P, rate, boxes)


def refuse_unfit(call: str, mismatch: Mismatch, gains: Gains | None, region: Region) -> None:
    """Refuse gains and regions of other arms, and any position where the equations do not repeat after a turn."""
    sizes = {mismatch.joints, region.joints} | ({gains.joints} if gains is not None else set())
    if len(sizes) > 1:
        raise ValueError(
            f"`{call}(...)` needs gains and a region for the {mismatch.joints} joints of the arm; got "
            f"{region.joints} in the region{f' and {gains.joints} in the gains' if gains is not None else ''}."
        )
    if region.low is None and not mismatch.periodic:
        raise ValueError(
            f"`{call}(region=...)` must bound the positions by `low` and `high`: that these equations repeat after a "
            "turn is not proved."
        )


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

"""Where an arm and its estimate may be: a box of positions, speeds and torques."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.validation.refusals import Array, described, finite
from workbench.validation.signatures import door

MOST_SHARE = 1e6  # of speeds and torques


@dataclass(frozen=True, eq=False)
@door
class Region:
    """low <= q <= high, |qd| <= speed, |tau| <= torque, joint by joint; any position where `low` and `high` are None.

    Parameters
    ----------
    speed
        (n,), in rad/s: of the arm and of its estimate.
    torque
        (n,), in N m.
    low, high
        (n,), in rad.

    Raises
    ------
    ValueError
        If they are no vectors of one length, a number is not finite or negative, or a box is none.
    """

    speed: Array
    torque: Array
    low: Array | None = None
    high: Array | None = None

    def __post_init__(self) -> None:
        given = {name: getattr(self, name) for name in ("speed", "torque", "low", "high")}
        if (given["low"] is None) != (given["high"] is None):
            raise ValueError("`Region(low=..., high=...)` must give both sides of the box of positions, or none.")
        for name, value in given.items():
            if value is not None:
                object.__setattr__(self, name, _vector(name, value, np.size(self.speed)))
        for name in ("speed", "torque"):
            if (getattr(self, name) < 0).any():
                size = described(getattr(self, name).tolist())
                raise ValueError(f"`Region({name}=...)` bounds a size, so it must not be negative; got {size}.")
        if self.low is not None and self.high is not None and not (self.low < self.high).all():
            low, high = (described(end.tolist()) for end in (self.low, self.high))
            raise ValueError(f"`Region(low=..., high=...)` must be a box, low < high; got {low} and {high}.")

    @property
    def joints(self) -> int:
        """The number of joints n."""
        return len(self.speed)

    @property
    def box(self) -> tuple[Array, Array]:
        """Both sides of the positions, (n,) each; a whole turn for any position."""
        if self.low is None or self.high is None:
            return np.full(self.joints, -np.pi), np.full(self.joints, np.pi)
        return self.low, self.high

    @door
    def scaled(self, share: float) -> Region:
        """The region with its speeds and torques times a share, and its positions as they are."""
        share = finite("scaled(share=...)", share, low=0, high=MOST_SHARE)
        return Region(share * self.speed, share * self.torque, self.low, self.high)

    @door
    def outside(self, q: Array, qd: Array, tau: Array) -> Array:
        """Which of N states and torques, (N, n) each, are not in it, (N,)."""
        if not q.shape == qd.shape == tau.shape == (len(np.atleast_1d(q)), self.joints):
            shapes = f"{q.shape}, {qd.shape} and {tau.shape}"
            raise ValueError(f"`outside(q, qd, tau)` must be N rows of {self.joints} numbers each; got {shapes}.")
        low, high = self.box
        beyond = (np.abs(qd) > self.speed) | (np.abs(tau) > self.torque)
        if self.low is not None:
            beyond |= (q < low) | (q > high)
        return np.asarray(beyond.any(axis=1))


def _vector(name: str, given: Array, size: int) -> Array:
    value = given.copy()
    if value.shape != (size,) or not size or not np.isfinite(value).all():
        must = "one finite number a joint, as `speed` does"
        raise ValueError(f"`Region({name}=...)` must hold {must}; got {described(value.tolist())}.")
    value.flags.writeable = False
    return value

"""Where an arm and its estimate may be: a box of positions, speeds and torques."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from workbench.core.layout import Array, numbers


@dataclass(frozen=True, eq=False)
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
                raise ValueError(f"`Region({name}=...)` bounds a size, so it must not be negative; got {given[name]}.")
        if self.low is not None and self.high is not None and not (self.low < self.high).all():
            raise ValueError(f"`Region(low=..., high=...)` must be a box, low < high; got {self.low} and {self.high}.")

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

    def scaled(self, share: float) -> Region:
        """The region with its speeds and torques times a share, and its positions as they are."""
        return Region(share * self.speed, share * self.torque, self.low, self.high)

    def outside(self, q: Array, qd: Array, tau: Array) -> Array:
        """Which of N states and torques, (N, n) each, are not in it, (N,)."""
        low, high = self.box
        beyond = (np.abs(qd) > self.speed) | (np.abs(tau) > self.torque)
        if self.low is not None:
            beyond |= (q < low) | (q > high)
        return np.asarray(beyond.any(axis=1))


def _vector(name: str, given: Any, size: int) -> Array:
    try:
        value = numbers(given)
    except (TypeError, ValueError):
        raise ValueError(f"`Region({name}=...)` must be a vector of numbers; got {given!r}.") from None
    if value.shape != (size,) or not size or not np.isfinite(value).all():
        raise ValueError(f"`Region({name}=...)` must hold one finite number a joint, as `speed` does; got {given!r}.")
    value.flags.writeable = False
    return value

"""How far a joint may go, how fast it may move and how hard its motor may push, where a robot says so."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from workbench.validation.refusals import Array, numbers
from workbench.validation.signatures import door

Numbers = tuple[float | None, ...]


@dataclass(frozen=True)
@door
class JointLimits:
    """The limits of one joint; None where there is none.

    Attributes
    ----------
    lower, upper
        Of its position, in rad or m.
    velocity
        Of its speed either way, in rad/s or m/s.
    effort
        Of its torque or force either way, in N m or N.
    """

    lower: float | None = None
    upper: float | None = None
    velocity: float | None = None
    effort: float | None = None

    def __post_init__(self) -> None:
        for name in ("velocity", "effort"):
            if (value := getattr(self, name)) is not None and not 0 <= value < np.inf:
                raise ValueError(
                    f"`JointLimits({name}=...)` must be finite and not negative, as it holds either way; got {value:g}."
                )
        low, high = (-np.inf if self.lower is None else self.lower), (np.inf if self.upper is None else self.upper)
        if not low <= high:
            raise ValueError(f"`JointLimits(lower=..., upper=...)` must have lower <= upper; got {low:g} and {high:g}.")


NO_LIMITS = JointLimits()


@dataclass(frozen=True)
@door
class Limits:
    """The limits of an arm, a number for each joint in order; None where there is none.

    The equations of motion know nothing of them: the efforts are for the actuator, positions and speeds for checks.
    """

    lower: Numbers
    upper: Numbers
    velocity: Numbers
    effort: Numbers

    @staticmethod
    @door
    def of(joints: Sequence[JointLimits]) -> Limits:
        """The limits of joints in order."""
        return Limits(*(tuple(getattr(joint, f.name) for joint in joints) for f in fields(Limits)))

    @door
    def exceeded(self, q: Any, qd: Any) -> np.ndarray[Any, np.dtype[np.bool_]]:
        """Whether each joint is beyond a limit of position or speed, (..., n), where q and qd are (..., n).

        What is no number, as in a run that diverges, is beyond.

        Raises
        ------
        ValueError
            If q or qd does not end on an axis with a number for each joint, or they differ in shape.
        """
        position, speed, n = (
            numbers("Limits.exceeded(q=...)", q),
            numbers("Limits.exceeded(qd=...)", qd),
            len(self.lower),
        )
        if position.shape != speed.shape or position.shape[-1:] != (n,):
            raise ValueError(
                f"`Limits.exceeded(q, qd)` takes arrays of one shape that ends with the {n} joints; got "
                f"{position.shape} and {speed.shape}."
            )
        low, high, fast = _filled(self.lower, -np.inf), _filled(self.upper, np.inf), _filled(self.velocity, np.inf)
        return np.asarray(~((low <= position) & (position <= high) & (np.abs(speed) <= fast)))


def _filled(limits: Numbers, free: float) -> Array:
    """The limits as an array, and `free` where there is none."""
    return np.array([free if limit is None else limit for limit in limits])

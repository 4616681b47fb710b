"""The rests of all draws of a box as one branch that moves evenly: tubes over parts of the box, joined at their faces.

Within a tube there is one rest for each draw of its part (see `loop_family.py`), which depends smoothly on the draw.
Where the rest at the middle of a face between two parts lies in the tubes of both, their rests are one branch.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.linear.switching_functions import Mask
from workbench.proofs.enclosures import UNIT

MOST_TUBES = 64


@dataclass(frozen=True, eq=False)
class RestTube:
    """The states x + G (theta - theta_c) + e with |e| <= E, among which there is one rest for each draw of a box."""

    theta: Array
    r: Array
    x: Array
    G: Array
    E: Array

    def covers(self, theta: Array) -> Mask:
        """True for each draw (b, d) of its part."""
        return np.asarray((np.abs(theta - self.theta) <= self.r).all(axis=1))

    def holds(self, theta: Array, x: Array, doubt: Array) -> Mask:
        """True for each draw (b, d) whose states (b, n), within a doubt (b, n), lie in the tube."""
        away = np.abs(x - self.x - (theta - self.theta) @ self.G.T)
        return np.asarray((away * (1 + 64 * UNIT) + 64 * UNIT * np.abs(x) + doubt <= self.E).all(axis=1))


Maker = Callable[[Array, Array, float], RestTube | None]


@dataclass(frozen=True, eq=False)
class RestBranch:
    """One branch of rests over a box, by the tubes of its parts."""

    tubes: tuple[RestTube, ...]

    @staticmethod
    def over(tube: Maker, theta: Array, r: Array, room: float, least: float) -> RestBranch | None:
        """The branch over |theta - theta_c| <= r, (d,) each, halved where it must be; None if it is not proved.

        `tube` makes that of a box with the least E that it is given, `room` for a part and `least` for a single draw.
        """
        budget = [MOST_TUBES]

        def cover(middle: Array, half: Array) -> list[RestTube] | None:
            if not budget[0]:
                return None
            budget[0] -= 1
            whole = tube(middle, half, room)
            if whole is not None:
                return [whole]
            k = int(np.argmax(half / r))
            step = np.zeros_like(half)
            step[k] = half[k] / 2
            inner = half - step * (1 - 8 * UNIT) + 8 * UNIT * np.abs(middle) * (step > 0)
            left, right = cover(middle - step, inner), cover(middle + step, inner)
            if left is None or right is None or not _are_joined(tube(middle, 0 * half, least), left, right):
                return None
            return left + right

        found = cover(theta, r)
        return None if found is None else RestBranch(tuple(found))

    def holds(self, theta: Array, x: Array, doubt: Array) -> Mask:
        """True for each draw (b, d) whose states (b, n), within a doubt (b, n), lie on the branch."""
        return np.asarray(
            np.any([one.covers(theta) & one.holds(theta, x, doubt) for one in self.tubes], axis=0), dtype=bool
        )


def _are_joined(face: RestTube | None, left: list[RestTube], right: list[RestTube]) -> bool:
    """True if the rest at one draw lies in a tube of either side."""
    if face is None:
        return False
    own = face.theta[np.newaxis], face.x[np.newaxis], face.E[np.newaxis]
    return all(any(bool((one.covers(own[0]) & one.holds(*own))[0]) for one in side) for side in (left, right))

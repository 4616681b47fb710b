"""What passes between the blocks of a loop."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import casadi as ca

# The memory of a block, or its rate: a name for each quantity.
Parts = Mapping[str, ca.SX]


class Motion(NamedTuple):
    """A wanted motion: positions in rad, with their first and second derivative, each (n, 1)."""

    q: ca.SX
    qd: ca.SX
    qdd: ca.SX


class Measurement(NamedTuple):
    """What the instruments say: positions in rad and velocities in rad/s, each (n, 1).

    `d` is the true disturbance in N m. No instrument gives it, and the loop hands it only to blocks that
    declare `uses_truth`; to all others it is None.
    """

    q: ca.SX
    qd: ca.SX
    d: ca.SX | None


class Estimate(NamedTuple):
    """What the observer believes: positions, velocities, and the disturbance in N m, each (n, 1)."""

    q: ca.SX
    qd: ca.SX
    d: ca.SX

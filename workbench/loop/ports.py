"""What passes between the blocks of a loop."""

from __future__ import annotations

from typing import NamedTuple

from workbench.validation.shapes import Column, Memory

# The memory of a block, or its rate: a name for each quantity.
Parts = Memory


class Motion(NamedTuple):
    """A wanted motion: positions in rad, with their first and second derivative, each (n, 1)."""

    q: Column
    qd: Column
    qdd: Column


class Measurement(NamedTuple):
    """What the instruments say: positions in rad and velocities in rad/s, each (n, 1).

    `d` is the true disturbance in N m. No instrument gives it, and the loop hands it only to blocks that
    declare `uses_truth`; to all others it is None.
    """

    q: Column
    qd: Column
    d: Column | None


class Estimate(NamedTuple):
    """What the observer believes: positions, velocities, and the disturbance in N m, each (n, 1)."""

    q: Column
    qd: Column
    d: Column

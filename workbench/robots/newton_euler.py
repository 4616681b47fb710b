"""The recursion of Newton and Euler: motions from the base outward, forces back from the ends.

References
----------
Featherstone (2008), Rigid Body Dynamics Algorithms, section 5.3 (table 5.1, body coordinates).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import casadi as ca

from workbench.robots.motion import cross


class Body(NamedTuple):
    """A moving body as the recursions see it.

    Attributes
    ----------
    parent
        The number of the body that carries it, smaller than its own; -1 is the base.
    X
        (6, 6): takes motions from the carrying body's frame to its own; depends on the joint.
    S
        (6, 1): the motion that one unit of its joint's velocity is, constant in its own frame.
    I
        (6, 6): its spatial inertia.
    """

    parent: int
    X: ca.SX
    S: ca.SX
    I: ca.SX


def velocities(bodies: Sequence[Body], qd: ca.SX) -> list[ca.SX]:
    """The motion (6, 1) of each body, in its own frame."""
    v: list[ca.SX] = []
    for i, body in enumerate(bodies):
        own = body.S * qd[i]
        v.append(own if body.parent < 0 else body.X @ v[body.parent] + own)
    return v


def torque(bodies: Sequence[Body], gravity: ca.SX, qd: ca.SX, qdd: ca.SX) -> ca.SX:
    """tau = M qdd + C qd + G, (n, 1): the base accelerates upward at `gravity`, and that is what weight is."""
    v = velocities(bodies, qd)
    base = ca.vertcat(ca.SX(5, 1), gravity)
    a: list[ca.SX] = []
    f: list[ca.SX] = []
    for i, body in enumerate(bodies):
        carried = body.X @ (base if body.parent < 0 else a[body.parent])
        spin = cross(v[i])
        a.append(carried + body.S * qdd[i] + spin @ (body.S * qd[i]))
        f.append(body.I @ a[i] - spin.T @ (body.I @ v[i]))
    tau = ca.SX(len(bodies), 1)
    for i in reversed(range(len(bodies))):
        body = bodies[i]
        tau[i] = body.S.T @ f[i]
        if body.parent >= 0:
            f[body.parent] += body.X.T @ f[i]
    return ca.densify(tau)


def kinetic_energy(bodies: Sequence[Body], qd: ca.SX) -> ca.SX:
    """T = sum of v' I v / 2, in J."""
    parts = (v.T @ body.I @ v / 2 for body, v in zip(bodies, velocities(bodies, qd), strict=True))
    return ca.densify(sum(parts, ca.SX(1, 1)))

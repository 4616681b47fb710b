"""The recursions over a tree of bodies: the torque by Newton and Euler, M and C by composite bodies.

References
----------
Featherstone (2008), Rigid Body Dynamics Algorithms, section 5.3 (table 5.1, body coordinates) for the torque, 6.2 for
M; Echeandia and Wensing (2021), Numerical methods to compute the Coriolis matrix and Christoffel symbols for
rigid-body systems, J. Comput. Nonlinear Dynamics 16(9), algorithm 1, for C: of all factors of C qd it is the one that
the Christoffel symbols make.
"""

from collections.abc import Sequence
from typing import NamedTuple

import casadi as ca

from workbench.arms.mechanics.spatial_vectors import cross, swapped_cross


class Body(NamedTuple):
    """A moving body as the recursions see it."""

    parent: int  # the number of the body that carries it, smaller than its own; -1 is the base
    X: ca.SX  # (6, 6), takes motions from the carrying body's frame to its own
    S: ca.SX  # (6, 1), the motion that one unit of its joint's velocity is, constant in its own frame
    I: ca.SX  # (6, 6), its spatial inertia


def velocities(bodies: Sequence[Body], qd: ca.SX) -> list[ca.SX]:
    """The motion (6, 1) of each body, in its own frame."""
    v: list[ca.SX] = []
    for i, body in enumerate(bodies):
        own = body.S * qd[i]
        v.append(own if body.parent < 0 else body.X @ v[body.parent] + own)
    return v


def torque(bodies: Sequence[Body], gravity: ca.SX, qd: ca.SX, qdd: ca.SX) -> ca.SX:
    """tau = M qdd + C qd + G, (n, 1), with gravity as an upward acceleration `gravity` of the base."""
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


def mass_matrix(bodies: Sequence[Body]) -> ca.SX:
    """M(q), (n, n): each joint moves the bodies beyond it as if they were one body."""
    M = ca.SX(len(bodies), len(bodies))
    inertia = [body.I for body in bodies]
    for j in reversed(range(len(bodies))):
        f, i = inertia[j] @ bodies[j].S, j
        M[j, j] = bodies[j].S.T @ f
        while (parent := bodies[i].parent) >= 0:
            f = bodies[i].X.T @ f
            i = parent
            M[i, j] = M[j, i] = bodies[i].S.T @ f
        _carry(bodies[j], inertia, j)
    return ca.densify(M)


def coriolis_matrix(bodies: Sequence[Body], qd: ca.SX) -> ca.SX:
    """C(q, qd), (n, n), of the Christoffel symbols, so that M' - 2C is skew."""
    C = ca.SX(len(bodies), len(bodies))
    v = velocities(bodies, qd)
    S_rate = [cross(v[i]) @ body.S for i, body in enumerate(bodies)]
    inertia = [body.I for body in bodies]
    B = [_coriolis_of_body(body.I, v[i]) for i, body in enumerate(bodies)]
    for j in reversed(range(len(bodies))):
        S, i = bodies[j].S, j
        # three forces: on the joint's own row, and with the roles of the two joints exchanged
        forces = ca.horzcat(inertia[j] @ S_rate[j] + B[j] @ S, inertia[j] @ S, B[j].T @ S)
        C[j, j] = S.T @ forces[:, 0]
        while (parent := bodies[i].parent) >= 0:
            forces = bodies[i].X.T @ forces
            i = parent
            C[i, j] = bodies[i].S.T @ forces[:, 0]
            C[j, i] = S_rate[i].T @ forces[:, 1] + bodies[i].S.T @ forces[:, 2]
        _carry(bodies[j], inertia, j)
        _carry(bodies[j], B, j)
    return ca.densify(C)


def _coriolis_of_body(inertia: ca.SX, v: ca.SX) -> ca.SX:
    """B (6, 6) of one body: B v is its gyroscopic force, and I' - 2B is skew."""
    spin = cross(v)
    return (swapped_cross(inertia @ v) - spin.T @ inertia - inertia @ spin) / 2


def _carry(body: Body, composite: list[ca.SX], j: int) -> None:
    """Add the inertia of the bodies beyond a joint to that of the body that carries it."""
    if body.parent >= 0:
        composite[body.parent] = composite[body.parent] + body.X.T @ composite[j] @ body.X

"""M and C of a tree of bodies from composite bodies: each joint moves all that it carries as if it were one.

References
----------
Featherstone (2008), Rigid Body Dynamics Algorithms, section 6.2, for M; Echeandia and Wensing (2021), Numerical
methods to compute the Coriolis matrix and Christoffel symbols for rigid-body systems, J. Comput. Nonlinear
Dynamics 16(9), algorithm 1, for C: of all factors of C qd it is the one that the Christoffel symbols make.
"""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca

from workbench.robots.motion import cross, swapped_cross
from workbench.robots.newton_euler import Body, velocities


def mass_matrix(bodies: Sequence[Body]) -> ca.SX:
    """M(q), (n, n)."""
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
    """Add what hangs at a joint to the body that carries it."""
    if body.parent >= 0:
        composite[body.parent] = composite[body.parent] + body.X.T @ composite[j] @ body.X

"""tau = Y(q, qd, qdd) theta: the torque of an arm is linear in the numbers of its bodies, drives and frictions.

Of a link these are its mass m, the first moments m c, and the moments of inertia about its frame's origin (not
about the centre of mass, which would be no linear parameter); then, where the link has them, the drive's inertia
gear^2 rotor, and the viscous and Coulomb friction.

References
----------
Siciliano, Sciavicco, Villani and Oriolo (2009), Robotics: Modelling, Planning and Control, section 7.2.2.
"""

from __future__ import annotations

from typing import Any

import casadi as ca

from workbench.core.block import Column
from workbench.robots import newton_euler
from workbench.robots.inertia import ORDER, about_origin, spatial, tensor
from workbench.robots.link import SpatialLink
from workbench.robots.spatial import SpatialArm
from workbench.validation.signatures import door

OF_A_BODY = ("m", "mc_x", "mc_y", "mc_z", "I_xx", "I_xy", "I_xz", "I_yy", "I_yz", "I_zz")


@door
def names(arm: SpatialArm) -> tuple[str, ...]:
    """The entries of theta, (k,): `shoulder.m`, `shoulder.mc_x` and so on, along the arm."""
    return tuple(f"{link.name}.{word}" for link in arm.links for word in (*OF_A_BODY, *_extras(link)))


@door
def parameters(arm: SpatialArm) -> ca.SX:
    """theta (k, 1) of an arm: numbers, or expressions in its symbols where it is lifted."""
    entries = []
    for link in arm.links:
        mass, first, second = about_origin(link.mass, link.com, link.inertia)
        entries += [mass, first, *(second[place] for place in ORDER)]
        entries += [ca.SX(value) for value in _extras(link).values()]
    return ca.densify(ca.vertcat(*entries))


@door
def regressor(arm: SpatialArm, q: Column, qd: Column, qdd: Column) -> ca.SX:
    """Y(q, qd, qdd), (n, k): the derivative of tau by theta, which theta itself does not enter."""
    theta = ca.SX.sym("theta", len(names(arm)))
    held, bodies, extra, place = arm.bodies(q), [], [], 0
    for i, link in enumerate(arm.links):
        m, first, six = theta[place], theta[place + 1 : place + 4], theta[place + 4 : place + 10]
        bodies.append(held[i]._replace(I=spatial(m, first, tensor(six))))
        own = {"drive": qdd[i], "viscous": qd[i], "coulomb": link.direction(qd[i])}
        place += len(OF_A_BODY)
        extra.append(sum((theta[place + j] * own[word] for j, word in enumerate(_extras(link))), ca.SX(1, 1)))
        place += len(_extras(link))
    tau = newton_euler.torque(bodies, ca.SX(arm.gravity), qd, qdd) + ca.vertcat(*extra)
    return ca.densify(ca.jacobian(tau, theta))


def _extras(link: SpatialLink) -> dict[str, Any]:
    """What a link has beside its body."""
    found = {"drive": None if link.rotor is None else link.drive_inertia()}
    found |= {"viscous": link.viscous, "coulomb": link.coulomb}
    return {word: value for word, value in found.items() if value is not None}

"""tau = Y(q, qd, qdd) theta: the torque of an arm is linear in the parameters of bodies, drives and frictions."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import casadi as ca
import numpy as np

from workbench.arms.dynamics import AbstractArm
from workbench.arms.mechanics import recursions
from workbench.arms.mechanics.planar_arm import DIRECTIONS, PlanarArm
from workbench.arms.mechanics.recursions import Body
from workbench.arms.mechanics.spatial import SpatialArm, SpatialLink
from workbench.arms.mechanics.spatial_vectors import (
    inertia_about_origin,
    sparse,
    spatial_inertia,
    tensor,
    transform,
    turn,
)
from workbench.core.expressions import refuse_misfit
from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array, matrix, numbers
from workbench.core.validation.signatures import check_arguments

MOMENTS = ("I_xx", "I_xy", "I_xz", "I_yy", "I_yz", "I_zz")  # in the order of `tensor`
FIRST = ("mc_x", "mc_y", "mc_z")


class _Number(NamedTuple):
    """An entry of theta: its unit, its value and, for drive and friction, its torque at the joint per unit."""

    unit: str
    value: float
    torque: ca.SX | None = None


class _Link(NamedTuple):
    """A link with its frame as the recursions see it, and its entries of theta."""

    name: str
    body: Body
    numbers: dict[str, _Number]


@dataclass(frozen=True, eq=False)
@show
@check_arguments
class Regressor:
    r"""The matrix Y(q, qd, qdd), (n, k), with tau = Y theta for an arm of n joints.

    For each link, theta has the mass m [kg], the first moments m c [kg m] and the moments of inertia [kg m^2] about the
    origin of the link's frame, at its joint, because all of these enter linearly. A link in space has ten such numbers.
    A planar link has four, with x along it and y to its left. The inertia of its drive, gear^2 rotor, and its viscous
    and Coulomb friction follow, if the link has them. The geometry of the arm and gravity are constants in Y.

    Attributes
    ----------
    names, units
        The names and units of theta, (k,): `shoulder.m`, ...; the links of a planar arm are `link1`, `link2`, ...
    theta
        Their values, (k,).
    q, qd, qdd, matrix
        The symbols, (n, 1), and Y in them, (n, k).

    References
    ----------
    Siciliano, Sciavicco, Villani and Oriolo (2009), Robotics: Modelling, Planning and Control, section 7.2.2.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    theta: Array
    q: ca.SX
    qd: ca.SX
    qdd: ca.SX
    matrix: ca.SX

    def __post_init__(self) -> None:
        n, k = self.q.numel(), len(self.names)
        refuse_misfit("Regressor", "matrix", self.matrix, n, k)

    @property
    def dof(self) -> int:
        """The number of joints n."""
        return int(self.q.numel())

    @check_arguments
    def at(self, q: object, qd: object, qdd: object) -> Array:
        """Y at a state, (n, k), from q, qd and qdd (n,); at N states, one below the other, (N n, k), from (N, n)."""
        parts = {"q": q, "qd": qd, "qdd": qdd}
        states = [np.atleast_2d(numbers(f"Regressor.at({name}=...)", each)) for name, each in parts.items()]
        for name, each in zip(parts, states, strict=True):
            matrix(f"Regressor.at({name}=...)", each, len(states[0]), self.dof)
        count, k = len(states[0]), len(self.names)
        columns = np.array(self._function.map(count)(*(state.T for state in states)))  # (n, count k)
        return np.ascontiguousarray(columns.reshape(self.dof, count, k).swapaxes(0, 1).reshape(-1, k))

    @cached_property
    def _function(self) -> ca.Function:
        return ca.Function("Y", [self.q, self.qd, self.qdd], [ca.densify(self.matrix)], {"cse": True})


@check_arguments
def regressor(arm: PlanarArm | SpatialArm) -> Regressor:
    """The regressor Y(q, qd, qdd) of an arm: the torque is linear in the inertial parameters theta, tau = Y theta.

    The answer is a `wb.arms.mechanics.Regressor`: `names`, `units` and `theta` are those of the parameters, and
    `at(q, qd, qdd)` is Y as numbers.

    Parameters
    ----------
    arm
        A planar or spatial arm, as of `wb.robot` or `wb.read_urdf`.

    Raises
    ------
    ValueError
        If `arm` is a block of another type, whose inertial parameters are not known.

    Examples
    --------
    >>> Y = wb.regressor(wb.paper_arm())
    >>> Y.names[4:], Y.at([0.1, 0.2], [0.0, 0.0], [1.0, 0.0]).shape
    (('link2.m', 'link2.mc_x', 'link2.mc_y', 'link2.I_zz'), (2, 8))
    """
    q, qd, qdd = (ca.SX.sym(letter, arm.dof) for letter in ("q", "qd", "qdd"))
    links = _links(arm, q, qd, qdd)
    entries = {f"{link.name}.{word}": number for link in links for word, number in link.numbers.items()}
    theta = ca.SX.sym("theta", len(entries))
    held = dict(zip(entries, ca.vertsplit(theta), strict=True))
    bodies, beside = [], list[ca.SX]()
    for link in links:
        own = {word: held[f"{link.name}.{word}"] for word in link.numbers}
        first = ca.vertcat(*(own.get(word, ca.SX(1, 1)) for word in FIRST))
        moments = tensor(ca.vertcat(*(own.get(word, ca.SX(1, 1)) for word in MOMENTS)))
        bodies.append(link.body._replace(I=inertia_about_origin(own["m"], first, moments)))
        torques = (own[word] * each.torque for word, each in link.numbers.items() if each.torque is not None)
        beside.append(sum(torques, ca.SX(1, 1)))
    tau = recursions.torque(bodies, ca.SX(arm.gravity), qd, qdd) + ca.vertcat(*beside)
    values, units = np.array([each.value for each in entries.values()]), tuple(each.unit for each in entries.values())
    return Regressor(tuple(entries), units, values, q, qd, qdd, ca.densify(ca.jacobian(tau, theta)))


def _links(arm: AbstractArm, q: ca.SX, qd: ca.SX, qdd: ca.SX) -> list[_Link]:
    if isinstance(arm, SpatialArm):
        return [_spatial(link, q[i], qd[i], qdd[i]) for i, link in enumerate(arm.links)]
    assert isinstance(arm, PlanarArm)
    right, up = DIRECTIONS[arm.zero]
    # x along the first link at q = 0, y to its left, z along the joint: gravity pulls along -z of the base
    base = np.array([[right, -up, 0], [0, 0, -1], [up, right, 0]], dtype=float)
    return [_planar(arm, i, q[i], base if i == 0 else np.eye(3)) for i in range(arm.dof)]


def _spatial(link: SpatialLink, q: ca.SX, qd: ca.SX, qdd: ca.SX) -> _Link:
    inertia = np.array(ca.evalf(ca.densify(spatial_inertia(link.mass, link.com, link.inertia))))
    entries = {"m": _Number("kg", link.mass)}
    entries |= {word: _Number("kg m", float(value)) for word, value in zip(FIRST, link.mass * link.com, strict=True)}
    moments = zip(MOMENTS, inertia[:3, :3][np.triu_indices(3)], strict=True)
    entries |= {word: _Number("kg m^2", float(value)) for word, value in moments}
    if link.rotor is not None:
        entries["drive"] = _Number(link.rotor_unit, link.drive_inertia(), qdd)
    if link.viscous is not None:
        entries["viscous"] = _Number(f"{link.force} s/{link.length}", link.viscous, qd)
    if link.coulomb is not None:
        entries["coulomb"] = _Number(link.force, link.coulomb, link.direction(qd))
    return _Link(link.name, link.body(q), entries)


def _planar(arm: PlanarArm, i: int, q: ca.SX, before: Array) -> _Link:
    link, place = arm.links[i], arm.links[i - 1].length if i else 0.0
    rotation = sparse(before) @ turn(np.array([0.0, 0.0, 1.0]), q)
    frame = transform(rotation, ca.vertcat(ca.SX(place), ca.SX(2, 1)))
    about_joint = link.inertia + link.mass * (link.com**2 + link.offset**2)
    entries = {
        "m": _Number("kg", link.mass),
        "mc_x": _Number("kg m", link.mass * link.com),
        "mc_y": _Number("kg m", link.mass * link.offset),
        "I_zz": _Number("kg m^2", about_joint),
    }
    spin = ca.vertcat(ca.SX(2, 1), 1, ca.SX(3, 1))
    return _Link(f"link{i + 1}", Body(i - 1, frame, spin, ca.SX(6, 6)), entries)

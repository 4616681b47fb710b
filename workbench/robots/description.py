"""What an arm is: links with mass, length, centre of mass and inertia, in a vertical plane."""

from __future__ import annotations

import casadi as ca

from workbench.core import AbstractArm, block, option, parameter
from workbench.core.block import Column, Scalar
from workbench.robots import kinematics, lagrange
from workbench.validation.refusals import whole


@block
class Link:
    """A rigid link that turns about its proximal joint, seen in the plane of motion.

    The centre of mass lies `com` along the line from the joint to the next joint, and `offset` to
    the left of that line. A point mass at the link's end has com = length, offset = 0, inertia = 0.

    Parameters
    ----------
    inertia
        About the centre of mass, round the axis of the joint.
    """

    mass: Scalar = parameter(unit="kg", low=0, strict=True, symbol="m")
    length: Scalar = parameter(unit="m", low=0, strict=True, symbol="l")
    com: Scalar = parameter(unit="m", symbol="c")
    offset: Scalar = parameter(default=0.0, unit="m", symbol="d")
    inertia: Scalar = parameter(default=0.0, unit="kg m^2", low=0, symbol="I")


@block
class PointMass:
    """A massless link of given length with all its mass at the far end (equations (2) to (4) of the paper)."""

    mass: Scalar = parameter(unit="kg", low=0, strict=True, symbol="m")
    length: Scalar = parameter(unit="m", low=0, strict=True, symbol="l")

    @property
    def com(self) -> Scalar:
        """The centre of mass is the far end."""
        return self.length

    @property
    def offset(self) -> float:
        """The mass lies on the line of the link."""
        return 0.0

    @property
    def inertia(self) -> float:
        """A point has no inertia about itself."""
        return 0.0


@block
class PlanarArm(AbstractArm):
    """A chain of links joined by revolute joints with parallel horizontal axes.

    Each joint angle is measured from the line of the link before it, counter-clockwise; the first
    one from the direction `zero`. M comes from the kinetic energy, C from its Christoffel symbols,
    G from the potential energy.

    Parameters
    ----------
    passive
        The numbers of the joints without a motor, counted from 0 as the links are.

    Raises
    ------
    ValueError
        If there is no link, a passive joint is none of the arm's, or no joint has a motor.

    References
    ----------
    Siciliano, Sciavicco, Villani and Oriolo (2009), Robotics: Modelling, Planning and Control, section 7.3.
    """

    links: tuple[Link | PointMass, ...]
    gravity: Scalar = parameter(default=9.81, unit="m/s^2", low=0, symbol="g")
    zero: str = option(
        {
            "down": "at q = 0 the arm hangs along the downward vertical",
            "right": "at q = 0 the arm lies along the horizontal",
            "up": "at q = 0 the arm stands along the upward vertical",
        },
        default="down",
    )
    passive: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        if not self.links:
            raise ValueError("`PlanarArm(links=...)` must be a tuple of at least one `Link` or `PointMass`; got none.")
        for joint in self.passive:
            whole("PlanarArm(passive=...)", joint, 0, self.dof - 1, why="as the links are counted")
        if not self.motors:
            raise ValueError("`PlanarArm(passive=...)` must leave a joint with a motor; got all joints.")

    @property
    def dof(self) -> int:
        """The number of joints."""
        return len(self.links)

    @property
    def motors(self) -> tuple[int, ...]:
        """The joints that have a motor, by number: all but the passive ones."""
        return tuple(joint for joint in range(self.dof) if joint not in self.passive)

    def kinetic_energy(self, q: Column, qd: Column) -> ca.SX:
        """T(q, qd) in J."""
        return kinematics.kinetic_energy(self.links, q, qd)

    def potential_energy(self, q: Column) -> ca.SX:
        """U(q) in J, zero with all masses at the height of the base."""
        return kinematics.potential_energy(self.links, self.gravity, self.zero, q)

    def mass_matrix(self, q: Column) -> ca.SX:
        """M(q), (n, n), in kg m^2: the Hessian of the kinetic energy in the velocities."""
        return lagrange.mass_matrix(self.kinetic_energy, q)

    def coriolis_matrix(self, q: Column, qd: Column) -> ca.SX:
        """C(q, qd), (n, n), in kg m^2/s: the one of the Christoffel symbols, for which M' - 2C is skew."""
        return lagrange.coriolis_matrix(self.mass_matrix, q, qd)

    def gravity_vector(self, q: Column) -> ca.SX:
        """G(q), (n, 1), in N m: the gradient of the potential energy."""
        return lagrange.gravity_vector(self.potential_energy, q)

    def tip(self, q: Column) -> ca.SX:
        """Where the last link ends, (2, 1) in m: to the right of the base, and above it."""
        return kinematics.positions(self.links, self.zero, q)[-1]

    def tip_jacobian(self, q: Column) -> ca.SX:
        """d tip / dq, (2, n), in m."""
        return lagrange.at(q, lambda symbols: ca.jacobian(self.tip(symbols), symbols))

"""Arms whose links turn in a vertical plane: their description, and their energies as a book writes them.

Velocities are components along the links' own directions, whose inner products are cosines and sines of relative
angles, so that the energies come out without squares of sines and cosines that would cancel.
"""

from collections.abc import Sequence

import casadi as ca

from workbench.arms.dynamics import AbstractArm
from workbench.arms.mechanics import lagrange
from workbench.core import block, option, parameter
from workbench.core.block import Column, Scalar
from workbench.core.shapes import Circle, Line, Shape
from workbench.core.validation.refusals import whole

# The direction of the first link at q = 0, as (to the right, upward).
DIRECTIONS = {"down": (0, -1), "right": (1, 0), "up": (0, 1)}


@block
class Link:
    """A rigid link that turns about its proximal joint, seen in the plane of motion.

    The centre of mass lies `com` along the line from the joint to the next joint, and `offset` to the left of that
    line; `inertia` is about it. A point mass at the link's end has com = length, offset = 0, inertia = 0.
    """

    mass: Scalar = parameter(unit="kg", low=0, strict=True, symbol="m")
    length: Scalar = parameter(unit="m", low=0, strict=True, symbol="l")
    com: Scalar = parameter(unit="m", symbol="c")
    offset: Scalar = parameter(default=0.0, unit="m", symbol="d")
    inertia: Scalar = parameter(default=0.0, unit="kg m^2", low=0, symbol="I")


@block
class PointMass:
    """A massless link of given length with all its mass at the far end (equations (2) to (4) of the paper).

    Examples
    --------
    >>> links = wb.arms.mechanics.PointMass(1.0, 0.5), wb.arms.mechanics.PointMass(1.0, 0.5)
    >>> wb.arms.mechanics.PlanarArm(links).dof
    2
    """

    offset = 0.0
    inertia = 0.0

    mass: Scalar = parameter(unit="kg", low=0, strict=True, symbol="m")
    length: Scalar = parameter(unit="m", low=0, strict=True, symbol="l")

    @property
    def com(self) -> Scalar:
        return self.length


@block
class PlanarArm(AbstractArm):
    """A chain of links joined by revolute joints with parallel horizontal axes; the `passive` ones have no motor.

    Each joint angle is measured from the line of the link before it, counter-clockwise; the first one from the
    direction `zero`. M comes from the kinetic energy, C from its Christoffel symbols, G from the potential energy.

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
        return len(self.links)

    @property
    def motors(self) -> tuple[int, ...]:
        return tuple(joint for joint in range(self.dof) if joint not in self.passive)

    def kinetic_energy(self, q: Column, qd: Column) -> ca.SX:
        """The sum of m v^2 / 2 + I omega^2 / 2, in J."""
        omegas = [sum((qd[j] for j in range(k + 1)), ca.SX(0)) for k in range(self.dof)]
        angles = waves(q)
        bends = [turns(angles[j + 1 :]) for j in range(self.dof)]
        energy = ca.SX(0)
        for k, link in enumerate(self.links):
            square = _speed_squared(self.links[: k + 1], omegas, bends)
            energy += link.mass * square / 2 + link.inertia * omegas[k] ** 2 / 2
        return energy

    def potential_energy(self, q: Column) -> ca.SX:
        """The sum of m g times height, in J, zero with all masses at the height of the base."""
        energy = ca.SX(0)
        for link, place in zip(self.links, self.centres_of_mass(q), strict=True):
            energy += link.mass * self.gravity * place[1]
        return energy

    def directions(self, q: Column) -> list[tuple[ca.SX, ca.SX]]:
        """The unit vectors along each link and to its left, each (2, 1): to the right and upward."""
        right, up = DIRECTIONS[self.zero]
        pairs = []
        for c, s in turns(waves(q))[1:]:
            along = ca.vertcat(right * c - up * s, up * c + right * s)
            pairs.append((along, ca.vertcat(-along[1], along[0])))
        return pairs

    def joints(self, q: Column) -> list[ca.SX]:
        """The places of the joints, each (2, 1) in m from the base."""
        places = [ca.SX(2, 1)]
        for link, (along, _) in zip(self.links[:-1], self.directions(q), strict=False):
            places.append(places[-1] + link.length * along)
        return places

    def centres_of_mass(self, q: Column) -> list[ca.SX]:
        """The places of the links' centres of mass, each (2, 1) in m from the base."""
        rows = zip(self.links, self.joints(q), self.directions(q), strict=True)
        return [place + link.com * along + link.offset * left for link, place, (along, left) in rows]

    def drawing(self, q: Column) -> tuple[Shape, ...]:
        """The links in their plane, with a bracket at the base and the track of the tip."""
        size = sum((link.length for link in self.links[1:]), self.links[0].length)
        joints, (along, _) = self.joints(q), self.directions(q)[-1]
        ends = [*joints[1:], joints[-1] + self.links[-1].length * along]
        right, up = DIRECTIONS[self.zero]
        feet = [(0.04 * size * (side * up - 2 * right), -0.04 * size * (side * right + 2 * up)) for side in (1, -1)]
        bracket = Line([(0.0, 0.0), *feet], "ground", is_closed=True)
        rods = [Line(pair, "link", 0.03 * size) for pair in zip(joints, ends, strict=True)]
        hinges = [Circle(place, 0.022 * size) for place in joints]
        heavy = (isinstance(link, PointMass) for link in self.links)
        loads = [Circle(place, 0.04 * size) for place, load in zip(ends, heavy, strict=True) if load]
        return bracket, *rods, *hinges, *loads, Circle(ends[-1], 0.014 * size, "path")

    def mass_matrix(self, q: Column) -> ca.SX:
        return lagrange.mass_matrix(self.kinetic_energy, q)

    def coriolis_matrix(self, q: Column, qd: Column) -> ca.SX:
        return lagrange.coriolis_matrix(self.mass_matrix, q, qd)

    def gravity_vector(self, q: Column) -> ca.SX:
        return lagrange.gravity_vector(self.potential_energy, q)


def waves(q: ca.SX) -> list[tuple[ca.SX, ca.SX]]:
    """Cosine and sine of each angle."""
    return [(ca.cos(angle), ca.sin(angle)) for angle in ca.vertsplit(q)]


def turns(waves: Sequence[tuple[ca.SX, ca.SX]]) -> list[tuple[ca.SX, ca.SX]]:
    """Cosine and sine of the sums of the first 0, 1, 2, ... angles, accurate after many turns by addition theorems."""
    c, s = ca.SX(1), ca.SX(0)
    sums = [(c, s)]
    for cos, sin in waves:
        c, s = c * cos - s * sin, s * cos + c * sin
        sums.append((c, s))
    return sums


def _speed_squared(
    links: Sequence[Link | PointMass], omegas: Sequence[ca.SX], bends: Sequence[Sequence[tuple[ca.SX, ca.SX]]]
) -> ca.SX:
    """The squared speed of the last link's centre of mass, in m^2/s^2.

    Body j turns at omega_j and adds omega_j (a_j left_j - b_j along_j) to the velocity, where (a, b) is (length, 0) for
    the links before and (com, offset) for the last; bends[j][k] has cosine and sine of the angle from body j to j + k.
    """
    arms = [*((link.length, 0) for link in links[:-1]), (links[-1].com, links[-1].offset)]
    square = ca.SX(0)
    for i, (a_i, b_i) in enumerate(arms):
        square += omegas[i] ** 2 * (a_i**2 + b_i**2)
        for j in range(i):
            c, s = bends[j][i - j]
            square += 2 * omegas[i] * omegas[j] * arms[j][0] * (a_i * c - b_i * s)
    return square

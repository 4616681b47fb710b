"""Arms with a name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from workbench.robots.description import Link, PlanarArm, PointMass
from workbench.robots.industrial import panda, ur5
from workbench.robots.link import SpatialLink
from workbench.robots.spatial import SpatialArm
from workbench.validation.refusals import known, whole


def paper_arm() -> PlanarArm:
    """The two-link arm of the AOSMC-RGS paper: point masses of 1 kg at the ends of links of 1 m (section 5).

    Examples
    --------
    >>> wb.paper_arm().dof, wb.paper_arm().links[0].mass
    (2, 1.0)
    """
    return PlanarArm((PointMass(1.0, 1.0), PointMass(1.0, 1.0)))


def planar(joints: int) -> PlanarArm:
    """A hanging chain of `joints` equal slender rods of 1 kg and 1 m (inertia m l^2 / 12)."""
    count = whole("planar(joints=...)", joints, most=1_000)
    return PlanarArm(tuple(Link(1.0, 1.0, 0.5, 0.0, 1 / 12) for _ in range(count)))


def pelican() -> PlanarArm:
    """The Pelican of CICESE, a direct-drive arm of two links in a vertical plane, hanging at q = 0.

    References
    ----------
    Kelly, Santibanez and Loria (2005), Control of Robot Manipulators in Joint Space, table 5.1.
    """
    first, second = Link(6.5225, 0.26, 0.0983, 0.0, 0.1213), Link(2.0458, 0.26, 0.0229, 0.0, 0.0116)
    return PlanarArm((first, second), 9.81, "down")


def slotine_li() -> PlanarArm:
    """The two-link arm of Slotine and Li in a horizontal plane, its load 30 degrees right of the second link.

    The length of the second link, which no equation of motion knows, is the distance to its centre of mass.

    References
    ----------
    Slotine and Li (1991), Applied Nonlinear Control, chapter 9: m_1, l_1, m_e, delta_e, I_1, l_c1, I_e and l_ce of
    the two-link arm that is simulated there.
    """
    far, angle = 0.6, np.pi / 6
    load = Link(2.0, far, far * np.cos(angle), -far * np.sin(angle), 0.25)
    return PlanarArm((Link(1.0, 1.0, 0.5, 0.0, 0.12), load), 0.0, "right")


def cart_pole() -> SpatialArm:
    """A cart that slides along x, and a uniform pole on it that stands up at q = 0 and falls towards +x.

    The only motor is the cart's.

    References
    ----------
    Barto, Sutton and Anderson (1983), Neuronlike adaptive elements that can solve difficult learning control
    problems, IEEE Trans. Systems, Man, and Cybernetics 13(5), appendix: 1 kg, 0.1 kg, half-length 0.5 m, 9.8 m/s^2.
    """
    nothing, along = np.zeros(3), 0.1 * 1.0**2 / 12
    cart = SpatialLink("slide", 1.0, nothing, np.zeros(6), axis=(1.0, 0.0, 0.0), joint="prismatic")
    moments = (along, 0.0, 0.0, along, 0.0, 0.0)
    pole = SpatialLink("hinge", 0.1, (0.0, 0.0, 0.5), moments, axis=(0.0, 1.0, 0.0), parent=0, joint="continuous")
    return SpatialArm((cart, pole), 9.8, passive=("hinge",))


def scara() -> SpatialArm:
    """A SCARA: two hinges about the vertical, a quill that slides along it, a spindle that turns in the quill.

    The numbers are our own, of the size of a small assembly robot: bars of 4 kg and 0.4 m, 3 kg and 0.3 m, a quill
    of 1 kg and 0.3 m, a spindle of 0.5 kg whose load lies 2 cm off its axis.
    """

    def bar(name: str, mass: float, length: float, **seat: Any) -> SpatialLink:
        moments = (mass * 0.05**2 / 6, 0.0, 0.0, mass * length**2 / 12, 0.0, mass * length**2 / 12)
        return SpatialLink(name, mass, (length / 2, 0.0, 0.0), moments, **seat)

    quill = (1.0 * 0.3**2 / 12, 0.0, 0.0, 1.0 * 0.3**2 / 12, 0.0, 1.0 * 0.01**2 / 2)
    links = (
        bar("shoulder", 4.0, 0.4, position=(0.0, 0.0, 0.35)),
        bar("elbow", 3.0, 0.3, position=(0.4, 0.0, 0.0), parent=0),
        SpatialLink("quill", 1.0, np.zeros(3), quill, (0.3, 0.0, 0.0), parent=1, joint="prismatic"),
        SpatialLink("spindle", 0.5, (0.02, 0.0, -0.02), (4e-4, 0, 0, 5e-4, 0, 3e-4), (0, 0, -0.15), parent=2),
    )
    return SpatialArm(links)


CATALOGUE: Mapping[str, Callable[[], PlanarArm | SpatialArm]] = {
    "paper-arm": paper_arm,
    "planar-1r": lambda: planar(1),
    "planar-2r": lambda: planar(2),
    "planar-3r": lambda: planar(3),
    "planar-4r": lambda: planar(4),
    "planar-6r": lambda: planar(6),
    "pelican": pelican,
    "slotine-li": slotine_li,
    "cart-pole": cart_pole,
    "scara": scara,
    "ur5": ur5,
    "panda": panda,
}


def named(name: str) -> PlanarArm | SpatialArm:
    """The arm of that name.

    Raises
    ------
    LookupError
        If there is none; the message names the nearest.

    Examples
    --------
    >>> arm = wb.named("cart-pole")
    >>> arm.dof, arm.units, arm.motors
    (2, ('m', 'rad'), (0,))
    """
    return CATALOGUE[known(name, CATALOGUE, "robots of the catalogue")]()

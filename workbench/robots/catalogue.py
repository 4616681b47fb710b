"""Arms with a name."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from workbench.core.layout import nearest
from workbench.core.sockets import described
from workbench.robots.description import Link, PlanarArm, PointMass


def paper_arm() -> PlanarArm:
    """The two-link arm of the AOSMC-RGS paper: point masses of 1 kg at the ends of links of 1 m (section 5)."""
    return PlanarArm((PointMass(1.0, 1.0), PointMass(1.0, 1.0)))


def planar(joints: int) -> PlanarArm:
    """A hanging chain of `joints` equal slender rods of 1 kg and 1 m (inertia m l^2 / 12)."""
    return PlanarArm(tuple(Link(1.0, 1.0, 0.5, 0.0, 1 / 12) for _ in range(joints)))


CATALOGUE: Mapping[str, Callable[[], PlanarArm]] = {
    "paper-arm": paper_arm,
    "planar-1r": lambda: planar(1),
    "planar-2r": lambda: planar(2),
    "planar-3r": lambda: planar(3),
    "planar-4r": lambda: planar(4),
}


def named(name: str) -> PlanarArm:
    """The arm of that name.

    Raises
    ------
    LookupError
        If there is none; the message names the nearest.
    """
    if not isinstance(name, str):
        raise LookupError(f"`named(name=...)` must be the name of a robot, such as 'paper-arm'; got {described(name)}.")
    if name not in CATALOGUE:
        known = f" The catalogue holds: {', '.join(CATALOGUE)}."
        raise LookupError(f"There is no robot '{name}' in the catalogue.{nearest(name, CATALOGUE) or known}")
    return CATALOGUE[name]()

"""Bodies and joints by name, as files give them, put together to an arm."""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from workbench.arms.mechanics.spatial import SpatialArm, SpatialLink
from workbench.arms.mechanics.spatial_vectors import (
    Lump,
    merge_lumps,
    moments,
    refuse_impossible,
    refuse_skewed,
    tensor,
)
from workbench.core.validation.refusals import Array, nearest, vector
from workbench.core.validation.refusals import name as check_name
from workbench.core.validation.signatures import check_arguments

EXACT = 1e-15  # of an entry of a rotation: the cosine of a rounded pi / 2 is meant to be zero


@dataclass(frozen=True, eq=False)
@check_arguments
class Solid:
    """A named body: mass in kg, centre of mass (3,) in m, six moments xx, xy, xz, yy, yz, zz about it in kg m^2."""

    name: str
    mass: float = 0.0
    com: Array = field(default_factory=lambda: np.zeros(3))
    inertia: Array = field(default_factory=lambda: np.zeros(6))

    def __post_init__(self) -> None:
        check_name("Solid(name=...)", self.name)
        vector("Solid(com=...)", self.com, 3, "coordinates")
        vector("Solid(inertia=...)", self.inertia, 6, "moments")


@dataclass(frozen=True, eq=False)
@check_arguments
class Joint:
    """A named joint from a body to the one it carries, in the words of `SpatialLink`, or of kind `fixed`."""

    name: str
    parent: str
    child: str
    kind: str = "fixed"
    position: Array = field(default_factory=lambda: np.zeros(3))
    rotation: Array = field(default_factory=lambda: np.eye(3))
    axis: Array = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    viscous: float | None = None
    coulomb: float | None = None
    rotor: float | None = None
    gear: float | None = None
    speed: float | None = None

    def __post_init__(self) -> None:
        check_name("Joint(name=...)", self.name)
        vector("Joint(position=...)", self.position, 3, "coordinates")
        refuse_skewed("Joint(rotation=...)", self.rotation)


class _Seat(NamedTuple):
    """A frame on a link by its number, -1 for the base: axes (3, 3) and origin (3,)."""

    link: int
    rotation: Array
    position: Array


@check_arguments
def arm_of(
    solids: Sequence[Solid], joints: Sequence[Joint], gravity: float = 9.81, passive: tuple[str, ...] = ()
) -> SpatialArm:
    """The arm of bodies and joints; bodies that a fixed joint connects become one, the mass of the base has no effect.

    The moving joints are numbered along the tree, each before what it carries, branches in the order of `joints`.

    Raises
    ------
    ValueError
        If names are not unique, a joint names no body, a body is carried twice or cannot be, there is a loop or more
        than one base, or nothing moves or is driven.
    LookupError
        If a passive joint is none that moves.
    """
    held = _by_name(solids, joints)
    for solid in solids:
        refuse_impossible(f"link '{solid.name}'", solid.mass, tensor(solid.inertia))
    base = _base(held, joints)
    seats = {base: _Seat(-1, np.eye(3), np.zeros(3))}
    moving: list[tuple[Joint, _Seat]] = []
    for joint in _outward(base, held, joints):
        carrier = seats[joint.parent]
        turned = _tidy(carrier.rotation @ joint.rotation)
        seat = _Seat(carrier.link, turned, carrier.position + carrier.rotation @ joint.position)
        if joint.kind == "fixed":
            seats[joint.child] = seat
        else:
            seats[joint.child] = _Seat(len(moving), np.eye(3), np.zeros(3))
            moving.append((joint, seat))
    if not moving:
        raise ValueError("An arm needs a joint that moves; this one has none, or fixed ones alone.")
    bodies = [
        merge_lumps([_seen_from(seat, held[name]) for name, seat in seats.items() if seat.link == i])
        for i in range(len(moving))
    ]
    carriers = {seat.link for _, seat in moving}
    for i, ((joint, _), body) in enumerate(zip(moving, bodies, strict=True)):
        if body.mass == 0 and i not in carriers and not joint.rotor:
            raise ValueError(
                f"Link '{joint.child}' is moved by joint '{joint.name}' and has no mass, nor has what is fixed to it, "
                "and it carries nothing else: M would be singular; give it a mass, or fix the joint."
            )
    links = (_link(joint, seat, body) for (joint, seat), body in zip(moving, bodies, strict=True))
    return SpatialArm(tuple(links), gravity, passive)


def _link(joint: Joint, seat: _Seat, lump: Lump) -> SpatialLink:
    own = {word: getattr(joint, word) for word in ("viscous", "coulomb", "rotor", "gear", "speed")}
    own |= {"axis": joint.axis, "rotation": seat.rotation, "parent": seat.link, "joint": joint.kind}
    return SpatialLink(joint.name, lump.mass, lump.com, moments(lump.inertia), seat.position, **own)


def _seen_from(seat: _Seat, solid: Solid) -> Lump:
    """A body as a lump in the frame of the link it belongs to."""
    R = seat.rotation
    return Lump(solid.mass, seat.position + R @ solid.com, R @ tensor(solid.inertia) @ R.T)


def _tidy(R: Array) -> Array:
    """A rotation whose entries within rounding of -1, 0 and 1 are these."""
    whole = np.round(R)
    return np.where(np.abs(R - whole) <= EXACT, whole + 0.0, R)


def _by_name(solids: Sequence[Solid], joints: Sequence[Joint]) -> dict[str, Solid]:
    """The bodies by name, after a check that each name is used once."""
    for kind, names in (("link", [s.name for s in solids]), ("joint", [j.name for j in joints])):
        if (twice := _twice(names)) is not None:
            raise ValueError(f"The names of {kind}s must be unique; '{twice}' came more than once.")
    held = {solid.name: solid for solid in solids}
    for joint in joints:
        for end, name in (("parent", joint.parent), ("child", joint.child)):
            if name not in held:
                raise ValueError(f"Joint '{joint.name}' has the {end} '{name}', which is no link.{nearest(name, held)}")
    if (twice := _twice(joint.child for joint in joints)) is not None:
        raise ValueError(f"Link '{twice}' is carried by more than one joint: closed chains are not modelled.")
    return held


def _twice(names: Iterable[str]) -> str | None:
    """The first name that occurs a second time."""
    return next((name for name, times in Counter(names).items() if times > 1), None)


def _base(solids: dict[str, Solid], joints: Sequence[Joint]) -> str:
    """The one body that no joint carries."""
    carried = {joint.child for joint in joints}
    free = [name for name in solids if name not in carried]
    if len(free) != 1:
        raise ValueError(f"An arm stands on one base, a link that no joint carries; such are {_names(free)}.")
    return free[0]


def _outward(base: str, solids: dict[str, Solid], joints: Sequence[Joint]) -> list[Joint]:
    """The joints along the tree, each before those it carries."""
    carried_by: dict[str, list[Joint]] = {name: [] for name in solids}
    for joint in joints:
        carried_by[joint.parent].append(joint)
    order: list[Joint] = []
    waiting = carried_by[base][::-1]
    while waiting:
        order.append(waiting.pop())
        waiting += carried_by[order[-1].child][::-1]
    if len(order) < len(joints):
        lost = {joint.child for joint in joints} - {joint.child for joint in order}
        raise ValueError(f"The links {_names(sorted(lost))} carry each other in a loop that hangs on no base.")
    return order


def _names(names: Sequence[str], most: int = 5) -> str:
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return (", ".join(f"'{name}'" for name in names[:most]) or "none") + more

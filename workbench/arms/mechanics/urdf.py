"""The arm that a URDF file describes: links with inertia, and joints; visual and collision parts are ignored.

Gravity pulls along -z of the root link. Limits of position, velocity and effort are ignored, as they are no part of
the equations. A text with entities or other files in it, or one that is very large, is refused.

References
----------
The ROS wiki, pages urdf/XML/robot, urdf/XML/link and urdf/XML/joint.
"""

import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn
from xml.etree.ElementTree import Element, ParseError, TreeBuilder, XMLParser

import numpy as np

from workbench.arms.mechanics.joint_tree import Joint, Solid, arm_of
from workbench.arms.mechanics.spatial import SpatialArm
from workbench.arms.mechanics.spatial_vectors import from_angles, tensor
from workbench.core.validation.refusals import Array, describe, positive
from workbench.core.validation.signatures import check_arguments

LARGEST = 2_000_000  # bytes of a file
LONGEST_PATH = 300  # characters of a path that a message shows
MOST_JOINTS = 64  # that move; the equations of more take minutes
MOST_LINKS = 2_000
UNIT = 1e-3  # how far printed digits may take an axis from length one; it is then made one
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
KINDS = ("revolute", "continuous", "prismatic", "fixed")
MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


@check_arguments
def read_urdf(
    file: str | Path, gravity: float = 9.81, *, passive: tuple[str, ...] = (), friction_speed: float | None = None
) -> SpatialArm:
    """Read an arm from a URDF file. No other file is opened; meshes are ignored.

    Parameters
    ----------
    file
        The path of the URDF file.
    gravity
        Gravitational acceleration in m/s^2.
    passive
        Names of the joints without a motor.
    friction_speed
        The speed, in rad/s or m/s, over which the jump of all Coulomb friction is smoothed:
        friction tanh(qd / friction_speed). By default the friction jumps where a joint reverses, and the arm cannot be
        linearised at rest.

    Raises
    ------
    LookupError
        If there is no such file, or no such joint.
    ValueError
        If the file is no URDF of an arm with a fixed base. The message has the place and the reason.

    Examples
    --------
    >>> arm = wb.read_urdf("pendulum.urdf")
    >>> arm.dof, arm.links[0].mass
    (1, 1.5)
    """
    name = describe(str(file), LONGEST_PATH)
    try:
        if not Path(file).is_file():  # a folder, a pipe, which would wait for a writer, or nothing
            raise LookupError(f"There is no file {name}.")
        with Path(file).open("rb") as handle:
            text = handle.read(LARGEST + 1)
    except (OSError, ValueError) as error:  # of a path with a null character, say
        raise LookupError(f"{name} cannot be read: {getattr(error, 'strerror', None) or error}.") from None
    return _arm(text, name, gravity, passive, friction_speed)


@check_arguments
def parse(
    text: str, gravity: float = 9.81, *, passive: tuple[str, ...] = (), friction_speed: float | None = None
) -> SpatialArm:
    """The arm that URDF text describes, by the arguments of `read`."""
    return _arm(text.encode(), "The text", gravity, passive, friction_speed)


class _PlainTree(TreeBuilder):
    """A tree of elements and attributes alone."""

    def doctype(self, *_: object) -> NoReturn:
        """Refuse entities and other files."""
        raise ParseError("it has a DOCTYPE, and entities and other files are never read: take it out")


def _root(text: bytes, source: str) -> Element:
    if len(text) > LARGEST:
        raise ValueError(f"{source} has more than {LARGEST} bytes, the most that is read.")
    parser = XMLParser(target=_PlainTree())
    try:
        parser.feed(text)
        return parser.close()
    except ParseError as error:
        raise ValueError(f"{source} is no plain, well-formed XML: {error}.") from None
    except (ValueError, LookupError):
        raise ValueError(f"{source} is in an encoding that is not known; write it in UTF-8.") from None


def _arm(
    text: bytes, source: str, gravity: float, passive: tuple[str, ...], friction_speed: float | None
) -> SpatialArm:
    if friction_speed is not None:
        positive("read_urdf(friction_speed=...)", friction_speed, " of rad/s or m/s, over which the jump is spread")
    root = _root(text, source)
    if root.tag != "robot":
        raise ValueError(f"{source} is no URDF: its root is <{root.tag[:40]}>, and must be <robot>.")
    if odd := next((e.tag for e in root.iter() if "xacro" in e.tag), None):
        raise ValueError(f"{source} is a xacro file, as it has <{odd[:40]}>: expand it with the program xacro first.")
    links, joints = root.findall("link"), root.findall("joint")
    if len(links) > MOST_LINKS or sum(joint.get("type") != "fixed" for joint in joints) > MOST_JOINTS:
        raise ValueError(
            f"{source} has more than {MOST_LINKS} links or {MOST_JOINTS} moving joints; this is more than is derived."
        )
    try:
        moved = [_joint(joint, friction_speed) for joint in joints]
        return arm_of([_solid(link) for link in links], moved, gravity, passive)
    except ValueError as error:
        raise ValueError(f"{source}: {error}") from None


def _solid(link: Element) -> Solid:
    name = _attribute(link, "name", "A <link>")
    where = f"link '{name}'"
    inertial = _only(link, "inertial", where)
    if inertial is None:
        return Solid(name)
    mass, inertia = _only(inertial, "mass", where), _only(inertial, "inertia", where)
    if mass is None or inertia is None:
        raise ValueError(f"The <inertial> of {where} needs a <mass> and an <inertia>.")
    position, R = _origin(inertial, where)
    kg = _numbers(_attribute(mass, "value", f"The <mass> of {where}"), 1, f"the mass of {where}")[0]
    six = [_numbers(_attribute(inertia, k, f"The <inertia> of {where}"), 1, f"'{k}' of {where}")[0] for k in MOMENTS]
    turned = R @ tensor(six) @ R.T
    return Solid(name, kg, position, turned[np.triu_indices(3)])


def _joint(joint: Element, friction_speed: float | None) -> Joint:
    name = _attribute(joint, "name", "A <joint>")
    where = f"joint '{name}'"
    kind = _attribute(joint, "type", f"The {where}")
    if kind not in KINDS:
        raise ValueError(f"The {where} is of type '{kind[:40]}'; an arm has {', '.join(KINDS[:-1])} and fixed joints.")
    if kind != "fixed" and joint.find("mimic") is not None:
        raise ValueError(f"The {where} mimics another one; coupled joints are not modelled: fix it, or free it.")
    ends = [_only(joint, end, where) for end in ("parent", "child")]
    parent, child = ("" if e is None else _attribute(e, "link", f"The <{e.tag}> of {where}") for e in ends)
    if not (parent and child):
        raise ValueError(f"The {where} needs a <parent link=...> and a <child link=...>.")
    position, rotation = _origin(joint, where)
    if kind == "fixed":
        return Joint(name, parent, child, kind, position, rotation)
    viscous, coulomb = _friction(joint, where)
    speed = None if coulomb is None else friction_speed
    seat = (position, rotation, _axis(joint, where))
    return Joint(name, parent, child, kind, *seat, viscous, coulomb, speed=speed)


def _axis(joint: Element, where: str) -> Array:
    """The axis, made a unit vector where only its printed digits keep it from being one; x if none is given."""
    element = _only(joint, "axis", where)
    if element is None:
        return np.array([1.0, 0.0, 0.0])
    axis = _numbers(_attribute(element, "xyz", f"The <axis> of {where}"), 3, f"the axis of {where}")
    length = math.hypot(*axis)
    if abs(length - 1) > UNIT:
        raise ValueError(f"The axis of {where} must be a unit vector, as q counts along it; its length is {length:g}.")
    return np.asarray(axis / length)


def _friction(joint: Element, where: str) -> tuple[float | None, float | None]:
    """Viscous and Coulomb friction; None where there is none."""
    element = _only(joint, "dynamics", where)
    if element is None:
        return None, None
    words = ((key, element.get(key, "0")) for key in ("damping", "friction"))
    viscous, coulomb = (float(_numbers(text, 1, f"'{key}' of {where}")[0]) or None for key, text in words)
    return viscous, coulomb


def _origin(element: Element, where: str) -> tuple[Array, Array]:
    """Position (3,) and rotation (3, 3) of an <origin>; zero and none without it."""
    origin = _only(element, "origin", where)
    if origin is None:
        return np.zeros(3), np.eye(3)
    position = _numbers(origin.get("xyz", "0 0 0"), 3, f"the origin of {where}")
    roll, pitch, yaw = _numbers(origin.get("rpy", "0 0 0"), 3, f"the rpy of {where}")
    return position, from_angles(roll, pitch, yaw)


def _only(element: Element, tag: str, where: str) -> Element | None:
    """The child of that tag, if there is one; two are refused."""
    found = element.findall(tag)
    if len(found) > 1:
        raise ValueError(f"The {where} has more than one <{tag}>.")
    return found[0] if found else None


def _attribute(element: Element, key: str, what: str) -> str:
    value = element.get(key, "").strip()
    if not value:
        raise ValueError(f"{what} needs the attribute '{key}'.")
    if len(value) > 200 or not value.isprintable():
        raise ValueError(
            f"{what} has an attribute '{key}' of {len(value)} characters, some not printable or too many: "
            "that is no name and no number."
        )
    return value


def _numbers(text: str, count: int, what: str) -> Array:
    """A stated count of finite numbers from words: decimal points, no commas, no units, no expressions."""
    words: Sequence[str] = text.split()
    if len(words) != count or not all(len(word) <= 60 and NUMBER.fullmatch(word) for word in words):
        want = "a number" if count == 1 else f"{count} numbers with spaces between"
        raise ValueError(f"{what[0].upper()}{what[1:]} must be {want}, as in '0.5' or '1e-3'; got {text[:60]!r}.")
    values = np.array([float(word) for word in words])
    if not np.isfinite(values).all():
        raise ValueError(f"{what[0].upper()}{what[1:]} must be finite; got {text[:60]!r}.")
    return values

"""The catalogue of arms by name, with the sources of their numbers."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from workbench.arms.mechanics.joint_tree import Joint, Solid, arm_of
from workbench.arms.mechanics.planar_arm import Link, PlanarArm, PointMass
from workbench.arms.mechanics.spatial import SpatialArm, SpatialLink
from workbench.arms.mechanics.spatial_vectors import from_angles
from workbench.core.validation.refusals import Array, known_name, whole

UP, ACROSS, RIGHT = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0]), np.pi / 2


def paper_arm() -> PlanarArm:
    """The two-link arm of the AOSMC-RGS paper: point masses of 1 kg at the ends of links of 1 m (section 5).

    Examples
    --------
    >>> wb.paper_arm().dof, wb.paper_arm().links[0].mass
    (2, 1.0)
    """
    return PlanarArm((PointMass(1.0, 1.0), PointMass(1.0, 1.0)))


def planar(joints: int) -> PlanarArm:
    """A hanging chain of `joints` equal slender rods of 1 kg and 1 m (inertia m l^2 / 12).

    Examples
    --------
    >>> wb.arms.mechanics.planar(3).dof
    3
    """
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
    Slotine and Li (1991), Applied Nonlinear Control, chapter 9, the two-link arm that is simulated there.
    """
    far, angle = 0.6, np.pi / 6
    load = Link(2.0, far, far * np.cos(angle), -far * np.sin(angle), 0.25)
    return PlanarArm((Link(1.0, 1.0, 0.5, 0.0, 0.12), load), 0.0, "right")


def cart_pole() -> SpatialArm:
    """A cart with a motor that slides along x, and a uniform pole that stands up at q = 0 and falls towards +x.

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

    def bar(
        name: str, mass: float, length: float, position: tuple[float, float, float], parent: int = -1
    ) -> SpatialLink:
        moments = (mass * 0.05**2 / 6, 0.0, 0.0, mass * length**2 / 12, 0.0, mass * length**2 / 12)
        return SpatialLink(name, mass, (length / 2, 0.0, 0.0), moments, position, parent=parent)

    quill = (1.0 * 0.3**2 / 12, 0.0, 0.0, 1.0 * 0.3**2 / 12, 0.0, 1.0 * 0.01**2 / 2)
    links = (
        bar("shoulder", 4.0, 0.4, position=(0.0, 0.0, 0.35)),
        bar("elbow", 3.0, 0.3, position=(0.4, 0.0, 0.0), parent=0),
        SpatialLink("quill", 1.0, np.zeros(3), quill, (0.3, 0.0, 0.0), parent=1, joint="prismatic"),
        SpatialLink("spindle", 0.5, (0.02, 0.0, -0.02), (4e-4, 0, 0, 5e-4, 0, 3e-4), (0, 0, -0.15), parent=2),
    )
    return SpatialArm(links)


def ur5() -> SpatialArm:
    """Universal Robots UR5: six hinges, without a tool.

    Masses and lengths are the maker's; the source takes each link for a solid cylinder about a centre of mass on its
    axis. The wrists' cylinders have a radius of 0.6 m there, presumably for 0.06 m; the robot is simulated so
    everywhere.

    References
    ----------
    ros-industrial/universal_robot, ur_description/urdf/ur5.urdf.xacro, by F. Messmer; BSD licence.
    """
    # mass, radius and length of the cylinder, height of its centre
    cylinders = {
        "shoulder_link": (3.7, 0.06, 0.15, 0.0),
        "upper_arm_link": (8.393, 0.06, 0.56, 0.28),
        "forearm_link": (2.275, 0.06, 0.5, 0.25),
        "wrist_1_link": (1.219, 0.6, 0.12, 0.0),
        "wrist_2_link": (1.219, 0.6, 0.12, 0.0),
        "wrist_3_link": (0.1879, 0.6, 0.12, 0.0),
    }
    # joint, its place, its pitch, its axis
    joints = (
        ("shoulder_pan_joint", (0.0, 0.0, 0.089159), 0.0, UP),
        ("shoulder_lift_joint", (0.0, 0.13585, 0.0), RIGHT, ACROSS),
        ("elbow_joint", (0.0, -0.1197, 0.425), 0.0, ACROSS),
        ("wrist_1_joint", (0.0, 0.0, 0.39225), RIGHT, ACROSS),
        ("wrist_2_joint", (0.0, 0.093, 0.0), 0.0, UP),
        ("wrist_3_joint", (0.0, 0.0, 0.09465), 0.0, ACROSS),
    )
    names = ["base_link", *cylinders]
    solids = [Solid("base_link")]
    solids += [Solid(k, m, np.array([0.0, 0.0, z]), _cylinder(m, r, l)) for k, (m, r, l, z) in cylinders.items()]
    chain = [
        Joint(name, names[i], names[i + 1], "revolute", np.array(place), from_angles(0.0, pitch, 0.0), axis)
        for i, (name, place, pitch, axis) in enumerate(joints)
    ]
    return arm_of(solids, chain)


def _cylinder(mass: float, radius: float, length: float) -> Array:
    """The moments of a solid cylinder along z; the source rounds 1/12 to 0.0833333."""
    across = 0.0833333 * mass * (3 * radius**2 + length**2)
    return np.array([across, 0.0, 0.0, across, 0.0, mass * radius**2 / 2])


def panda() -> SpatialArm:
    """Franka Emika Panda: seven hinges, with its hand and the fingers closed.

    References
    ----------
    Gaz et al. (2019), Dynamic identification of the Franka Emika Panda robot with retrieval of feasible parameters,
    IEEE RA-L 4(4), 4147-4154: the links. frankaemika/franka_ros, franka_description/robots/common, files inertial.yaml,
    franka_arm.xacro and franka_hand.xacro; Apache-2.0: these figures, the frames, and the hand.
    """
    # mass; centre of mass; moments xx, xy, xz, yy, yz, zz
    links: Sequence[tuple[float, tuple[float, ...], tuple[float, ...]]] = (
        (4.970684, (3.875e-3, 2.081e-3, -47.62e-3), (0.70337, -1.39e-4, 6.772e-3, 0.70661, 0.019169, 9.117e-3)),
        (0.646926, (-3.141e-3, -28.72e-3, 3.495e-3), (7.962e-3, -3.925e-3, 0.010254, 0.02811, 7.04e-4, 0.025995)),
        (3.228604, (27.518e-3, 39.252e-3, -66.502e-3), (0.037242, -4.761e-3, -0.011396, 0.036155, -0.012805, 0.01083)),
        (3.587895, (-53.17e-3, 104.419e-3, 27.454e-3), (0.025853, 7.796e-3, -1.332e-3, 0.019552, 8.641e-3, 0.028323)),
        (1.225946, (-11.953e-3, 41.065e-3, -38.437e-3), (0.035549, -2.117e-3, -4.037e-3, 0.029474, 2.29e-4, 8.627e-3)),
        (1.666555, (60.149e-3, -14.117e-3, -10.517e-3), (1.964e-3, 1.09e-4, -1.158e-3, 4.354e-3, 3.41e-4, 5.433e-3)),
        (0.735522, (10.517e-3, -4.252e-3, 61.597e-3), (0.012516, -4.28e-4, -1.196e-3, 0.010027, -7.41e-4, 4.815e-3)),
    )
    # place of each joint, its roll
    joints = (
        ((0.0, 0.0, 0.333), 0.0),
        ((0.0, 0.0, 0.0), -RIGHT),
        ((0.0, -0.316, 0.0), RIGHT),
        ((0.0825, 0.0, 0.0), RIGHT),
        ((-0.0825, 0.384, 0.0), -RIGHT),
        ((0.0, 0.0, 0.0), RIGHT),
        ((0.088, 0.0, 0.0), RIGHT),
    )
    names = [f"panda_link{i}" for i in range(8)]
    solids = [Solid(names[0])]
    solids += [Solid(name, m, np.array(c), np.array(six)) for name, (m, c, six) in zip(names[1:], links, strict=True)]
    chain = [
        Joint(f"panda_joint{i}", names[i - 1], names[i], "revolute", np.array(place), from_angles(roll, 0, 0))
        for i, (place, roll) in enumerate(joints, 1)
    ]
    hand, fixed = _panda_hand()
    return arm_of([*solids, *hand], [*chain, *fixed])


def _panda_hand() -> tuple[list[Solid], list[Joint]]:
    """The flange, and the hand with its two fingers closed."""
    finger = np.array([2.375e-6, 0.0, 0.0, 2.375e-6, 0.0, 7.5e-7])
    hand = Solid("panda_hand", 0.73, np.array([-0.01, 0.0, 0.03]), np.array([0.001, 0.0, 0.0, 0.0025, 0.0, 0.0017]))
    fingers = [Solid(f"panda_{side}finger", 0.015, np.zeros(3), finger) for side in ("left", "right")]
    seats = (
        ("panda_joint8", "panda_link7", "panda_link8", 0.107, 0.0),
        ("panda_hand_joint", "panda_link8", "panda_hand", 0.0, -np.pi / 4),
        ("panda_finger_joint1", "panda_hand", "panda_leftfinger", 0.0584, 0.0),
        ("panda_finger_joint2", "panda_hand", "panda_rightfinger", 0.0584, 0.0),
    )
    joints = [
        Joint(name, parent, child, "fixed", np.array([0.0, 0.0, height]), from_angles(0, 0, yaw))
        for name, parent, child, height, yaw in seats
    ]
    return [Solid("panda_link8"), hand, *fingers], joints


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


def robot(name: str) -> PlanarArm | SpatialArm:
    """An arm of the catalogue, with the masses and lengths of its source.

    Parameters
    ----------
    name
        One of "paper-arm", "planar-1r", "planar-2r", "planar-3r", "planar-4r", "planar-6r", "pelican", "slotine-li",
        "cart-pole", "scara", "ur5" and "panda".

    Raises
    ------
    LookupError
        If the catalogue has no arm of this name. The message has the nearest name.

    Examples
    --------
    >>> arm = wb.robot("cart-pole")
    >>> arm.dof, arm.units, arm.motors
    (2, ('m', 'rad'), (0,))
    """
    return CATALOGUE[known_name(name, CATALOGUE, "robots of the catalogue")]()

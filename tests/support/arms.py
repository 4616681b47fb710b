"""Random arms for the tests of robots, as strategies of hypothesis and from a generator."""

import numpy as np
from hypothesis import strategies as st

from workbench.arms.mechanics import Link, PlanarArm, SpatialArm, SpatialLink
from workbench.arms.mechanics.planar_arm import PointMass
from workbench.arms.mechanics.spatial_vectors import from_angles, moments
from workbench.blocks.loop.instruments import Instruments, Limit, Sensor

numbers = st.floats(0.1, 4.0)
shifts = st.floats(-1.0, 1.0)
angles = st.floats(-3.0, 3.0)
links = st.builds(Link, mass=numbers, length=numbers, com=shifts, offset=shifts, inertia=numbers)
point_masses = st.builds(PointMass, mass=numbers, length=numbers)
zeros = st.sampled_from(["down", "right", "up"])


@st.composite
def moving_arms(draw, most=4):
    """An arm of 1 to `most` links, and a state (q, qd) of it."""
    n = draw(st.integers(1, most))
    arm = PlanarArm(tuple(draw(links | point_masses) for _ in range(n)), draw(numbers), draw(zeros))
    q, qd = (np.array(draw(st.lists(angles, min_size=n, max_size=n))) for _ in range(2))
    return arm, q, qd


def random_arm(joints: int, rng: np.random.Generator) -> PlanarArm:
    """An arm of links with random mass, length, centre of mass, offset and inertia, and gravity 9.81."""
    return PlanarArm(
        tuple(Link(*rng.uniform([0.5, 0.3, -0.2, -0.3, 0.02], [5.0, 1.2, 0.8, 0.3, 0.6])) for _ in range(joints)),
        9.81,
        ("down", "right", "up")[int(rng.integers(3))],
    )


def random_tree(joints: int, rng: np.random.Generator, **extras) -> SpatialArm:
    """A spatial arm of hinges and slides about random axes, branching at random, and gravity 9.81."""

    def link(i: int) -> SpatialLink:
        axis = rng.normal(size=3)
        points = rng.uniform(-0.3, 0.3, (5, 3))  # of equal masses about the centre: any of their moments is a body's
        points -= points.mean(axis=0)
        inertia = 0.2 * (np.eye(3) * (points**2).sum() - points.T @ points)
        return SpatialLink(
            f"joint {i}",
            rng.uniform(0.5, 4.0),
            rng.uniform(-0.3, 0.3, 3),
            moments(inertia),
            position=rng.uniform(-0.5, 0.5, 3),
            axis=axis / np.linalg.norm(axis),
            rotation=from_angles(*rng.uniform(-3, 3, 3)),
            parent=int(rng.integers(max(-1, i - 3), i)) if i else -1,
            joint="prismatic" if rng.random() < 0.3 else "revolute",
            **extras,
        )

    return SpatialArm(tuple(link(i) for i in range(joints)))


def arm_instruments(joints, noise_q=0.0, noise_qd=0.0, quantum_q=0.0, quantum_qd=0.0, limit=None) -> Instruments:
    """Instruments of an arm of hinges: readings of q and qd with noise and steps, and a limit of the torque."""
    sensors = (("q", "rad", noise_q, quantum_q), ("qd", "rad/s", noise_qd, quantum_qd))
    each = [(name, unit, *(np.broadcast_to(x, joints) for x in numbers)) for name, unit, *numbers in sensors]
    most = None if limit is None else np.broadcast_to(limit, joints)
    bounds = () if most is None else (Limit("tau", "N m", -most, most),)
    return Instruments(tuple(Sensor(*one) for one in each), bounds)

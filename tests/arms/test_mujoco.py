"""M, C qd, G, accelerations and places of arms against MuJoCo, an independent engine."""

import numpy as np
import pytest

from tests.support.arms import random_arm, random_tree
from workbench.arms.dynamics import Dynamics
from workbench.arms.mechanics import robot
from workbench.arms.mechanics.planar_arm import DIRECTIONS
from workbench.arms.mechanics.spatial_vectors import tensor

mujoco = pytest.importorskip("mujoco")

# Both sides add up a few dozen double-precision terms; the error is measured against the largest of
# them (1e-16 each), and the acceleration is divided by a mass matrix of condition up to about 1e3.
CLOSE = 1e-12


def mjcf(arm) -> str:
    """The arm in MuJoCo's language: the plane is x to the right, z upward; hinges turn from x to z."""
    right, up = DIRECTIONS[arm.zero]
    along, left = np.array([right, 0, up]), np.array([-up, 0, right])
    opened, place = "", np.zeros(3)
    for link in arm.links:
        com, inertia = link.com * along + link.offset * left, f"{link.inertia!r} " * 3
        opened += (
            f'<body pos="{_row(place)}"><joint type="hinge" axis="0 -1 0"/>'
            f'<inertial pos="{_row(com)}" mass="{link.mass!r}" diaginertia="{inertia}"/>'
        )
        place = link.length * along
    return (
        f'<mujoco><compiler angle="radian"/><option gravity="0 0 {-arm.gravity!r}"/>'
        f"<worldbody>{opened}{'</body>' * arm.dof}</worldbody></mujoco>"
    )


def _row(vector) -> str:
    return " ".join(repr(float(x)) for x in vector)


def spatial_mjcf(arm) -> str:
    """A spatial arm in MuJoCo's language."""

    def below(parent: int) -> str:
        return "".join(body(i) for i, link in enumerate(arm.links) if link.parent == parent)

    def body(i: int) -> str:
        link, quaternion = arm.links[i], np.zeros(4)
        mujoco.mju_mat2Quat(quaternion, link.rotation.ravel())
        I = tensor(link.inertia)
        moments = [I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2]]
        kind = "slide" if link.joint == "prismatic" else "hinge"
        return (
            f'<body name="{link.name}" pos="{_row(link.position)}" quat="{_row(quaternion)}">'
            f'<joint name="{link.name}" type="{kind}" axis="{_row(link.axis)}" armature="{link.drive_inertia()!r}" '
            f'damping="{link.viscous or 0.0!r}"/>'
            f'<inertial pos="{_row(link.com)}" mass="{link.mass!r}" fullinertia="{_row(moments)}"/>'
            f"{below(i)}</body>"
        )

    return (
        f'<mujoco><compiler angle="radian"/><option gravity="0 0 {-arm.gravity!r}"/>'
        f"<worldbody>{below(-1)}</worldbody></mujoco>"
    )


class Engine:
    """MuJoCo's M, bias force and acceleration at a state; `order` are the numbers it gives our joints."""

    def __init__(self, xml, names=()):
        self.model = mujoco.MjModel.from_xml_string(xml)
        self.data = mujoco.MjData(self.model)
        self.order = [self.model.joint(name).dofadr[0] for name in names] or list(range(self.model.nv))

    def _at(self, q, qd, tau):
        for held, value in ((self.data.qpos, q), (self.data.qvel, qd), (self.data.qfrc_applied, tau)):
            held[self.order] = value
        mujoco.mj_forward(self.model, self.data)

    def mass_matrix(self, q):
        self._at(q, 0, 0)
        M = np.zeros((len(q), len(q)))
        mujoco.mj_fullM(self.model, self.data, M)
        return M[np.ix_(self.order, self.order)]

    def bias(self, q, qd):
        self._at(q, qd, 0)
        return self.data.qfrc_bias[self.order]

    def acceleration(self, q, qd, tau):
        self._at(q, qd, tau)
        return self.data.qacc[self.order]


@pytest.mark.parametrize("joints", [1, 2, 3, 4])
@pytest.mark.parametrize("seed", range(8))
def test_an_arm_moves_as_in_mujoco(joints, seed):
    rng = np.random.default_rng([joints, seed])
    arm = random_arm(joints, rng)
    ours, theirs = Dynamics.of(arm), Engine(mjcf(arm))
    for _ in range(10):
        q, qd, tau = rng.uniform(-3, 3, (3, joints)) * [[1.0], [2.0], [10.0]]
        M, C, G = ours.matrices(q, qd)
        np.testing.assert_allclose(M, theirs.mass_matrix(q), rtol=0, atol=CLOSE * np.abs(M).max())
        at_rest, in_motion = theirs.bias(q, np.zeros(joints)), theirs.bias(q, qd)
        weight = sum(link.mass for link in arm.links) * arm.gravity * sum(link.length + 1 for link in arm.links)
        np.testing.assert_allclose(G, at_rest, rtol=0, atol=CLOSE * weight)
        centrifugal = np.abs(M).max() * np.abs(qd).max() ** 2 * joints
        np.testing.assert_allclose(C @ qd, in_motion - at_rest, rtol=0, atol=CLOSE * (weight + centrifugal))
        qdd = ours.acceleration(q, qd, tau)
        size = np.linalg.cond(M) * np.abs(qdd).max()
        np.testing.assert_allclose(qdd, theirs.acceleration(q, qd, tau), rtol=0, atol=CLOSE * size)


SPATIAL = {name: lambda name=name: robot(name) for name in ("ur5", "panda", "scara")} | {
    f"tree {seed}": lambda seed=seed: random_tree(1 + seed, np.random.default_rng(seed)) for seed in range(8)
}


@pytest.mark.parametrize("make", SPATIAL.values(), ids=SPATIAL)
def test_a_spatial_arm_moves_as_in_mujoco(make):
    arm, rng = make(), np.random.default_rng(17)
    ours, theirs = Dynamics.of(arm), Engine(spatial_mjcf(arm), [link.name for link in arm.links])
    for _ in range(10):
        q, qd, tau = rng.uniform(-3, 3, (3, arm.dof)) * [[1.0], [2.0], [10.0]]
        M, C, G = ours.matrices(q, qd)
        np.testing.assert_allclose(M, theirs.mass_matrix(q), rtol=0, atol=CLOSE * np.abs(M).max())
        at_rest, in_motion = theirs.bias(q, np.zeros(arm.dof)), theirs.bias(q, qd)
        weight = sum(link.mass for link in arm.links) * arm.gravity * 3  # an arm reaches 3 m at most
        np.testing.assert_allclose(G, at_rest, rtol=0, atol=CLOSE * weight)
        centrifugal = np.abs(M).max() * np.abs(qd).max() ** 2 * arm.dof
        np.testing.assert_allclose(C @ qd, in_motion - at_rest, rtol=0, atol=CLOSE * (weight + centrifugal))
        qdd = ours.acceleration(q, qd, tau)
        size = np.linalg.cond(M) * np.abs(qdd).max()
        np.testing.assert_allclose(qdd, theirs.acceleration(q, qd, tau), rtol=0, atol=CLOSE * size)


def test_rotors_and_viscous_friction_act_as_in_mujoco():
    arm, rng = random_tree(4, np.random.default_rng(3), viscous=0.8, rotor=2e-4, gear=30.0), np.random.default_rng(2)
    ours, theirs = Dynamics.of(arm), Engine(spatial_mjcf(arm), [link.name for link in arm.links])
    for _ in range(10):
        q, qd, tau = rng.uniform(-2, 2, (3, 4))
        qdd = ours.acceleration(q, qd, tau)
        size = np.linalg.cond(ours.matrices(q, qd)[0]) * np.abs(qdd).max()
        np.testing.assert_allclose(qdd, theirs.acceleration(q, qd, tau), rtol=0, atol=CLOSE * size)

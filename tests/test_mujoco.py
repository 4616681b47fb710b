"""M, C qd, G and accelerations of planar arms against MuJoCo, an independent engine."""

import numpy as np
import pytest
from arms import random_arm

from workbench.core import Dynamics
from workbench.robots.kinematics import DIRECTIONS

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


class Engine:
    """MuJoCo's M, bias force and acceleration at a state."""

    def __init__(self, arm):
        self.model = mujoco.MjModel.from_xml_string(mjcf(arm))
        self.data = mujoco.MjData(self.model)

    def _at(self, q, qd, tau):
        self.data.qpos[:], self.data.qvel[:], self.data.qfrc_applied[:] = q, qd, tau
        mujoco.mj_forward(self.model, self.data)

    def mass_matrix(self, q):
        self._at(q, 0, 0)
        M = np.zeros((len(q), len(q)))
        mujoco.mj_fullM(self.model, self.data, M)
        return M

    def bias(self, q, qd):
        self._at(q, qd, 0)
        return self.data.qfrc_bias.copy()

    def acceleration(self, q, qd, tau):
        self._at(q, qd, tau)
        return self.data.qacc.copy()


@pytest.mark.parametrize("joints", [1, 2, 3, 4])
@pytest.mark.parametrize("seed", range(8))
def test_an_arm_moves_as_in_mujoco(joints, seed):
    rng = np.random.default_rng([joints, seed])
    arm = random_arm(joints, rng)
    ours, theirs = Dynamics.of(arm), Engine(arm)
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

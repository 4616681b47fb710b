from __future__ import annotations

import tempfile
from functools import partial
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from workbench.arms.dynamics import Dynamics
from workbench.arms.mechanics import urdf
from workbench.arms.mechanics.joint_tree import Joint, Solid, arm_of

from ..parts import ARM, signals

TEXT = """<robot name="r"><link name="base"/><link name="arm"><inertial><origin xyz="0 0 0.5"/><mass value="1"/>
<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
<joint name="hinge" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/></joint></robot>"""


FOLDER = tempfile.TemporaryDirectory()
FILE = Path(FOLDER.name) / "arm.urdf"
FILE.write_text(TEXT)


def calls() -> dict[str, Any]:
    eye, zero = np.eye(3), np.zeros(3)
    body = (0.1, 0.0, 0.0, 0.1, 0.0, 0.1)
    return {
        "Dynamics.of": partial(Dynamics.of, ARM, "arm", True),
        "parse": partial(urdf.parse, TEXT, 9.81, friction_speed=0.01),
        "Solid": partial(Solid, "arm", 1.0, zero, np.array(body)),
        "Joint": partial(Joint, "hinge", "base", "arm", "revolute", zero, eye, np.array([0.0, 0.0, 1.0]), 0.1, 0.1),
        "arm_of": partial(
            arm_of,
            [Solid("base"), Solid("arm", 1.0, zero, np.array(body))],
            [Joint("j", "base", "arm", "revolute")],
            9.8,
        ),
    }


def arguments() -> dict[str, Any]:
    return {
        **signals(),
        "SpatialLink.body.q": lambda link: ca.SX.sym("q"),
        "SpatialLink.friction.qd": lambda link: ca.SX.sym("v"),
    }

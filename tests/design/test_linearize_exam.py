"""Linear models of arms against reference derivatives in 60 digits, where that exam is beside this project."""

import json
from pathlib import Path

import control
import numpy as np
import pytest

from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import urdf
from workbench.blocks.loop import open_loop
from workbench.design import linearize
from workbench.design.linear import to_control
from workbench.design.linear.operating_point import row_of

SHARED = Path(__file__).parents[3] / "shared" / "exams" / "dynamics"
ROBOTS = ("paper_2r_pointmass", "cartpole", "scara_rrpr", "ur5", "panda_arm")


@pytest.mark.skipif(not SHARED.exists(), reason="the exams are not beside this project")
@pytest.mark.parametrize("name", ROBOTS)
def test_a_and_b_are_the_reference_derivatives(name):
    robot = json.loads((SHARED / "index.json").read_text(encoding="utf-8"))[name]
    with np.load(SHARED / robot["data"]) as file:
        data = dict(file)
    arm = urdf.read_urdf(SHARED / robot["urdf"], 9.81)
    order = [[link.name for link in arm.links].index(body["joint"]) for body in robot["bodies"]]
    n, back = arm.dof, np.argsort(order)
    ode = open_loop(Manipulator(arm, q=np.zeros(n)))
    worst = {"ours": 0.0, "python-control": 0.0}
    for s in range(len(data["q"])):
        x, u = np.concatenate([data["q"][s][back], data["qd"][s][back]]), data["tau_in"][s][back]
        models = {
            "ours": linearize(ode, 0.0, x, u=u),
            "python-control": control.linearize(to_control(ode, row_of(ode, None, u)), x, u),
        }
        for who, G in models.items():
            blocks = {"ddq_dq": G.A[n:, :n], "ddq_dqd": G.A[n:, n:], "ddq_dtau": G.B[n:]}
            for key, block in blocks.items():
                error = np.abs(block[np.ix_(order, order)] - data[key][s]).max() / data[f"scale_{key}"][s]
                worst[who] = max(worst[who], float(error))
    # the scale is the sum of the terms' sizes, so rounding alone is left; a forward difference has half its digits
    assert worst["ours"] < 1e-12, worst
    assert worst["python-control"] > 1e3 * worst["ours"]

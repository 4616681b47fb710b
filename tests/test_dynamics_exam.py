"""Planar arms against 60-digit references (../shared/exams/dynamics); skipped where these are absent."""

import importlib.util
import json
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from workbench.core import Dynamics
from workbench.robots import Link, PlanarArm

EXAM = Path(__file__).parents[2] / "shared" / "exams" / "dynamics" / "grade.py"
pytestmark = pytest.mark.skipif(not EXAM.exists(), reason="the exams are not beside this project")
PLANAR = ["paper_2r_pointmass", "planar_3r", "double_pendulum_simple"]


def grader():
    spec = importlib.util.spec_from_file_location("dynamics_grade", EXAM)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def bodies_of(name: str):
    return json.loads(EXAM.with_name("index.json").read_text())[name]["bodies"]


def planar_arm(bodies) -> PlanarArm:
    """The exam's chain as ours: hinges about one horizontal axis, links along the vertical at q = 0.

    A turn about the axis u moves a body along u x r; 'left' of a link's line is that direction at q = 0,
    as seen in the plane, for any of the zeros.
    """
    axis = np.array(bodies[0]["axis"])
    places = [np.array(b["placement_p"]) for b in bodies[1:]]
    # a point-mass link of no successor is as long as its centre of mass is far: the tip does not enter M, C, G
    lines = [*places, np.array(bodies[-1]["com"])]
    up = 1.0 if lines[0][2] > 0 else -1.0
    along = np.array([0.0, 0.0, up])
    left = np.cross(axis, along)
    links = []
    for body, line in zip(bodies, lines, strict=True):
        assert body["type"] == "R"
        np.testing.assert_array_equal(body["axis"], axis)
        np.testing.assert_array_equal(body["placement_R"], np.eye(3))
        assert axis[2] == 0
        assert abs(line @ left) < 1e-15
        com, inertia = np.array(body["com"]), np.array(body["inertia_com"])
        links.append(Link(body["mass"], line @ along, com @ along, com @ left, axis @ inertia @ axis))
    return PlanarArm(tuple(links), 9.81, "up" if up > 0 else "down")


def answers(arm: PlanarArm):
    """The functions that the grader asks for, the derivatives as exact Jacobians."""
    d, p = Dynamics.of(arm), Dynamics.of(arm).p.default
    third = ca.SX.sym("third", arm.dof)
    M, C, G = ca.substitute([d.M, d.C, d.G], [d.symbols], [ca.SX(p)])
    tau = M @ third + C @ d.qd + G
    ddq = ca.substitute(arm.acceleration(d.q, d.qd, third), d.symbols, ca.SX(p))

    def function(expression, *arguments):
        compiled = ca.Function("answer", list(arguments), [ca.densify(expression)])
        return lambda *numbers: np.array(compiled(*numbers)).squeeze()

    two, three = (d.q, d.qd), (d.q, d.qd, third)
    return {
        "M": lambda q: np.atleast_2d(function(M, d.q)(q)),
        "G": function(G, d.q),
        "C": lambda q, qd: np.atleast_2d(function(C, *two)(q, qd)),
        "Cqd": function(C @ d.qd, *two),
        "tau_id": function(tau, *three),
        "ddq": function(ddq, *three),
        "dtau_dq": function(ca.jacobian(tau, d.q), *three),
        "dtau_dqd": function(ca.jacobian(tau, d.qd), *three),
        "ddq_dq": function(ca.jacobian(ddq, d.q), *three),
        "ddq_dqd": function(ca.jacobian(ddq, d.qd), *three),
        "ddq_dtau": function(ca.jacobian(ddq, third), *three),
        "kinetic": function(arm.kinetic_energy(d.q, d.qd), *two),
        "potential": function(arm.potential_energy(d.q), d.q),
    }


@pytest.mark.parametrize("name", PLANAR)
def test_an_arm_agrees_with_the_references_to_the_graders_tolerances(name):
    exam = grader()
    arm = planar_arm(bodies_of(name))
    results = exam.grade_robot(name, answers(arm))
    failed = {key: result for key, result in results.items() if result["outcome"] != "pass"}
    assert not failed
    assert len(results) == 16


def test_a_wrong_arm_fails_the_exam():
    exam = grader()
    bodies = bodies_of("planar_3r")
    bodies[1]["com"] = [1e-9, 0.0, -0.2]
    results = exam.grade_robot("planar_3r", answers(planar_arm(bodies)))
    assert results["G"]["outcome"] == "FAIL"
    assert results["C"]["outcome"] == "FAIL"

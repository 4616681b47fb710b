"""The exam of rigid-body dynamics, as far as planar chains of hinges go."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import casadi as ca
import numpy as np

from workbench.core import Dynamics
from workbench.robots import Link, PlanarArm

from .graders import Loaded

Bodies = Sequence[Mapping[str, Any]]
GRAVITY = 9.81
EXACT = 1e-15  # how far off its plane a number may be that was printed in full


def planar_arm(bodies: Bodies) -> PlanarArm | None:
    """The exam's chain as ours, or None: hinges about one horizontal axis, links along the vertical at q = 0.

    A turn about the axis u moves a body along u x r; 'left' of a link's line is that direction at q = 0,
    as seen in the plane, for any of the zeros.
    """
    axis = np.array(bodies[0]["axis"])
    # a point-mass link of no successor is as long as its centre of mass is far: the tip does not enter M, C, G
    lines = [*(np.array(body["placement_p"]) for body in bodies[1:]), np.array(bodies[-1]["com"])]
    up = 1.0 if lines[0][2] > 0 else -1.0
    along = np.array([0.0, 0.0, up])
    left = np.cross(axis, along)
    links = []
    for body, line in zip(bodies, lines, strict=True):
        hinge = body["type"] == "R" and np.array_equal(body["axis"], axis) and axis[2] == 0
        if not (hinge and np.array_equal(body["placement_R"], np.eye(3)) and abs(line @ left) < EXACT):
            return None
        com, inertia = np.array(body["com"]), np.array(body["inertia_com"])
        links.append(Link(body["mass"], line @ along, com @ along, com @ left, axis @ inertia @ axis))
    return PlanarArm(tuple(links), GRAVITY, "up" if up > 0 else "down")


def answers(arm: PlanarArm) -> dict[str, Callable[..., Any]]:
    """The functions that the grader asks for, the derivatives as exact Jacobians."""
    d, p = Dynamics.of(arm), Dynamics.of(arm).p.default
    third = ca.SX.sym("third", arm.dof)
    M, C, G = ca.substitute([d.M, d.C, d.G], [d.symbols], [ca.SX(p)])
    tau = M @ third + C @ d.qd + G
    ddq = ca.substitute(arm.acceleration(d.q, d.qd, third), d.symbols, ca.SX(p))

    def function(expression: ca.SX, *arguments: ca.SX) -> Callable[..., Any]:
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


def arms(exam: Loaded) -> tuple[dict[str, PlanarArm], list[str]]:
    """The robots of an exam that are planar, as arms, and the names of all others."""
    found = {name: planar_arm(robot["bodies"]) for name, robot in exam.module.robots().items()}
    return {k: arm for k, arm in found.items() if arm is not None}, [k for k, arm in found.items() if arm is None]


def grade(exam: Loaded, planar: Mapping[str, PlanarArm]) -> tuple[bool, str]:
    """All functions of all planar robots."""
    failed, worst = [], 0.0
    for name, arm in planar.items():
        results = exam.module.grade_robot(name, answers(arm))
        failed += [f"{name} {key}" for key, result in results.items() if result["outcome"] != "pass"]
        worst = max(worst, *(r["error"] / r["tol"] for r in results.values() if r.get("tol", 0) > 0))
    passed = len(planar) - len({name.split()[0] for name in failed})
    text = f"{passed} of {len(planar)} robots, worst error {worst:.2g} of its tolerance"
    return not failed, text + (f"; failed: {', '.join(failed)}" if failed else "")

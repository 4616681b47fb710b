"""The exam of rigid-body dynamics: any tree of hinges and slides, through URDF and through the exam's own bodies."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from workbench.arms.dynamics import Dynamics
from workbench.arms.mechanics import PlanarArm, SpatialArm, urdf
from workbench.arms.mechanics.joint_tree import Joint, Solid, arm_of
from workbench.arms.mechanics.spatial_vectors import moments

from .graders import Loaded

Bodies = Sequence[Mapping[str, Any]]
Answers = dict[str, Callable[..., Any]]
GRAVITY = 9.81
KINDS = {"R": "revolute", "P": "prismatic"}


def from_bodies(bodies: Bodies) -> SpatialArm:
    """The exam's neutral description as an arm."""
    solids, joints = [Solid("the base")], []
    for body in bodies:
        six = moments(np.array(body["inertia_com"]))
        solids.append(Solid(body["joint"], body["mass"], np.array(body["com"]), six))
        carrier = "the base" if body["parent"] is None else bodies[body["parent"]]["joint"]
        place, R, axis = (np.array(body[key]) for key in ("placement_p", "placement_R", "axis"))
        joints.append(Joint(body["joint"], carrier, body["joint"], KINDS[body["type"]], place, R, axis))
    return arm_of(solids, joints, GRAVITY)


def answers(arm: PlanarArm | SpatialArm, order: Sequence[int]) -> Answers:
    """The functions that the grader asks for; its joint i is ours of number order[i]."""
    d = Dynamics.of(arm, symbolic=False)
    none, back = d.p.default, np.argsort(order)
    inverse, forward = d.inverse_dynamics, d.forward_dynamics
    two = [d.q, d.qd]
    force = arm.coriolis_force(*two) if isinstance(arm, SpatialArm) else d.C @ d.qd
    M, G, C, Cqd, T, U = (
        ca.Function("answer", two, [ca.densify(expression)])
        for expression in (d.M, d.G, d.C, force, arm.kinetic_energy(d.q, d.qd), arm.potential_energy(d.q))
    )

    def ours(function: Callable[..., Any], output: int | None = None) -> Callable[..., Any]:
        def answer(*vectors: Any) -> Any:
            found = function(*(np.asarray(v)[back] for v in vectors))
            value = np.array(found if output is None else found[output])
            if value.shape == (arm.dof, arm.dof):
                return value[np.ix_(order, order)]
            return value[order].ravel() if value.shape == (arm.dof, 1) else value.item()

        return answer

    def at_rest(function: ca.Function) -> Callable[..., Any]:
        return lambda q: function(q, np.zeros(arm.dof))

    return {
        "M": ours(at_rest(M)),
        "G": ours(at_rest(G)),
        "C": ours(C),
        "Cqd": ours(Cqd),
        "tau_id": ours(lambda *state: inverse(*state, none), 0),
        "ddq": ours(lambda *state: forward(*state, none), 0),
        "dtau_dq": ours(lambda *state: inverse(*state, none), 1),
        "dtau_dqd": ours(lambda *state: inverse(*state, none), 2),
        "ddq_dq": ours(lambda *state: forward(*state, none), 1),
        "ddq_dqd": ours(lambda *state: forward(*state, none), 2),
        "ddq_dtau": ours(lambda *state: forward(*state, none), 3),
        "kinetic": ours(T),
        "potential": ours(at_rest(U)),
    }


def through_urdf(exam: Loaded) -> dict[str, Answers]:
    """The robots of an exam that have a URDF file."""
    folder = Path(str(exam.module.__file__)).parent
    robots = exam.module.robots()
    return {k: _spatial(urdf.read_urdf(folder / r["urdf"], GRAVITY), r) for k, r in robots.items() if r.get("urdf")}


def through_bodies(exam: Loaded) -> dict[str, Answers]:
    """The robots of an exam by their bodies."""
    return {name: _spatial(from_bodies(robot["bodies"]), robot) for name, robot in exam.module.robots().items()}


def _spatial(arm: SpatialArm, robot: Mapping[str, Any]) -> Answers:
    names = [link.name for link in arm.links]
    return answers(arm, [names.index(body["joint"]) for body in robot["bodies"]])


def grade(exam: Loaded, robots: Mapping[str, Answers]) -> tuple[bool, str]:
    """All functions of all robots."""
    failed, worst = [], 0.0
    for name, functions in robots.items():
        results = exam.module.grade_robot(name, functions)
        failed += [f"{name} {key}" for key, result in results.items() if result["outcome"] != "pass"]
        worst = max(worst, *(r["error"] / r["tol"] for r in results.values() if r.get("tol", 0) > 0))
    passed = len(robots) - len({name.split()[0] for name in failed})
    text = f"{passed} of {len(robots)} robots, worst error {worst:.2g} of its tolerance"
    return not failed, text + (f"; failed: {', '.join(failed)}" if failed else "")

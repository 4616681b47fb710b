"""Measurements of the catalogue: operations, seconds of a core, and errors against other roads."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median
from time import process_time
from typing import Any

import casadi as ca
import numpy as np

import workbench as wb
from studies.b0_robots import mujoco_arm, sympy_chain

Arm = wb.arms.mechanics.PlanarArm | wb.arms.mechanics.SpatialArm
REPETITIONS, STATES, SEED = 5, 50, 4
LINKS = (2, 3, 4, 5, 6)
PATIENCE = 120.0  # s for one answer of SymPy


@dataclass(frozen=True)
class Robot:
    """One arm of the catalogue.

    Attributes
    ----------
    operations
        Of M, C, G, of all three together, of those with numbers for letters, and of tau; equal ones count once.
    making_seconds, derivation_seconds, differentiation_seconds
        Seconds of each repetition: to make the arm with its checks, to derive M, C, G and tau up to functions, and with
        all first derivatives of inverse and forward dynamics.
    by_energies, by_mujoco
        The largest error over random states, relative to the largest term.
    """

    name: str
    joints: int
    letters: int
    operations: tuple[int, ...]
    making_seconds: tuple[float, ...]
    derivation_seconds: tuple[float, ...]
    differentiation_seconds: tuple[float, ...]
    by_energies: float
    by_mujoco: float | None


def seconds(work: Callable[[], object]) -> tuple[float, ...]:
    """The seconds of a core that a call takes, in each of several repetitions."""
    spent = []
    for _ in range(REPETITIONS):
        begin = process_time()
        work()
        spent.append(process_time() - begin)
    return tuple(spent)


def differentiate(arm: Arm) -> object:
    """M, C and G over letters, their function, and the one that holds the derivatives of both directions."""
    rest, dynamics = np.zeros(arm.dof), wb.arms.Dynamics.of(arm)
    return dynamics.matrices(rest, rest), dynamics.acceleration(rest, rest, rest)


def robot(name: str) -> Robot:
    """Everything of one arm."""
    arm = wb.arms.mechanics.CATALOGUE[name]()
    rest, letters, numbers = (
        np.zeros(arm.dof),
        wb.arms.Dynamics.of(arm, name),
        wb.arms.Dynamics.of(arm, name, symbolic=False),
    )
    matrices = (letters.M, letters.C, letters.G)
    together = [ca.horzcat(*matrices), ca.horzcat(numbers.M, numbers.C, numbers.G), letters.tau]
    return Robot(
        name,
        arm.dof,
        letters.p.size,
        tuple(map(operations, (*matrices, *together))),
        making_seconds=seconds(wb.arms.mechanics.CATALOGUE[name]),
        derivation_seconds=seconds(lambda: wb.arms.Dynamics.of(arm).matrices(rest, rest)),
        differentiation_seconds=seconds(lambda: differentiate(arm)),
        by_energies=by_energies(arm, numbers),
        by_mujoco=by_mujoco(arm, numbers) if mujoco_arm.HAS_MUJOCO else None,
    )


def operations(expression: ca.SX) -> int:
    """The additions, products, sines and so on that a value takes, equal ones once."""
    return sum(bool(node.operands) for node in wb.notation.walk(expression, cse=True).nodes)


def states(joints: int) -> wb.Array:
    """Random positions, velocities and accelerations, (STATES, 3, n)."""
    spread = np.array([[np.pi], [2.0], [5.0]])
    return np.asarray(np.random.default_rng(SEED).uniform(-1, 1, (STATES, 3, joints)) * spread)


def by_energies(arm: Arm, dynamics: wb.arms.Dynamics) -> float:
    """M qdd + C qd + G against Lagrange's equation of the energies."""
    q, qd, qdd = (ca.SX.sym(name, arm.dof) for name in ("q", "qd", "qdd"))
    tau = wb.arms.mechanics.lagrange.torque(arm.kinetic_energy(q, qd), arm.potential_energy(q), q, qd, qdd)
    other = ca.Function("lagrange", [q, qd, qdd], [tau])
    worst = 0.0
    for at_q, at_qd, at_qdd in states(arm.dof):
        M, C, G = dynamics.matrices(at_q, at_qd)
        size = np.abs(M) @ np.abs(at_qdd) + np.abs(C) @ np.abs(at_qd) + np.abs(G)
        gap = M @ at_qdd + C @ at_qd + G - np.array(other(at_q, at_qd, at_qdd)).ravel()
        worst = max(worst, float(np.max(np.abs(gap)) / np.max(size)))
    return worst


def by_mujoco(arm: Arm, dynamics: wb.arms.Dynamics) -> float:
    """M, and C qd + G, against MuJoCo."""
    engine, worst = mujoco_arm.engine(arm), 0.0
    for q, qd, _ in states(arm.dof):
        M, C, G = dynamics.matrices(q, qd)
        theirs, bias = engine(q, qd)
        size = np.max(np.abs(C) @ np.abs(qd) + np.abs(G))
        gaps = np.max(np.abs(M - theirs)) / np.max(np.abs(M)), np.max(np.abs(C @ qd + G - bias)) / size
        worst = max(worst, float(max(gaps)))
    return worst


def chain_function(joints: int) -> ca.Function:
    """M, C and G of the chain as a function, all its numbers being arguments: the rival of SymPy's."""
    lifted = wb.core.lift(wb.arms.mechanics.planar(joints))
    q, qd = (wb.Layout((wb.core.Entry(letter, np.zeros(joints)),)).symbols() for letter in ("q", "qd"))
    arm = lifted.block
    matrices = [arm.mass_matrix(q), arm.coriolis_matrix(q, qd), arm.gravity_vector(q)]
    return ca.Function("dynamics", [q, qd, lifted.symbols], matrices, {"cse": True})


@dataclass(frozen=True)
class Chain:
    """A planar chain of so many links: our seconds to M, C and G, and those of SymPy, method by method.

    `bias` are its seconds to M and C qd + G, `matrices` to M, C and G; None where it has no answer. `error` is the
    largest difference between both at one state, relative to the largest entry.
    """

    links: int
    ours: float
    bias: tuple[float | None, ...]
    matrices: tuple[float | None, ...]
    error: float | None

    @property
    def ratio(self) -> float | None:
        """The ratio of our speed to that of the faster of SymPy's methods."""
        known = [found for found in self.matrices if found is not None]
        return min(known) / self.ours if known else None


def chain(links: int) -> Chain:
    """Everything of one length."""
    answers = [by_sympy(method, links) for method in sympy_chain.METHODS]
    ours, errors = wb.arms.Dynamics.of(wb.arms.mechanics.planar(links)).matrices(*sympy_chain.values(links)), []
    for answer in filter(None, answers):
        theirs = (np.array(answer["at"][letter]) for letter in "MCG")
        errors += [np.max(np.abs(x - y)) / np.max(np.abs(x)) for x, y in zip(ours, theirs, strict=True)]
    bias, matrices = (
        tuple(None if answer is None else float(answer[part]) for answer in answers) for part in ("bias", "matrices")
    )
    return Chain(
        links, median(seconds(lambda: chain_function(links))), bias, matrices, max(map(float, errors), default=None)
    )


def by_sympy(method: str, links: int) -> dict[str, Any] | None:
    """The answer of `sympy_chain` in a process of its own; None where SymPy is missing, or beyond our patience."""
    if importlib.util.find_spec("sympy") is None:
        return None
    line = [sys.executable, sympy_chain.__file__, method, str(links)]
    try:
        done = subprocess.run(line, stdout=subprocess.PIPE, check=True, text=True, timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        return None
    found: dict[str, Any] = json.loads(done.stdout)
    return found

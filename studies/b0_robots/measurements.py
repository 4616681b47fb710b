"""What is measured of the catalogue: operations, seconds of a core, and errors against other roads."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from statistics import median
from time import process_time

import casadi as ca
import numpy as np

from studies.b0_robots import mujoco_arm, sympy_chain
from workbench.core import Dynamics, Entry, Layout, lift
from workbench.notation.program import walk
from workbench.robots import CATALOGUE, PlanarArm, SpatialArm, lagrange
from workbench.robots.arm_catalogue import planar
from workbench.validation.refusals import Array

Arm = PlanarArm | SpatialArm
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
    made, derived, differentiated
        Seconds to make the arm with its checks, to derive M, C, G and tau up to functions, and to add all
        first derivatives of inverse and forward dynamics; None where it fails.
    by_energies, by_mujoco
        The largest error over random states, relative to the largest term.
    """

    name: str
    joints: int
    letters: int
    operations: tuple[int, ...]
    made: float
    derived: float
    differentiated: float
    by_energies: float
    by_mujoco: float | None


def seconds(what: Callable[[], object]) -> float:
    """The seconds of a core that a call takes: the median of several."""
    return median(process_time() - begin for begin in _begun(what))


def _begun(what: Callable[[], object]) -> Iterator[float]:
    for _ in range(REPETITIONS):
        begin = process_time()
        what()
        yield begin


def derivation(arm: Arm) -> tuple[float, float]:
    """The seconds to numbers of M, C and G over letters, and those to all first derivatives too: medians."""
    whiles = []
    rest = np.zeros(arm.dof)
    for _ in range(REPETITIONS):
        begin = process_time()
        dynamics = Dynamics.of(arm)
        dynamics.matrices(rest, rest)
        middle = process_time()
        dynamics.acceleration(rest, rest, rest)  # its function holds the derivatives of both directions
        whiles.append((middle - begin, process_time() - begin))
    first, both = zip(*whiles, strict=True)
    return median(first), median(both)


def robot(name: str) -> Robot:
    """Everything of one arm."""
    arm = CATALOGUE[name]()
    letters, numbers = Dynamics.of(arm, name), Dynamics.of(arm, name, symbolic=False)
    matrices = (letters.M, letters.C, letters.G)
    together = [ca.horzcat(*matrices), ca.horzcat(numbers.M, numbers.C, numbers.G), letters.tau]
    return Robot(
        name,
        arm.dof,
        letters.p.size,
        tuple(map(operations, (*matrices, *together))),
        seconds(CATALOGUE[name]),
        *derivation(arm),
        by_energies(arm, numbers),
        by_mujoco(arm, numbers) if mujoco_arm.INSTALLED else None,
    )


def operations(expression: ca.SX) -> int:
    """The additions, products, sines and so on that a value takes, equal ones once."""
    return sum(bool(node.operands) for node in walk(expression, cse=True).nodes)


def states(joints: int) -> Array:
    """Random positions, velocities and accelerations, (STATES, 3, n)."""
    spread = np.array([[np.pi], [2.0], [5.0]])
    return np.asarray(np.random.default_rng(SEED).uniform(-1, 1, (STATES, 3, joints)) * spread)


def by_energies(arm: Arm, dynamics: Dynamics) -> float:
    """M qdd + C qd + G against Lagrange's equation of the energies."""
    q, qd, qdd = (ca.SX.sym(name, arm.dof) for name in ("q", "qd", "qdd"))
    tau = lagrange.torque(arm.kinetic_energy(q, qd), arm.potential_energy(q), q, qd, qdd)
    other = ca.Function("lagrange", [q, qd, qdd], [tau])
    worst = 0.0
    for at_q, at_qd, at_qdd in states(arm.dof):
        M, C, G = dynamics.matrices(at_q, at_qd)
        size = np.abs(M) @ np.abs(at_qdd) + np.abs(C) @ np.abs(at_qd) + np.abs(G)
        gap = M @ at_qdd + C @ at_qd + G - np.array(other(at_q, at_qd, at_qdd)).ravel()
        worst = max(worst, float(np.max(np.abs(gap)) / np.max(size)))
    return worst


def by_mujoco(arm: Arm, dynamics: Dynamics) -> float:
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
    """M, C and G of the chain as a function, all its numbers being arguments: what SymPy is held against."""
    lifted = lift(planar(joints))
    q, qd = (Layout((Entry(letter, np.zeros(joints)),)).symbols() for letter in ("q", "qd"))
    arm = lifted.block
    matrices = [arm.mass_matrix(q), arm.coriolis_matrix(q, qd), arm.gravity_vector(q)]
    return ca.Function("dynamics", [q, qd, lifted.symbols], matrices, {"cse": True})


@dataclass(frozen=True)
class Answer:
    """SymPy's: seconds to M and the bias C qd + G, those to M, C and G, and how far these are from ours."""

    bias: float
    matrices: float
    error: float


@dataclass(frozen=True)
class Chain:
    """A planar chain of so many links: our seconds to M, C and G, and what SymPy answers by each of its methods."""

    links: int
    ours: float
    sympy: Mapping[str, Answer | None]

    @property
    def ratio(self) -> float | None:
        """How many times as fast we are as the faster of SymPy's methods."""
        known = [answer.matrices for answer in self.sympy.values() if answer is not None]
        return min(known) / self.ours if known else None


def chain(links: int) -> Chain:
    """Everything of one length."""
    return Chain(links, seconds(partial(chain_function, links)), {m: by_sympy(m, links) for m in sympy_chain.METHODS})


def by_sympy(method: str, links: int) -> Answer | None:
    """What `sympy_chain` measures, in a process of its own; None where SymPy is missing, or beyond our patience."""
    if importlib.util.find_spec("sympy") is None:
        return None
    line = [sys.executable, sympy_chain.__file__, method, str(links)]
    try:
        done = subprocess.run(line, stdout=subprocess.PIPE, check=True, text=True, timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        return None
    found = json.loads(done.stdout)
    ours = Dynamics.of(planar(links)).matrices(*sympy_chain.values(links))
    pairs = zip(ours, (np.array(found["at"][letter]) for letter in "MCG"), strict=True)
    error = max(float(np.max(np.abs(x - y)) / np.max(np.abs(x))) for x, y in pairs)
    return Answer(found["bias"], found["matrices"], error)

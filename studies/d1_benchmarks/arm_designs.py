"""Linear laws for the paper's arm, each designed for the crossovers of one of the six laws of the paper."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

import workbench as wb
from studies.d1_benchmarks.linear_systems import error_law
from studies.paper.entrants import ENTRANTS, READINGS, Entrant
from studies.paper.laws import ARM
from studies.paper.scenarios import HELD_OUT, Scenario

# The numbers of the six laws as report a8 tuned them for raw readings (its table `numbers_readings`), in the order of
# the numbers of its entrants. A test compares them with that table.
TUNED = {
    "AOSMC-RGS": (9.819875, 8.441703, 7.640544, 139.7006, 1.803166, 6705.045, 612519.0),
    "PID": (1298.874, 1787.874, 42.78918, 12.04582, 102.7712, 10.64347),
    "SMC": (9.202703, 14.18913, 13.22338, 667.2112, 346.6264),
    "ASMC": (10.35158, 9.570829, 7.35503, 282.0878, 7.153777),
    "Fuzzy-ASMC": (9.891748, 8.192226, 2.233593, 94.67005, 1.132391, 0.01356219),
    "RBF-ASMC": (7.423201, 7.967442, 16.71689, 260.2641, 4.584047, 9448.589, 30.73697),
}
ADAPTING = ("K", "P", "W")  # states of the laws that learn; the linear loop has them at their first values
INTEGRATING, REGULATED = "LQR with integrals", "LQR + model"
DESIGNS = (INTEGRATING, REGULATED)
WITHIN = 1e-3  # relative, of a crossover that is to be matched
ROUNDS = 40
SLOW = 0.5  # 1/s, at which the integrals of the position errors count as much as the errors themselves
POWER = -4.0  # of a crossover, to which the weight of its torque is nearly proportional


@dataclass(frozen=True)
class Crossovers:
    """The highest gain crossover of each torque while the other loop is closed, in rad/s, and the larger Ms."""

    omega: tuple[float, ...]
    Ms: float


def entrant(law: str) -> Entrant:
    """A law of the paper behind raw readings, as in report a8."""
    return next(one for one in ENTRANTS[READINGS.key] if one.name == law)


def law_loop(law: str, scenario: Scenario) -> wb.DigitalLoop:
    """One of the six laws in a scenario, with its tuned numbers."""
    one = entrant(law)
    return one.loop(scenario, dict(zip((number.name for number in one.tuned_numbers), TUNED[law], strict=True)))


def crossovers(loop: wb.DigitalLoop) -> Crossovers:
    """The crossovers of a loop at rest, with gains that adapt held at their first values."""
    held = tuple(
        name for name in loop.ode().states.names if name.startswith("controller.") and name.split(".")[-1] in ADAPTING
    )
    margins = wb.linear_loop(loop, freeze=held).margins().values()
    omega = tuple(max(one.frequency.value for one in found.gain_crossovers) for found in margins)
    return Crossovers(omega, max(found.Ms.gain.value for found in margins))


@lru_cache
def law_crossovers(law: str) -> Crossovers:
    """The crossovers of one of the six laws, with the arm at rest where the paper's first scenario starts."""
    return crossovers(law_loop(law, HELD_OUT[0].at_rest))


@dataclass(frozen=True)
class ArmModel:
    """The arm near rest, x' = A x + B (tau - u0), with the positions and the velocities as its states."""

    A: wb.Array
    B: wb.Array
    u0: wb.Array


@lru_cache
def arm_at_rest() -> ArmModel:
    """The arm of the model at rest in that pose, from its torques to its positions and velocities."""
    start = np.array(HELD_OUT[0].start)
    plant = wb.open_loop(wb.Manipulator(ARM, q=start))
    point = wb.linear.operating_point(plant, {"q": start, "qd": np.zeros(2)})
    linear = wb.linearize(plant, 0.0, point.x, u=point.u, at_rest=True)
    return ArmModel(linear.A, linear.B, point.u)


@dataclass(frozen=True)
class LinearDesign:
    """A linear law by its kind, and the weights of both torques in its quadratic cost."""

    kind: str
    weights: tuple[float, ...]

    def loop(self, scenario: Scenario) -> wb.DigitalLoop:
        """The law in a scenario, on raw readings like the six laws."""
        law = integrating_law(self) if self.kind == INTEGRATING else regulated_law(self)
        return scenario.loop(READINGS.observer, law)


@lru_cache
def matching_design(kind: str, law: str) -> LinearDesign:
    """The linear design of a kind that has the crossovers of a law."""
    wanted, still = np.array(law_crossovers(law).omega), HELD_OUT[0].at_rest
    weights, found = 1e-4 * np.ones(2), wanted
    for _ in range(ROUNDS):
        design = LinearDesign(kind, tuple(weights.tolist()))
        found = np.array(crossovers(design.loop(still)).omega)
        if np.abs(found / wanted - 1).max() < WITHIN:
            return design
        weights = weights * (wanted / found) ** POWER
    raise wb.linear.DesignError(
        f"`matching_design({kind!r}, {law!r})` did not reach {wanted} rad/s; it stands at {found}."
    )


def regulated_law(design: LinearDesign) -> wb.Controller:
    """The LQR for unit weights of the positions and the weights of the torques, beside the torque of the model."""
    model = arm_at_rest()
    K = wb.lqr(model.A, model.B, Q=np.diag([1.0, 1.0, 0.0, 0.0]), R=np.diag(design.weights)).K
    return wb.ArmStateFeedback(ARM, K[:, :2], K[:, 2:])


def integrating_law(design: LinearDesign) -> wb.Controller:
    """The LQR with the integrals of the position errors as states, which uses no model while it runs."""
    model = arm_at_rest()
    weights = np.diag([1.0, 1.0, 0.0, 0.0, SLOW**2, SLOW**2])
    of_positions = np.hstack([np.eye(2), np.zeros((2, 2))])
    A = np.block([[model.A, np.zeros((4, 2))], [of_positions, np.zeros((2, 2))]])
    B = np.vstack([model.B, np.zeros((2, 2))])
    K = wb.lqr(A, B, Q=weights, R=np.diag(design.weights)).K
    law = error_law(
        np.zeros((2, 2)), of_positions, K[:, 4:], K[:, :4], ["q[0]", "q[1]", "qd[0]", "qd[1]"], ["tau[0]", "tau[1]"]
    )
    return replace(law, u0=model.u0)

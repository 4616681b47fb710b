"""The problems on which a predictive law is counted: plants of 2 to 16 states whose inputs have limits."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import casadi as ca
import numpy as np

import workbench as wb

HORIZONS = (4, 16, 64)
PUSHED, IDLE = STATES_OF_RUN = ("pushed", "idle")  # a disturbance takes the inputs to their limits, or never does
IDLE_SHARE = 0.02  # of the disturbance
HOVER = 98.1  # N, the weight of the rocket
THRUST_CONE = wb.ConeLimit(("u[0]", "u[1]"), "u[2]", slope=0.25, offset=0.25 * HOVER)


@wb.block
class DrivenPlant(wb.Plant):
    """A linear plant under a disturbance: x' = A x + B u + d (sin omega t + sin 2.3 omega t)."""

    A: np.ndarray = wb.parameter(shape=("n", "n"), unit="1/s")
    B: np.ndarray = wb.parameter(shape=("n", "m"), unit="1/s")
    d: np.ndarray = wb.parameter(shape=("n",), unit="1/s")
    omega: float = wb.parameter(unit="rad/s")
    s: np.ndarray = wb.initial(default=np.zeros(2), unit="1", shape=("n",))

    @property
    def inputs(self) -> wb.Layout:
        """The inputs u."""
        count = self.B.shape[1]
        return wb.Layout((wb.core.Entry("u", np.zeros(count) if count > 1 else np.zeros(()), "1"),))

    @property
    def outputs(self) -> wb.Layout:
        """All states are measured."""
        return self.states

    def rate(self, t, x, u):  # type: ignore[no-untyped-def]
        """The derivative of the states."""
        wave = ca.sin(self.omega * t) + ca.sin(2.3 * self.omega * t)
        return {"s": self.A @ x.s + self.B @ ca.vertcat(u.u) + self.d * wave}


@dataclass(frozen=True, eq=False)
class PredictiveProblem:
    """A plant x' = A x + B u with a period [s], weights, limits of the inputs, and the disturbance that pushes it.

    The limits are deviations from the rest: numbers for all inputs, or one for each. A cone is of the inputs u[i].
    """

    name: str
    A: wb.Array
    B: wb.Array
    period: float
    Q: wb.Array
    R: wb.Array
    low: float | wb.Array
    high: float | wb.Array
    push: wb.Array
    omega: float
    cones: tuple[wb.ConeLimit, ...] = ()

    @property
    def sizes(self) -> tuple[int, int]:
        """The numbers of states and of inputs."""
        n, m = self.B.shape
        return n, m

    def design(self, horizon: int) -> wb.planning.PredictiveDesign:
        """The design, with its own number of sweeps."""
        plant = self.plant(0.0)
        linear = wb.linearize(wb.open_loop(plant), t=0.0, x=np.zeros(len(self.A)), at_rest=True)
        ends = (np.broadcast_to(end, self.sizes[1]).tolist() for end in (self.low, self.high))
        limits = dict(zip(linear.input_labels, zip(*ends, strict=True), strict=True))
        return wb.predictive_design(linear, self.period, self.Q, self.R, horizon, limits=limits, cones=self.cones)

    def plant(self, share: float) -> DrivenPlant:
        """The plant under a share of the disturbance."""
        return DrivenPlant(A=self.A, B=self.B, d=share * self.push, omega=self.omega, s=np.zeros(len(self.A)))

    def loop(self, horizon: int, run: str) -> wb.SampledSystem:
        """The loop in a computer."""
        plant = self.plant(1.0 if run == PUSHED else IDLE_SHARE)
        law = wb.ModelPredictive.of(plant, self.design(horizon))
        return wb.ClosedLoop(plant, observer=wb.FullState.of(plant), controller=law).digital(self.period)


def _double_integrator() -> PredictiveProblem:
    A, B = np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[0.0], [1.0]])
    Q, R, push = np.diag([1.0, 0.1]), np.array([[0.1]]), np.array([0.0, 0.55])
    return PredictiveProblem("double integrator", A, B, 0.1, Q, R, -1.0, 1.0, push, 0.5)


def _cart_pole() -> PredictiveProblem:
    point = wb.linearize(wb.open_loop(wb.CartPole()), t=0.0, x=np.zeros(4), at_rest=True)
    A, B = np.array(point.A), np.array(point.B)
    Q, R = np.diag([10.0, 1.0, 10.0, 1.0]), np.array([[0.1]])
    return PredictiveProblem("cart-pole", A, B, 0.02, Q, R, -3.0, 3.0, 1.4 * B[:, 0], 2.0)


def _masses(count: int, inputs: int, size: float) -> PredictiveProblem:
    """Masses of 1 kg in a row between two walls, on springs of 1 N/m, with forces between neighbours."""
    springs = -2 * np.eye(count) + np.eye(count, k=1) + np.eye(count, k=-1)
    A = np.block([[np.zeros((count, count)), np.eye(count)], [springs, -0.05 * np.eye(count)]])
    forces = np.zeros((count, inputs))
    for j in range(inputs):
        i = round(j * (count - 2) / max(inputs - 1, 1))
        forces[i, j], forces[i + 1, j] = 1.0, -1.0
    push = np.concatenate([np.zeros(count), size * (np.arange(count) % 3 - 0.7)])
    B = np.vstack([np.zeros((count, inputs)), forces])
    return PredictiveProblem(f"{count} masses", A, B, 0.5, np.eye(2 * count), np.eye(inputs), -0.5, 0.5, push, 0.6)


def _rocket(push: tuple[float, float, float], cones: tuple[wb.ConeLimit, ...] = ()) -> PredictiveProblem:
    """The lander of rocket_landing/gen_rocket.py in mcu-solver-benchmarks, 10 kg, about its hover.

    Its thrusts are -10 to 105 N. The benchmark plans its descent; here a disturbance [m/s^2] pushes it.
    """
    A, B = np.eye(6, k=3), np.vstack([np.zeros((3, 3)), 0.1 * np.eye(3)])
    low, high = np.array([-10.0, -10.0, -10.0 - HOVER]), np.array([105.0, 105.0, 105.0 - HOVER])
    name, shaken = "rocket with its cone" if cones else "rocket", np.array([0.0, 0.0, 0.0, *push])
    return PredictiveProblem(name, A, B, 0.05, 1e3 * np.eye(6), np.eye(3), low, high, shaken, 0.8, cones)


@cache
def problems() -> tuple[PredictiveProblem, ...]:
    """All problems, by the number of their states."""
    rockets = _rocket((0.2, 0.1, -0.4)), _rocket((-1.6, -1.0, -0.4), (THRUST_CONE,))
    return (_double_integrator(), _cart_pole(), *rockets, _masses(4, 2, 0.75), _masses(8, 3, 0.3))

"""Closed loops of predictive laws: a cart with a pole that follows steps within limits, and what they cost."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

import workbench as wb

PERIOD, STAGES = 0.02, 20  # s
Q, R = np.diag([5000.0, 0.0, 100.0, 0.0]), np.array([[1.0]])
STATES = ("x", "xd", "phi", "phid")
STARTS = np.array([0.1, 0.1, 0.03, 0.1])  # the largest of each, to both sides
LEVELS = (0.21, 0.25)  # m, the least and the largest step of the reference, to both sides
STEP_EVERY = 50  # periods between two steps: to the level, and back to 0
FALLEN = 1.0  # rad, from which no force within the limits brings the pole back


class Runs(NamedTuple):
    """The errors e (B, periods, 4) at the begin of each period, and the forces F (B, periods).

    `last` are the states (B, nx) at the end.
    """

    e: wb.Array
    F: wb.Array
    last: wb.Array

    @property
    def is_lost(self) -> wb.Array:
        """True (B,) for loops whose pole falls."""
        return np.asarray(~(np.abs(self.e[:, :, 2]) < FALLEN).all(axis=1))


@dataclass(frozen=True, eq=False)
class Starts:
    """Starts (B, 4) of loops, and the levels (B,) in m of the steps of their references."""

    states: wb.Array
    levels: wb.Array

    def __len__(self) -> int:
        return len(self.levels)

    def part(self, places: slice | wb.core.Integers) -> Starts:
        """Some of them."""
        return Starts(self.states[places], self.levels[places])

    @staticmethod
    def draw(count: int, seed: int) -> Starts:
        """So many starts, each number drawn evenly."""
        even = np.random.default_rng(seed)
        states = even.uniform(-1, 1, (count, 4)) * STARTS
        return Starts(states, even.uniform(*LEVELS, count) * even.choice([-1.0, 1.0], count))


@dataclass(frozen=True, eq=False)
class PredictiveCase:
    """The loop of a cart-pole and a predictive law with limits of the force and, at a `soft_weight`, of states.

    Both ends of a limit have the same distance from 0.

    The reference of x steps to a level and back to 0, each second. `sweeps` are those of the law, or None for the
    number that its design chooses.
    """

    limits: Mapping[str, tuple[float, float]]
    soft_weight: float | None = None
    periods: int = 500
    sweeps: int | None = None

    @cached_property
    def plant(self) -> wb.CartPole:
        """The cart and the pole."""
        return wb.CartPole()

    @cached_property
    def design(self) -> wb.planning.PredictiveDesign:
        """The design for the plant linearised upright."""
        rest = wb.linearize(wb.open_loop(self.plant), t=0.0, x=np.zeros(4), at_rest=True)
        return wb.predictive_design(
            rest, PERIOD, Q, R, STAGES, limits=self.limits, soft_weight=self.soft_weight, sweeps=self.sweeps
        )

    @cached_property
    def step(self) -> wb.core.StepMap:
        """A period of the loop under the law."""
        return self._period(wb.ModelPredictive.of(self.plant, self.design, follow=("x",)), wb.Instruments())

    @cached_property
    def clipped_step(self) -> wb.core.StepMap:
        """A period of the loop under LQR of the same weights, whose force is clipped."""
        K, plant = self.design.problem.K, self.plant
        law = wb.StateFeedback(plant.states, plant.inputs, K, np.zeros(4), np.zeros(1), follow=("x",))
        return self._period(law, wb.Instruments.of(plant, limit={"F": self.limits["F"]}))

    def _period(self, law: wb.Controller, instruments: wb.Instruments) -> wb.core.StepMap:
        """A period of 20 ms: the law once, and the plant by one step of RK4."""
        wave = wb.SquareWave("x", "m", [LEVELS[1]], 1 / (STEP_EVERY * PERIOD))
        loop = wb.ClosedLoop(self.plant, observer=wb.FullState.of(self.plant), controller=law, reference=wave)
        return loop.digital(PERIOD, instruments).step(1)

    def rows(self, step: wb.core.StepMap, starts: Starts) -> tuple[wb.Array, wb.Array]:
        """p (B, np) and x0 (B, nx) of some loops."""
        names = (f"plant.{name}" for name in STATES)
        x0 = step.states.pack(dict(zip(names, starts.states.T, strict=True)))
        return step.parameters.pack({"reference.amplitude": starts.levels[:, np.newaxis]}), x0

    def references(self, starts: Starts) -> wb.Array:
        """The references (B, periods) of x in m."""
        is_high = np.arange(self.periods) // STEP_EVERY % 2 == 0
        return np.asarray(starts.levels[:, np.newaxis] * is_high)

    def run(self, step: wb.core.StepMap, starts: Starts) -> Runs:
        """All periods of some loops."""
        p, x0 = self.rows(step, starts)
        x = wb.simulate(step, p, x0, until=self.periods * PERIOD, every=PERIOD).x
        e = x[:, :-1, :4].copy()
        e[:, :, 0] -= self.references(starts)
        F = x[:, 1:, step.states.slice("hold.F")][:, :, 0]
        return Runs(e, F, x[:, -1])

    def ends(self, step: wb.core.StepMap, starts: Starts) -> wb.Array:
        """The states (B, nx) at the end of some loops, with nothing kept before."""
        p, x0 = self.rows(step, starts)
        until = self.periods * PERIOD
        return np.asarray(wb.simulate(step, p, x0, until=until, every=until).x[:, -1])

    def costs(self, runs: Runs) -> wb.Array:
        """The costs (B,) of loops, with w s^2 for each violation s of a soft limit; infinite where a pole falls."""
        e, weight = runs.e, self.soft_weight or 0.0
        cost = np.einsum("bki,ij,bkj->b", e, Q, e) + R[0, 0] * np.sum(runs.F**2, axis=1)
        cost = cost + weight * np.sum(self._violations(e) ** 2, axis=(1, 2))
        return np.where(runs.is_lost, np.inf, cost)

    def active(self, runs: Runs) -> wb.Array:
        """The share (B,) of the periods with the force at a limit, or a state beyond a soft one."""
        acts = (np.abs(runs.F) >= self.limits["F"][1]) | (self._violations(runs.e) > 0).any(axis=2)
        return np.asarray(acts.mean(axis=1))

    def _violations(self, e: wb.Array) -> wb.Array:
        """The violations (B, periods, rows) of soft limits, which are those of states whose error is their value."""
        rows = [np.abs(e[:, :, STATES.index(name)]) - end[1] for name, end in self.limits.items() if name != "F"]
        return np.maximum(np.stack(rows, axis=-1), 0.0) if rows else np.zeros((*e.shape[:2], 0))

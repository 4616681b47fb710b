"""The conditions of every law of a8, an arm that is not the model's, a computer, scenarios, and the cost of a run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

import workbench as wb
from studies.paper.card import CARD
from studies.paper.laws import REFERENCES

PERIOD = 1e-3  # s, of the computer
HORIZON = 6.0  # s
NOISE_Q, NOISE_QD = 1e-4, 5e-3  # rad, rad/s
LIMIT = (100.0, 50.0)  # N m, three times the largest torque of gravity
LEVEL = 2.0  # s, that a level of a square wave lasts


@dataclass(frozen=True)
class Scenario:
    """A wanted motion, and the conditions under which it is wanted."""

    name: str
    words: str
    reference: wb.Reference
    start: tuple[float, float]  # rad, of the arm
    mass: tuple[float, float] = (1.0, 1.0)  # true masses as shares of the model's, a payload in the second
    viscous: tuple[float, float] = (0.1, 0.1)  # N m s/rad, friction that no model knows
    coulomb: tuple[float, float] = (0.2, 0.2)  # N m
    push: float = 1.0  # amplitude of the disturbance as a share of the paper's
    pace: float = 1.0  # its frequency, the same
    noise: float = 1.0  # as a share of the usual one
    quantum: float = 0.0  # rad, of the positions read
    limit: tuple[float, float] = LIMIT  # N m, of the torque
    slow: int = 1  # ms, the period of the computer; from 2 on its torque comes a period late

    @property
    def period(self) -> float:
        return PERIOD * self.slow

    @property
    def jumps(self) -> bool:
        return isinstance(self.reference, wb.SquareWave)

    @property
    def plant(self) -> wb.Manipulator:
        masses, lengths = np.multiply(CARD["masses"], self.mass), CARD["lengths"]
        return wb.Manipulator(
            wb.arms.mechanics.PlanarArm(tuple(map(wb.arms.mechanics.PointMass, masses, lengths)), CARD["gravity"]),
            q=self.start,
            qd=CARD["qd(0)"],
            disturbance=self.disturbance,
            friction=wb.arms.Friction(self.viscous, self.coulomb, speed=0.05),
        )

    @property
    def at_rest(self) -> Scenario:
        """The same arm and computer with the arm held where it starts, without disturbance and noise."""
        return replace(self, reference=wb.Constant("q", "rad", self.start), push=0.0, noise=0.0)

    @property
    def disturbance(self) -> wb.SineTorque | None:
        """The paper's disturbance with other amplitudes and frequencies; None without amplitude."""
        if not self.push:
            return None
        paper = "SS" if self.jumps else "FS"
        return wb.SineTorque(
            self.push * np.array(CARD[f"{paper}: disturbance amplitude"]),
            self.pace * np.array(CARD[f"{paper}: disturbance frequency"]),
            CARD[f"{paper}: disturbance phase"],
        )

    def loop(self, observer: wb.Observer, controller: wb.Controller) -> wb.DigitalLoop:
        closed = wb.ClosedLoop(self.plant, observer, controller, self.reference)
        instruments = wb.Instruments.of(
            closed.plant,
            noise={"q": self.noise * NOISE_Q, "qd": self.noise * NOISE_QD},
            quantum={"q": self.quantum},
            limit={"tau": (-np.array(self.limit), np.array(self.limit))},
        )
        return wb.DigitalLoop(closed, self.period, instruments, self.slow > 1)


FIRST, SECOND = REFERENCES["FS"], REFERENCES["SS"]
SLOW = wb.Sines("q", "rad", (0.6, 0.8), (1.5, 2.2), (0.3, 1.0))
FAST = wb.Sines("q", "rad", (0.9, 0.6), (3.5, 5.0))
LIGHT, HEAVY = (0.8, 0.8), (1.2, 1.2)
TRAINING = (  # both ends of the masses that are drawn: a light arm answers a torque with more speed, and chatters first
    Scenario("fs", "the paper's first scenario, masses 20 % below the model's", FIRST, CARD["FS: q(0)"], LIGHT),
    Scenario("ss", "the paper's second scenario, masses 20 % above the model's", SECOND, CARD["SS: q(0)"], HEAVY),
)
HELD_OUT = (
    Scenario("paper", "the paper's first scenario, masses drawn around the model's", FIRST, CARD["FS: q(0)"]),
    Scenario("fast", "a faster motion", FAST, (0.0, 0.0)),
    Scenario("payload", "a slower motion, a payload of 1 kg", SLOW, (0.0, 0.5), mass=(1.0, 2.0)),
    Scenario(
        "friction", "a slower motion, ten times the friction", SLOW, (0.0, 0.5), viscous=(1.0, 1.0), coulomb=(2.0, 2.0)
    ),
    Scenario(
        "jumps",
        "a square wave with other jumps than in the paper",
        wb.SquareWave("q", "rad", (1.2, -0.8), 1 / LEVEL),
        (0.0, 0.0),
    ),
    Scenario(
        "push",
        "the paper's first motion, five times the disturbance at three times its frequency",
        FIRST,
        (0.5, 0.5),
        push=5.0,
        pace=3.0,
    ),
    Scenario(
        "noise",
        "a slower motion, three times the noise, positions quantised to 1 mrad",
        SLOW,
        (0.0, 0.5),
        noise=3.0,
        quantum=1e-3,
    ),
    Scenario("quiet", "a slower motion, a tenth of the noise", SLOW, (0.0, 0.5), noise=0.1),
    Scenario(
        "limit", "the paper's first motion, a torque of at most 35 and 12 N m", FIRST, (0.5, 0.5), limit=(35.0, 12.0)
    ),
    Scenario(
        "slow",
        "the paper's first motion, a period of 4 ms, and a torque that acts one period late",
        FIRST,
        (0.5, 0.5),
        slow=4,
    ),
)


SHARES = (  # of the arm's own numbers: name, paths, lowest and highest
    ("first mass", ("plant.arm.links[0].mass",), 0.8, 1.2),
    ("second mass", ("plant.arm.links[1].mass",), 0.8, 1.2),
    ("first length", ("plant.arm.links[0].length",), 0.97, 1.03),
    ("second length", ("plant.arm.links[1].length",), 0.97, 1.03),
    ("friction", ("plant.friction.viscous", "plant.friction.coulomb"), 0.0, 2.0),
    ("disturbance amplitude", ("plant.disturbance.amplitude",), 0.0, 2.0),
    ("disturbance frequency", ("plant.disturbance.frequency",), 0.5, 2.0),
)


def first_estimates(observer: wb.Observer) -> list[str]:
    """The paths of the first positions of a state observer, if there is one: they are the first reading."""
    return [name for name in observer.memory.names if name.split(".")[-1] == "q_hat"]


def uncertain(scenario: Scenario, loop: wb.DigitalLoop) -> tuple[wb.Factor, ...]:
    """The factors that are drawn anew in each run of a loop."""
    starts = ("plant.q", *(f"observer.{path}" for path in first_estimates(loop.loop.observer)))
    return (
        *(wb.Factor(name, paths, wb.Uniform(low, high), share=True) for name, paths, low, high in SHARES),
        *(wb.Factor(f"phase {j + 1}", (f"plant.disturbance.phase[{j}]",), wb.Uniform(0.0, 2 * np.pi)) for j in (0, 1)),
        *(
            wb.Factor(f"start {j + 1}", tuple(f"{path}[{j}]" for path in starts), wb.Uniform(q - 0.2, q + 0.2))
            for j, q in enumerate(scenario.start)
        ),
    )


LATE = "late RMSE"
HALF = 0.5  # of the time, that counts as late


def metrics(scenario: Scenario) -> tuple[wb.metrics.AbstractMetric, ...]:
    """The metrics of a run: late is the second half of each level of a square wave, and of the whole run otherwise.

    The torque is sampled as often as the computer changes it.
    """
    span = LEVEL if scenario.jumps else HORIZON
    late = wb.metrics.Integral(
        LATE,
        "rad",
        f"root mean square of e over the second half {'of each level' if scenario.jumps else 'of the run'}",
        lambda t, y: ca.if_else(ca.fmod(t, span) >= HALF * span, y["e"] ** 2, 0),
        lambda integral, horizon: np.sqrt(np.maximum(integral, 0) / (HALF * horizon)),
    )
    return wb.rmse(), late, wb.total_variation(scenario.period), wb.effort()


@dataclass(frozen=True)
class Term:
    """A part of the objective: a metric, both joints together, in units of what is called acceptable."""

    metric: str
    unit: str
    acceptable: float
    why: str


TERMS = (
    Term("RMSE", "rad", 0.5, "error over the whole run, with the start"),
    Term(LATE, "rad", 0.005, "error after the start: 0.3 degrees"),
    Term("TV", "N m/s", 300.0, "chattering: about three times the value for the desired motion itself"),
    Term("effort", "N m", 50.0, "torque: twice the torque against gravity"),
)


def both(sample: wb.study.Sample, metric: str) -> wb.Array:
    """A metric of both joints together, the root of the sum of their squares, (N,)."""
    return np.hypot(*(sample.score(metric, joint).value for joint in (0, 1)))


def cost(sample: wb.study.Sample, terms: tuple[Term, ...] = TERMS) -> wb.Array:
    """The sum of all terms, (N,)."""
    return np.asarray(np.sum([both(sample, term.metric) / term.acceptable for term in terms], axis=0))


def objective(samples: Mapping[str, wb.study.Sample]) -> wb.Array:
    """The mean cost over the training scenarios, (n,)."""
    return np.asarray(np.mean([cost(sample) for sample in samples.values()], axis=0))

"""The arm in the place of a real one, the arm that the paper states, and the conditions of their experiments."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

import workbench as wb
from studies.paper.card import CARD as PAPERS
from studies.paper.entrants import AOSMC, LUENBERGER
from studies.paper.laws import ARM, SINES, disturbance

PERIOD = 2e-3  # s, of the computer, which logs each of its instants
SUBSTEPS = 2  # Runge-Kutta steps of the plant in a period
SPAN = 5.0  # s, of a log
STEP = 2 * np.pi / 4096  # rad, of an encoder of 12 bits
START = (0.0, 0.0)  # rad, at rest: the arm hangs
TORQUES = (100.0, 50.0)  # N m, of the drives
CARD = wb.provenance.Card(
    (
        wb.provenance.assumed_entry(
            "true masses", (1.1, 1.3), "kg", "10 and 30 % above those of the paper, as with a payload", 0.5, 3.0
        ),
        wb.provenance.assumed_entry("true lengths", (1.02, 0.97), "m", "3 % and less beside the paper's", 0.5, 2.0),
        wb.provenance.assumed_entry("viscous friction", (0.3, 0.2), "N m s/rad", "between those of a8", 0.05, 1.0),
        wb.provenance.assumed_entry("Coulomb friction", (0.6, 0.4), "N m", "between those of a8", 0.1, 2.0),
        wb.provenance.assumed_entry(
            "smoothing speed", 0.1, "rad/s", "over which Coulomb friction turns, by a tanh", 0.02, 0.3
        ),
        wb.provenance.assumed_entry("period", PERIOD, "s", "of the computer, twice that of a8", 1e-3, 5e-3),
        wb.provenance.assumed_entry("step of q", STEP, "rad", "an encoder of 12 bits on each joint", 1e-5, 1e-2),
        wb.provenance.assumed_entry("noise of q", STEP / 2, "rad", "half of a step", 1e-6, 1e-2),
        wb.provenance.assumed_entry(
            "length of a log", SPAN, "s", "more than a period of each sine of the paper", 1.0, 20.0
        ),
    )
)
GEOMETRY = ("arm.links[0].mass", "arm.links[1].mass", "arm.links[0].length", "arm.links[1].length")
FRICTIONS = ("friction.viscous[0]", "friction.viscous[1]", "friction.coulomb[0]", "friction.coulomb[1]")
FREE = (*GEOMETRY, *FRICTIONS)
WORDS = dict(zip(FREE, ("m1", "m2", "l1", "l2", "viscous 1", "viscous 2", "Coulomb 1", "Coulomb 2"), strict=True))
UNITS = dict(zip(FREE, ("kg", "kg", "m", "m", "N m s/rad", "N m s/rad", "N m", "N m"), strict=True))
PUSH = {  # what a fit estimates of the paper's disturbance if it knows the frequencies
    f"disturbance.{field}[{joint}]": float(PAPERS[f"FS: disturbance {field}"][joint])
    for field in ("amplitude", "phase")
    for joint in (0, 1)
}
Numbers = tuple[float, ...]  # in the order of `FREE`
TRUTH: Numbers = tuple(
    float(x) for name in ("true masses", "true lengths", "viscous friction", "Coulomb friction") for x in CARD[name]
)
NOMINAL: Numbers = (1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0)  # as the paper has it
SPEED = float(CARD["smoothing speed"])
BEGIN = 0.1  # N m s/rad and N m, of the frictions where a search begins


@dataclass(frozen=True)
class Conditions:
    """An arm and an experiment: what is true of it, and what a fit believes."""

    name: str
    words: str
    truth: Numbers = TRUTH
    span: float = SPAN
    noise: float = 0.5  # in steps of the encoder
    push: bool = False  # True for the paper's disturbance, of which no fit knows
    late: bool = False  # True if the torque acts one period after the instant at which it is logged
    speed: float = SPEED  # rad/s: the smoothing speed that a fit believes
    free: tuple[str, ...] = FREE
    is_model_right: bool = True
    pose: tuple[float, float] | None = None  # rad: the arm is held there, instead of the motion of the paper

    @property
    def sigma(self) -> float:
        """The standard deviation in rad of a reading: its noise, and an even error of one step."""
        return float(np.hypot(self.noise, 1 / np.sqrt(12)) * STEP)

    @property
    def true_values(self) -> tuple[float, ...]:
        """The true values of the free numbers."""
        every = dict(zip(FREE, self.truth, strict=True)) | PUSH
        return tuple(every[name] for name in self.free)


BASE = Conditions("base", "as stated")
SHORT = Conditions("short", "a log of two seconds", span=2.0)
ODD = (
    Conditions("push", "the paper's disturbance acts, and no fit knows", push=True, is_model_right=False),
    Conditions(
        "known push", "the paper's disturbance acts; a fit knows its frequencies", push=True, free=(*FREE, *PUSH)
    ),
    Conditions("late", "the torque acts a period later than it is logged", late=True, is_model_right=False),
    Conditions("speed", "the fit believes half of the smoothing speed", speed=SPEED / 2, is_model_right=False),
    Conditions("friction", "the fit knows of no Coulomb friction", free=FREE[:6], is_model_right=False),
    Conditions("coarse", "noise of a twentieth of an encoder's step", noise=0.05),
    Conditions("held", "the arm is held in a pose", pose=(0.8, 0.4)),
    SHORT,
    Conditions("paper", "the masses and lengths of the paper", truth=(1.0, 1.0, 1.0, 1.0, *TRUTH[4:])),
    Conditions("payload", "a payload of 1 kg", truth=(1.0, 2.0, 1.0, 1.0, *TRUTH[4:])),
    Conditions("rough", "about three times the friction", truth=(*TRUTH[:4], 1.0, 0.6, 2.0, 1.2)),
)


PLAYED = tuple(case for case in ODD if not case.pose)  # under a designed excitation, which holds no pose


def arm_of(numbers: Numbers) -> wb.arms.mechanics.PlanarArm:
    """The arm with masses and lengths of these numbers."""
    links = wb.arms.mechanics.PointMass(numbers[0], numbers[2]), wb.arms.mechanics.PointMass(numbers[1], numbers[3])
    return replace(ARM, links=links)


def friction_of(numbers: Numbers, speed: float = SPEED) -> wb.arms.Friction:
    """The friction of these numbers."""
    return wb.arms.Friction(numbers[4:6], numbers[6:8], speed=speed)


def plant_of(
    numbers: Numbers, push: bool = False, speed: float = SPEED, start: tuple[float, float] = START
) -> wb.Manipulator:
    """The arm with friction as a plant at rest, and with the paper's disturbance if asked."""
    return wb.Manipulator(
        arm_of(numbers),
        q=start,
        qd=(0.0, 0.0),
        disturbance=disturbance("FS") if push else None,
        friction=friction_of(numbers, speed),
    )


def instruments(plant: wb.Manipulator, noise: float = 0.5) -> wb.Instruments:
    """Encoders with noise in steps of their own, and drives with limits."""
    limit = (-np.array(TORQUES), np.array(TORQUES))
    return wb.Instruments.of(plant, noise={"q": noise * STEP}, quantum={"q": STEP}, limit={"tau": limit})


def proposed_loop(plant: wb.Manipulator, model: wb.arms.mechanics.PlanarArm = ARM) -> wb.ClosedLoop:
    """The law of the paper with its observers, as report a8 has it, for a model of the arm."""
    state = replace(LUENBERGER, model=model, q_hat=plant.q)
    momentum = wb.arms.observers.MomentumObserver(model, PAPERS["l"])
    observer = wb.arms.observers.StateAndDisturbanceObserver(state, momentum)
    return wb.ClosedLoop(plant, observer, replace(AOSMC, model=model), SINES)

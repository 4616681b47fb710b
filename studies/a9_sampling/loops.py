"""The paper's laws run by a computer: one batch a period, exact readings first, then readings with noise."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from studies.paper.card import CARD as PAPER
from studies.paper.laws import plant
from studies.paper.linearization import loop_of
from workbench.core import Sampled, Step
from workbench.loop import Instruments
from workbench.metrics import AbstractMetric, measured, sampled_rmse, total_variation
from workbench.metrics.accumulators import final_values
from workbench.simulate import simulate
from workbench.study.provenance import Card, assumed
from workbench.validation.refusals import Array, Integers

CARD = Card(
    (
        assumed("realistic period", 1e-3, "s", "a usual rate of robot controllers, 1 kHz", 2.5e-4, 4e-3),
        assumed("delay", "one period", "", "the torque is computed while the one before acts"),
        assumed("steps of q", 2 * np.pi / 2**16, "rad", "an encoder of 16 bits on each joint", 1e-6, 1e-3),
        assumed("noise of q", 5e-5, "rad", "half a step of the encoder", 1e-6, 1e-3),
        assumed("steps of qd", 1e-3, "rad/s", "a filtered difference, in fixed point", 0.0, 1e-2),
        assumed("noise of qd", 5e-3, "rad/s", "half of the boundary layer; a plain difference has more", 5e-4, 0.1),
    )
)
REALISTIC = float(CARD["realistic period"])
MS = f"{1e3 * REALISTIC:g} ms"
NOISY = 7  # runs with noise, beside the one without: what a vector register or two holds
SEED = 20_09
SUBSTEP = 2.5e-3  # s, at most: between two instants the plant is smooth
RMSE, TV = "RMSE (43)", "TV"
SCENARIOS = ("FS", "SS")
HORIZON = {scenario: float(PAPER[f"{scenario}: horizon"]) for scenario in SCENARIOS}  # s
ROUGH = Instruments.of(
    plant("FS"),
    noise={"q": CARD["noise of q"], "qd": CARD["noise of qd"]},
    quantum={"q": CARD["steps of q"], "qd": CARD["steps of qd"]},
)
WAYS = {
    "euler": "explicit Euler",
    "cayley34": "Cayley step of (34)",
    "cayley": "Cayley steps of (34) and (10)",
    "fine": "16 Runge-Kutta steps",
}
Values = Mapping[str, Array]


@dataclass(frozen=True)
class Computer:
    """A computer that runs a law once in `period` seconds, a period late or not.

    `stepping` is the way in which the memories of AOSMC-RGS and its observer step, one of `WAYS`.
    """

    period: float
    delay: bool = False
    stepping: str = "euler"

    @property
    def substeps(self) -> int:
        """The number of Runge-Kutta steps of the plant in a period."""
        return int(np.ceil(self.period / SUBSTEP - 1e-9))


@dataclass(frozen=True, eq=False)
class Audit:
    """One law in one scenario, run by one computer."""

    values: Values  # by metric (2,): with exact readings; NaN if the run diverged
    errors: Values  # by how much half the substep changes them
    noisy: Values  # by metric (runs, 2): with noise and steps in the readings, fresh ones in each run

    @property
    def lost(self) -> Integers:
        """(1 + runs,): 1 for a run that diverged, that with exact readings first."""
        return np.isnan([self.values[RMSE][0], *self.noisy[RMSE][:, 0]]).astype(int)

    def score(self, metric: str, joint: int, noisy: bool = False) -> tuple[float, float]:
        """The value with its error, or the mean with noise and twice its standard error; infinite if a run diverged."""
        value, error = float(self.values[metric][joint]), float(self.errors[metric][joint])
        if noisy:
            runs = self.noisy[metric][:, joint]
            value, error = float(runs.mean()), float(2 * runs.std(ddof=1) / np.sqrt(len(runs)))
        return (float("inf"), 0.0) if np.isnan(value) else (value, error)


def metrics(period: float) -> tuple[AbstractMetric, ...]:
    """(43) and the total variation of the torque that is held, period by period."""
    return sampled_rmse(PAPER["sample time of (43)"]), total_variation(period)


def digital(law: str, scenario: str, computer: Computer, instruments: Instruments | None = None) -> Sampled:
    """A law as the computer runs it: the loop of a1, and the memories of AOSMC-RGS stepped in another way if asked."""
    loop, way = loop_of(law, scenario), computer.stepping
    if way.startswith("cayley"):
        loop = replace(loop, controller=replace(loop.controller, integrator="cayley"))
    if way == "cayley":
        state = replace(loop.observer.state, integrator="cayley")
        loop = replace(loop, observer=replace(loop.observer, state=state))
    integrator = "fine" if way == "fine" else "declared"
    return loop.digital(computer.period, instruments, delay=computer.delay, integrator=integrator, name=law)


@cache
def audit(law: str, scenario: str, computer: Computer) -> Audit:
    """A law run by a computer at two lengths of its substep, with and without noise."""
    sampled = digital(law, scenario, computer, ROUGH)
    rows = np.tile(sampled.parameters.default, (1 + NOISY, 1))
    for sensor in (0, 1):
        for name in ("noise", "quantum"):
            rows[0, sampled.parameters.slice(f"instruments.sensors[{sensor}].{name}")] = 0.0
    fine = ends(sampled, law, scenario, computer, rows, 2 * computer.substeps)
    coarse = ends(sampled, law, scenario, computer, rows[:1], computer.substeps)
    errors = {name: np.abs(value[0] - coarse[name][0]) for name, value in fine.items()}
    return Audit({name: value[0] for name, value in fine.items()}, errors, {n: value[1:] for n, value in fine.items()})


@cache
def exact(law: str, scenario: str, computer: Computer) -> Values:
    """The metrics (2,) with exact readings alone, for a search; NaN where the run diverged."""
    sampled = digital(law, scenario, computer)
    values = ends(sampled, law, scenario, computer, sampled.parameters.default[np.newaxis], computer.substeps)
    return {name: value[0] for name, value in values.items()}


def ends(sampled: Sampled, law: str, scenario: str, computer: Computer, rows: Array, substeps: int) -> Values:
    """The metrics (B, 2) at the horizon; where the torque is late, the first one waits already, and none is 0."""
    asked, ode = metrics(computer.period), loop_of(law, scenario).ode()
    first = {"hold.next": ode.outputs_at(0.0, ode.states.default)["tau"]} if computer.delay else {}
    step = measured(sampled, asked, computer.period / substeps)
    return last(step, asked, HORIZON[scenario], rows, step.states.pack(first))


def last(
    step: Step, asked: tuple[AbstractMetric, ...], until: float, rows: Array | None = None, x0: Array | None = None
) -> Values:
    """The metrics (B, 2) of runs at their end, by name."""
    return final_values(simulate(step, rows, x0, until=until, every=until, seed=SEED), asked)

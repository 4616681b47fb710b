"""The paper's laws run by a computer: one batch a period, exact readings first, then readings with noise."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from studies.a9_sampling.card import CARD, LATE, NOISY, SEED
from studies.paper.card import CARD as PAPER
from studies.paper.laws import plant
from studies.paper.linearization import PROPOSED, SEVEN, loop_of
from workbench.core import Sampled
from workbench.loop import ClosedLoop, Instruments
from workbench.metrics import AbstractMetric, late_error, measured, sampled_rmse, total_variation
from workbench.metrics.accumulators import final_values
from workbench.simulate import simulate
from workbench.validation.refusals import Array, Integers

RMSE, TV, LATE_ERROR = "RMSE (43)", "TV", "late error"
SCENARIOS = ("FS", "SS")
SWITCHING = {
    "sign": tuple(law for law in SEVEN if law != "PID"),
    "implicit": tuple(law for law in SEVEN if law not in ("PID", PROPOSED)),
}
SUBSTEP = 2.5e-3  # s, at most: between two instants the plant is smooth
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


@dataclass(frozen=True)
class Computer:
    """How a law is run: once in `period` seconds, a period late or not, its switching as the law has it or another.

    `stepping` is the way in which the memories of AOSMC-RGS and its observer step, one of `WAYS`.
    """

    period: float
    delay: bool = False
    switching: str = "clip"
    stepping: str = "euler"

    @property
    def substeps(self) -> int:
        """Into how many Runge-Kutta steps of the plant a period is cut."""
        return int(np.ceil(self.period / SUBSTEP - 1e-9))


@dataclass(frozen=True, eq=False)
class Audit:
    """One law in one scenario, run by one computer.

    Attributes
    ----------
    values, errors
        By metric (2,): with exact readings, and by how much half the substep changes them. NaN if the run diverged.
    noisy
        By metric (runs, 2): the same with noise and steps in the readings, fresh ones in each run.
    diverged_at
        In s, of the run with exact readings; None if it stayed finite.
    """

    values: Mapping[str, Array]
    errors: Mapping[str, Array]
    noisy: Mapping[str, Array]
    diverged_at: float | None

    @property
    def lost(self) -> Integers:
        """(1 + runs,): 1 for a run that diverged, that with exact readings first."""
        return np.array([self.diverged_at is not None, *np.isnan(self.noisy[RMSE][:, 0])], dtype=int)

    def score(self, metric: str, joint: int) -> tuple[float, float]:
        """The value with exact readings and its error; infinite where the run diverged."""
        if self.diverged_at is not None:
            return float("inf"), 0.0
        return float(self.values[metric][joint]), float(self.errors[metric][joint])

    def noisy_score(self, metric: str, joint: int) -> tuple[float, float]:
        """The mean over the runs with noise and twice its standard error; infinite where one of them diverged."""
        runs = self.noisy[metric][:, joint]
        if np.isnan(runs).any():
            return float("inf"), 0.0
        return float(runs.mean()), float(2 * runs.std(ddof=1) / np.sqrt(len(runs)))


def metrics(scenario: str, period: float) -> tuple[AbstractMetric, ...]:
    """(43) and the total variation of the torque that is held, period by period; late errors where nothing jumps."""
    both = (sampled_rmse(PAPER["sample time of (43)"]), total_variation(period))
    return (*both, late_error(LATE)) if scenario == "FS" else both


def switched(law: str, scenario: str, switching: str = "clip", stepping: str = "euler") -> ClosedLoop:
    """The loop of a law as in a1, which has a layer and steps by Euler, or one that switches or steps otherwise."""
    loop = loop_of(law, scenario)
    if stepping.startswith("cayley"):
        loop = replace(loop, controller=replace(loop.controller, integrator="cayley"))
    if stepping == "cayley":
        state = replace(loop.observer.state, integrator="cayley")
        loop = replace(loop, observer=replace(loop.observer, state=state))
    if switching == "clip":
        return loop
    return replace(loop, controller=replace(loop.controller, saturation=switching))


def digital(law: str, scenario: str, computer: Computer, instruments: Instruments | None = None) -> Sampled:
    """A law as the computer runs it."""
    loop = switched(law, scenario, computer.switching, computer.stepping)
    integrator = "fine" if computer.stepping == "fine" else "declared"
    return loop.digital(computer.period, instruments, delay=computer.delay, integrator=integrator, name=law)


def horizon(scenario: str) -> float:
    """That of the card, in s."""
    return float(PAPER[f"{scenario}: horizon"])


@cache
def audit(law: str, scenario: str, computer: Computer) -> Audit:
    """A law run by a computer at two lengths of its substep, with and without noise."""
    sampled = digital(law, scenario, computer, ROUGH)
    rows = np.tile(sampled.parameters.default, (1 + NOISY, 1))
    for sensor in (0, 1):
        for name in ("noise", "quantum"):
            rows[0, sampled.parameters.slice(f"instruments.sensors[{sensor}].{name}")] = 0.0
    asked = metrics(scenario, computer.period)
    x0, until = start(law, scenario, computer), horizon(scenario)
    fine, lost = ends(sampled, asked, rows, x0, until, 2 * computer.substeps)
    coarse, _ = ends(sampled, asked, rows[:1], x0, until, computer.substeps)
    errors = {name: np.abs(value[0] - coarse[name][0]) for name, value in fine.items()}
    noisy = {name: value[1:] for name, value in fine.items()}
    at = float(lost[0]) if np.isfinite(lost[0]) else None
    return Audit({name: value[0] for name, value in fine.items()}, errors, noisy, at)


def start(law: str, scenario: str, computer: Computer) -> Mapping[str, Array]:
    """States that do not begin as the loop says: where the torque is late, the first waits already, and none is 0."""
    if not computer.delay:
        return {}
    ode = loop_of(law, scenario).ode()
    return {"hold.next": ode.outputs_at(0.0, ode.states.default)["tau"]}


def ends(
    sampled: Sampled,
    asked: tuple[AbstractMetric, ...],
    rows: Array,
    x0: Mapping[str, Array],
    until: float,
    substeps: int,
) -> tuple[Mapping[str, Array], Array]:
    """The metrics (B, 2) at the horizon by name, and when each run diverged."""
    step = measured(sampled, asked, sampled.period / substeps)
    runs = simulate(step, rows, step.states.pack(x0), until=until, every=until, seed=SEED)
    return final_values(runs, asked), runs.diverged_at


@cache
def exact(law: str, scenario: str, computer: Computer) -> Mapping[str, Array]:
    """The metrics (2,) with exact readings alone, for a search; NaN where the run diverged."""
    sampled = digital(law, scenario, computer)
    asked = metrics(scenario, computer.period)
    row, x0 = sampled.parameters.default[np.newaxis], start(law, scenario, computer)
    values, _ = ends(sampled, asked, row, x0, horizon(scenario), computer.substeps)
    return {name: value[0] for name, value in values.items()}

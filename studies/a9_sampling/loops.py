"""The paper's laws run by a computer: a sweep a period, of a run with exact readings first, then runs with noise."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

import workbench as wb
from studies.paper.laws import plant, state_observer
from studies.paper.linearization import loop_of
from studies.paper.quiet_periods import HORIZON, RMSE, SUBSTEP, TV, metrics

CARD = wb.provenance.Card(
    (
        wb.provenance.assumed_entry(
            "realistic period", 1e-3, "s", "a usual rate of robot controllers, 1 kHz", 2.5e-4, 4e-3
        ),
        wb.provenance.assumed_entry("delay", "one period", "", "the torque is computed while the one before acts"),
        wb.provenance.assumed_entry(
            "steps of q",
            2 * np.pi / 2**16,
            "rad",
            "an encoder of 16 bits on each joint",
            1e-6,
            1e-3,
            "quantisation of q",
        ),
        wb.provenance.assumed_entry("noise of q", 5e-5, "rad", "half of the quantisation", 1e-6, 1e-3),
        wb.provenance.assumed_entry(
            "steps of qd", 1e-3, "rad/s", "a filtered difference, in fixed point", 0.0, 1e-2, "quantisation of qd"
        ),
        wb.provenance.assumed_entry(
            "noise of qd", 5e-3, "rad/s", "half of the boundary layer; a plain difference has more", 5e-4, 0.1
        ),
    )
)
REALISTIC = float(CARD["realistic period"])
MS = f"{1e3 * REALISTIC:g} ms"
NOISY = 7  # runs with noise, beside the one without: what a vector register or two holds
SEED = 20_09
ROUGH = wb.Instruments.of(
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
SENSORS = tuple(f"instruments.sensors[{i}].{name}" for i in (0, 1) for name in ("noise", "quantum"))
READINGS = wb.Factor("noise and steps", SENSORS, wb.Uniform(0.0, 1.0), share=True)
RUNS = wb.uncertainty.ListedPoints(np.array([0.0] + [1.0] * NOISY)[:, np.newaxis])  # the first reads exactly
Values = Mapping[str, wb.Array]


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
        """The least number of Runge-Kutta steps of the plant in a period; runs take twice as many."""
        return int(np.ceil(self.period / SUBSTEP - 1e-9))


@dataclass(frozen=True, eq=False)
class Audit:
    """One law in one scenario, run by one computer."""

    values: Values  # by metric (2,): with exact readings; NaN if the run diverged
    errors: Values  # of these, by half the substep
    noisy: Values  # by metric (runs, 2): with noise and steps in the readings, fresh ones in each run

    @staticmethod
    def of(sample: wb.study.Sample) -> Audit:
        """The audit of the runs of a sweep."""
        scores = {metric: [sample.score(metric, joint) for joint in (0, 1)] for metric in (RMSE, TV)}
        values = {metric: np.stack([one.value for one in both], axis=1) for metric, both in scores.items()}
        errors = {metric: np.array([one.error[0] for one in both]) for metric, both in scores.items()}
        return Audit({n: value[0] for n, value in values.items()}, errors, {n: v[1:] for n, v in values.items()})

    @property
    def is_lost(self) -> wb.core.Integers:
        """(1 + runs,): 1 for a run that diverged, that with exact readings first."""
        return np.isnan([self.values[RMSE][0], *self.noisy[RMSE][:, 0]]).astype(int)

    def score(self, metric: str, joint: int, noisy: bool = False) -> tuple[float, float]:
        """The value with its error, or the mean with noise and twice its standard error; infinite if a run diverged."""
        value, error = float(self.values[metric][joint]), float(self.errors[metric][joint])
        if noisy:
            runs = self.noisy[metric][:, joint]
            value, error = float(runs.mean()), float(2 * runs.std(ddof=1) / np.sqrt(len(runs)))
        return (float("inf"), 0.0) if np.isnan(value) else (value, error)


def digital(law: str, scenario: str, computer: Computer, instruments: wb.Instruments | None = None) -> wb.DigitalLoop:
    """A law as the computer runs it: the loop of a1, and the memories of AOSMC-RGS stepped in another way if asked."""
    loop, way = loop_of(law, scenario), computer.stepping
    if way.startswith("cayley"):
        loop = replace(loop, controller=replace(loop.controller, integrator="cayley"))
    if way == "cayley":
        state = replace(state_observer(loop), integrator="cayley")
        loop = replace(loop, observer=replace(loop.observer, state=state))
    waiting = first_torque(law, scenario) if computer.delay else None
    return wb.DigitalLoop(
        loop, computer.period, instruments, computer.delay, waiting, "fine" if way == "fine" else "declared"
    )


@cache
def first_torque(law: str, scenario: str) -> dict[str, wb.Array]:
    """The torque of the first instant, which waits already where it comes late: none is 0."""
    ode = loop_of(law, scenario).ode()
    return {"tau": ode.outputs_at(0.0, ode.states.default)["tau"]}


def name_of(law: str, scenario: str, computer: Computer) -> str:
    """The name of the sweep of a law run by a computer."""
    late = "_late" if computer.delay else ""
    words = f"{law}_{scenario}_{1e6 * computer.period:g}us{late}_{computer.stepping}"
    return "".join(c if c.isalnum() else "_" for c in words.lower())


def sweep(law: str, scenario: str, computer: Computer) -> wb.Sweep:
    """A law run by a computer with exact readings, which is run again at half the substep, and with noise."""
    h = computer.period / (2 * computer.substeps)
    loop = digital(law, scenario, computer, ROUGH)
    run = wb.Run(loop, metrics(computer.period), HORIZON[scenario], h=h, seed=SEED)
    return wb.Sweep(name_of(law, scenario, computer), run, (READINGS,), RUNS, half_step_every=1 + NOISY)

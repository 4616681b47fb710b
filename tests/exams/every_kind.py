"""A study of every kind of run and work, some seconds long, to be killed at any moment.

Each item of a work writes a line when it begins: so one can count how often it was computed.
"""

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import workbench as wb
from workbench.study.tuning import Trial, Tuning
from workbench.study.uncertainty import MonteCarlo

LOOP = wb.ClosedLoop(
    wb.DCMotor(),
    controller=wb.PID(wb.DCMotor().outputs, wb.DCMotor().inputs, Kp=2.0, Ki=5.0),
    reference=wb.Step("omega", "rad/s", 1.0),
)
ODE = LOOP.ode()
METRICS = (wb.rmse("omega"), wb.effort("v"))
FACTORS = (
    wb.Factor("friction", ("plant.b",), wb.Uniform(0.05, 0.2)),
    wb.Factor("inertia", ("plant.J",), wb.Uniform(0.005, 0.02)),
)
GAINS = (
    wb.Factor("Kp", ("controller.Kp",), wb.LogUniform(0.5, 20.0)),
    wb.Factor("Ki", ("controller.Ki",), wb.LogUniform(0.5, 20.0)),
)


@dataclass(frozen=True)
class Search:
    """The gain that a bisection finds, the errors that it saw on its way, and a remark."""

    gain: float
    seen: np.ndarray
    remark: str | None = None


def begin(work: str, item: object) -> None:
    """Write that an item begins, for those who count."""
    if file := os.environ.get("BEGUN"):
        with Path(file).open("a") as lines:
            lines.write(f"{work} {item!r}\n")


def error_at(gain: float, load: float) -> float:
    """The RMSE of the loop at a gain."""
    p = ODE.parameters.pack({"controller.Kp": np.full((160, 1), gain), "plant.b": load * np.linspace(0.05, 0.2, 160)})
    return float(wb.measure(ODE, (METRICS[0],), p, until=2.0, h=1e-3).score(METRICS[0].name).value.mean())


def find_gain(load: float) -> Search:
    """The gain at which the mean RMSE is a third, by bisection."""
    begin("gains", load)
    low, high, seen = 0.1, 100.0, []
    for _ in range(4):
        middle = (low * high) ** 0.5
        seen.append(error_at(middle, load))
        low, high = (low, middle) if seen[-1] < 0.3 else (middle, high)
    return Search(low, np.array(seen), None if low > 0.1 else "at the end of the range")


def check_gains(gains: tuple[tuple[str, float], ...]) -> dict[str, float]:
    """The error and the effort of the loop at the gains that a search has found."""
    begin("check", gains)
    ode = LOOP.ode()
    p = ode.parameters.pack({f"controller.{name}": np.full((160, 1), gain) for name, gain in gains})
    scores = wb.measure(ode, METRICS, p, until=10.0, h=1e-3).scores
    return {score.metric: float(score.value.max()) for score in scores} | {"none": float("nan")}


def works(results):
    """The searches for gains, and a check of those that the tuning has found."""
    best = tuple(results.tuning("gains_by_search").best.items())
    loads = (0.5, 1.0, 1.5, 2.0, 4.0)
    return wb.Work("gains", find_gain, over=loads), wb.Work("check", check_gains, over=(best,), seconds=1.0)


def objective(runs):
    """Error and effort of a trial."""
    return runs["step"].score(METRICS[0].name).value + 0.1 * runs["step"].score(METRICS[1].name).value


def sections(results):
    """All that was found, to its last digit."""
    found = (
        repr([results["step", law].score(METRICS[0].name).pair for law in ("slow", "fast")]),
        repr(results.sample("loads").values.sum()),
        repr(dict(results.tuning("gains_by_search").best)),
        repr(results.work("check")),
        repr([(one.gain, one.seen.tolist(), one.remark) for one in results.work("gains")]),
    )
    return [wb.Section("Found", tuple(wb.Paragraph(line) for line in found))]


LONG = wb.Run(LOOP, METRICS, until=60.0, every=0.5, h=1e-3)
study = wb.Study(
    name="every_kind",
    title="A study of every kind",
    question="Does what was done outlive its process?",
    method="A motor under PI control: two cases, a sweep, a tuning and works.",
    sections=sections,
    cases=(wb.Case("step", "slow", LONG), wb.Case("step", "fast", LONG, style=1)),
    tunings=(
        Tuning(
            "gains_by_search",
            (Trial("step", wb.Run(LOOP, METRICS, until=40.0, h=2e-3)),),
            GAINS,
            objective,
            evaluations=80,
            population=8,
        ),
    ),
    sweeps=(
        wb.Sweep(
            "loads",
            wb.Run(LOOP, METRICS, until=10.0, h=1e-3),
            FACTORS,
            MonteCarlo(2, 8 * 256),
            runs_of_chunk=256,
        ),
    ),
    works=works,
    live=None,
)

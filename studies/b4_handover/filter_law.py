"""A predictive safety filter on a Cortex-M7: its instructions where it changes a command, and where it does not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import workbench as wb
from studies.b4_handover.thousands import in_thousands

WORK = "safety_filter"
STAGES = (4, 8, 16, 32, 64)
PERIOD, PERIODS = 0.05, 60  # s
AMPLITUDE = 2.0  # m, of the positions that are followed
LIMITS = {"a[0]": (-2.0, 2.0), "a[1]": (-2.0, 2.0)} | dict.fromkeys(("p[0]", "p[1]", "v[0]", "v[1]"), (-1.5, 1.5))
SOURCE = "safety_filter/safety_filter.ipynb of RoboticExplorationLab/mcu-solver-benchmarks"
Column = wb.document.TableColumn


@wb.block
class TwoAxes(wb.Plant):
    """Two double integrators, as in the benchmark."""

    p: np.ndarray = wb.initial(default=np.zeros(2), unit="m", shape=("n",))
    v: np.ndarray = wb.initial(default=np.zeros(2), unit="m/s", shape=("n",))
    inputs = wb.Layout((wb.core.Entry("a", np.zeros(2), "m/s^2"),))

    @property
    def outputs(self) -> wb.Layout:
        """All states are measured."""
        return self.states

    def rate(self, t, x, u):  # type: ignore[no-untyped-def]
        """The derivative of the states."""
        return {"p": x["v"], "v": u["a"]}


@dataclass(frozen=True, eq=False)
class FilterCount:
    """A filter on the Cortex-M7: instructions in the mean and at most, and the state with its arrays in bytes.

    `interventions` is the share of periods in which it changes the command, and `largest` the largest value of a
    limited signal as a share of its limit.
    """

    interventions: float
    largest: float
    sweeps: int
    mean: float | None
    most: float | None
    differing_bits: int
    room: int
    reason: str


def filter_loop(stages: int) -> tuple[wb.SampledSystem, int]:
    """The filtered loop, and its number of sweeps."""
    plant = TwoAxes()
    model = wb.linearize(wb.open_loop(plant), t=0.0, x=np.zeros(4), at_rest=True)
    weights = np.diag([4.0, 4.0, 1.0, 1.0]), 0.5 * np.eye(2)
    design = wb.predictive_design(model, PERIOD, *weights, stages, limits=LIMITS)
    nominal = wb.StateFeedback.of(plant, np.hstack([6.0 * np.eye(2), 4.0 * np.eye(2)]), follow=("p",))
    law = wb.SafetyFilter.of(plant, design, nominal)
    path = wb.Sines("p", "m", amplitude=[AMPLITUDE, AMPLITUDE], frequency=[1.0, 1.0])
    loop = wb.ClosedLoop(plant, observer=wb.FullState.of(plant), controller=law, reference=path)
    return loop.digital(PERIOD), design.numbers.sweeps


def filter_work() -> wb.Work:
    """The counts at all horizons."""
    return wb.Work(WORK, filter_count, STAGES, seconds=10.0)


def filter_count(stages: int) -> FilterCount:
    """The count at one horizon."""
    loop, sweeps = filter_loop(stages)
    run = wb.simulate(loop.step(1), until=PERIOD * PERIODS)
    choice = run.x[0, 1:, run.step.states.slice("controller.choice")]
    largest = max(float(np.abs(run[name]).max()) / end for name, end in (("p", 1.5), ("v", 1.5), ("a", 2.0)))
    replay = wb.replay(loop, name="filter", periods=PERIODS, targets=("cortex-m7",))
    (result,), own = replay.results, replay.results[0].figures
    room = 8 * (replay.code.law.memory.size + replay.code.costs.room)
    return FilterCount(
        float((choice > 0).mean()),
        largest,
        sweeps,
        own.instructions,
        own.most,
        result.differing_bits,
        room,
        result.reason,
    )


def filter_table(results: wb.Results) -> wb.document.ReportTable:
    """The counts of the filter."""
    columns = (
        Column("stages", align="right"),
        Column("sweeps", align="right"),
        Column("changed commands", "%", "right", digits=2),
        Column("largest signal over its limit", "%", "right", digits=5),
        Column("instructions: mean", "thousands", "right", digits=3),
        Column("instructions: at most", "thousands", "right", digits=3),
        Column("state of the law with its arrays", "bytes", "right"),
    )
    rows = tuple(
        (
            stages,
            one.sweeps,
            100 * one.interventions,
            100 * one.largest,
            in_thousands(one.mean),
            in_thousands(one.most),
            one.room,
        )
        for stages, one in zip(STAGES, results.work(WORK), strict=True)
    )
    note = (
        f"Two double integrators at 20 Hz with |x| <= 1.5 and |u| <= 2, as in {SOURCE}. Its plan stays near the "
        "planned inputs at all stages and has no terminal set. Here the command of a law that follows a sine of 2 m is "
        "filtered, and each plan ends in a terminal set, by which the limits are kept forever. So the two do not solve "
        "one problem."
    )
    caption = "A safety filter on a Cortex-M7: instructions of a period."
    return wb.document.ReportTable("predictive_filter", caption, columns, rows, (note,))

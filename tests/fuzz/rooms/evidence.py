from __future__ import annotations

from functools import cache, partial
from typing import Any

import numpy as np

import workbench as wb
from workbench.study import evidence
from workbench.study.compiled_sweep import compile_sweep

from .study import sample

EFFECT = evidence.ComputerEffect("jitter", ("computer.jitter",), (1e-3, 2e-3), 1e-3, "s")
RATIOS = np.array([[1.0, 1.1], [1.5, np.inf]])
MARGIN = evidence.ComputerMargin(EFFECT, RATIOS[:, :, None], RATIOS)


@cache
def delayed() -> Any:
    """The runs of a loop of a motor at each level of the effect."""
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, Kp=10.0, Ki=20.0)
    loop = (
        wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0))
        .digital(0.01)
        .with_timing_faults()
    )
    run = wb.Run(loop, (wb.rmse(),), until=0.1)
    made = compile_sweep(evidence.computer_sweep("motor", run, (EFFECT,), draws=2))
    return made.sample([made.chunk(0, made.sweep.design.size)])


def calls() -> dict[str, Any]:
    margins = evidence.ComputerMargins((MARGIN,), np.ones((2, 1)), np.ones((2, 1)))
    return {
        "ComputerMargin": partial(evidence.ComputerMargin, EFFECT, RATIOS[:, :, None], RATIOS),
        "ComputerMargins": partial(evidence.ComputerMargins, (MARGIN,), np.ones((2, 1)), np.ones((2, 1)), ()),
        "computer_margins": partial(evidence.computer_margins, delayed(), (EFFECT,), "RMSE"),
        "computer_table": partial(evidence.computer_table, "t", "c", (("motor", margins),)),
        "same_draws": partial(evidence.same_draws, {"a": sample(), "b": sample()}),
    }


def arguments() -> dict[str, Any]:
    return {
        "law": lambda thing: "a",
        "a": lambda thing: "a",
        "b": lambda thing: "b",
        "ComputerMargin.largest.most": lambda thing: 1.1,
        "ComputerMargin.unbounded.most": lambda thing: 1.1,
        "ComputerEffect.coordinate.level": lambda thing: 1e-3,
    }

"""The cost of each law on a microcontroller: operations in a period, and instructions of its C on a Cortex-M7."""

from __future__ import annotations

from dataclasses import dataclass

import workbench as wb

TARGET, PERIODS = "cortex-m7", 20
CLOCK = wb.handover.CLOCKS[TARGET]


@dataclass(frozen=True)
class Cost:
    """The cost of a law: NaN where the emulator is not installed."""

    operations: float  # of a period, as the exported graph has them
    instructions: float  # of a period, in the mean
    most: float  # of a period
    code: float  # bytes
    stack: float  # bytes
    equal: bool  # True if each bit of the commands and memories is that of the reference arithmetic
    reason: str  # why it did not run


def cost_on_machine(law: wb.DigitalLoop, substeps: int) -> Cost:
    """The cost of the law of a loop with its observer."""
    loop = law.ode()
    (result,) = wb.replay(loop, periods=PERIODS, targets=[TARGET], precision="single", substeps=substeps).results
    figures, nothing = result.figures, float("nan")
    return Cost(
        float(loop.law().step.operations),
        nothing if figures.instructions is None else float(figures.instructions),
        nothing if figures.most is None else float(figures.most),
        nothing if figures.code is None else float(figures.code),
        nothing if figures.stack is None else float(figures.stack),
        result.equal,
        result.reason,
    )

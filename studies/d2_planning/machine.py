"""The cost of each law on a microcontroller: operations in a period, and instructions of its C on a Cortex-M7."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import workbench as wb
from studies.d2_planning.choices import Item
from studies.d2_planning.designs import BY_KEY, MOST_KNOBS, laws_of
from studies.d2_planning.problems import PROBLEMS
from studies.d2_planning.runs import loop_of

TARGET, PERIODS = "cortex-m7", 20
CLOCK = wb.handover.CLOCKS[TARGET]


@dataclass(frozen=True)
class Cost:
    """The cost of a law: NaN where the emulator is not installed."""

    operations: float  # of a period, as the exported graph has them
    instructions: float
    code: float  # bytes
    stack: float  # bytes
    equal: bool  # True if each bit of the commands and memories is that of the reference arithmetic
    reason: str  # why it did not run


def costs_items() -> tuple[Item, ...]:
    """All laws."""
    return tuple(Item(problem.key, law.key) for problem in PROBLEMS.values() for law in laws_of(problem))


def cost_on_machine(item: Item) -> Cost:
    """The law in the middle of its knobs; its numbers do not change the count."""
    problem, law = PROBLEMS[item.problem], BY_KEY[item.law]
    loop = loop_of(problem, law, law.choice(np.full(MOST_KNOBS, 0.4))).ode()
    found = wb.replay(loop, periods=PERIODS, targets=[TARGET], precision="single", substeps=problem.substeps).results[0]
    figures, nothing = found.figures, float("nan")
    return Cost(
        float(loop.law().step.operations),
        nothing if figures.instructions is None else float(figures.instructions),
        nothing if figures.code is None else float(figures.code),
        nothing if figures.stack is None else float(figures.stack),
        found.equal,
        found.reason,
    )

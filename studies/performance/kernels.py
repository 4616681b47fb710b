"""What is asked of the engine's inside: the IR of a step, and how much it computes."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from workbench.core import Step
from workbench.simulate.kernel import llvm
from workbench.simulate.kernel.lowering import lower
from workbench.simulate.kernel.plan import Plan
from workbench.validation.refusals import Array

COSTS = {"@llvm.fma": 2, "@llvm.sqrt": 1, "fadd": 1, "fsub": 1, "fmul": 1, "fdiv": 1}
OPERATION = re.compile(r" = (?:call [^@]*)?(@llvm\.[a-z]+|f[a-z]+)\b")


def varied(p: Array) -> tuple[int, ...]:
    """Which of the parameters (B, np) differ from run to run."""
    return tuple(int(i) for i in np.flatnonzero((p != p[:1]).any(axis=0)))


def ir(step: Step, varied: Sequence[int]) -> str:
    """The time loop as LLVM IR for this processor."""
    return lower(Plan.of_step(step, tuple(varied)), llvm.lanes())


def flops(step: Step, varied: Sequence[int]) -> int:
    """Floating-point operations of one step of one run inside the loop: two for fma, one for + - * / and sqrt."""
    body = ir(step, varied).split("\nstep:\n")[1].split("\nkeep:\n")[0]
    found = (OPERATION.search(line) for line in body.splitlines())
    return sum(COSTS.get(operation[1], 0) for operation in found if operation)

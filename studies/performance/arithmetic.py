"""The operations of a compiled step, and the most that one core computes in a second."""

from __future__ import annotations

import ctypes
import re
from collections.abc import Sequence
from time import process_time

import numpy as np

import workbench as wb
from studies.performance.inner_parts import KernelPlan, llvm, lower

COSTS = {"@llvm.fma": 2, "@llvm.sqrt": 1, "fadd": 1, "fsub": 1, "fmul": 1, "fdiv": 1}
OPERATION = re.compile(r" = (?:call [^@]*)?(@llvm\.[a-z]+|f[a-z]+)\b")
# of operations that need each other: more than any processor's latency times its units, less than registers
CHAINS = 12
UNROLL_COUNT, ALIGNMENT = 8, 64
PEAK = """declare {v} {fma}({v}, {v}, {v})
define void @workbench_peak(i64 %rounds, ptr %numbers) {{
start:
  %pb = getelementptr double, ptr %numbers, i64 {width}
  %pt = getelementptr double, ptr %pb, i64 {width}
  %a = load {v}, ptr %numbers, align {align}
  %b = load {v}, ptr %pb, align {align}
  br label %loop
loop:
  %i = phi i64 [ 0, %start ], [ %i1, %loop ]
{phis}
{steps}
  %i1 = add i64 %i, 1
  %more = icmp slt i64 %i1, %rounds
  br i1 %more, label %loop, label %end
end:
  %t0 = fadd {v} zeroinitializer, %s{unrolled}_0
{sums}
  store {v} %t{last}, ptr %pt, align {align}
  ret void
}}"""


def time_loop(step: wb.core.StepMap, varied_places: Sequence[int]) -> str:
    """The time loop as LLVM IR for this processor, some of its parameters being those of each run."""
    return lower(KernelPlan.of_step(step, tuple(varied_places)), llvm.lanes())


def flops(step: wb.core.StepMap, varied_places: Sequence[int]) -> int:
    """Floating-point operations of one step of one run inside the loop: two for fma, one for + - * / and sqrt."""
    body = time_loop(step, varied_places).split("\nstep:\n")[1].split("\nkeep:\n")[0]
    found = (OPERATION.search(line) for line in body.splitlines())
    return sum(COSTS.get(operation[1], 0) for operation in found if operation)


def peak_kernel(width: int) -> str:
    """`numbers[0] x + numbers[1]` so many rounds from zero, in independent chains whose sum goes to `numbers[2]`."""
    v, fma, each = f"<{width} x double>", f"@llvm.fma.v{width}f64", range(CHAINS)
    return PEAK.format(
        v=v,
        fma=fma,
        width=width,
        align=8 * width,
        unrolled=UNROLL_COUNT,
        last=CHAINS - 1,
        phis="\n".join(
            f"  %s0_{i} = phi {v} [ zeroinitializer, %start ], [ %s{UNROLL_COUNT}_{i}, %loop ]" for i in each
        ),
        steps="\n".join(
            f"  %s{k + 1}_{i} = call {v} {fma}({v} %s{k}_{i}, {v} %a, {v} %b)"
            for k in range(UNROLL_COUNT)
            for i in each
        ),
        sums="\n".join(f"  %t{i} = fadd {v} %t{i - 1}, %s{UNROLL_COUNT}_{i}" for i in each[1:]),
    )


def peak_sum(rounds: int) -> wb.Array:
    """The sum of all chains in each lane (width,), each of which has added 1 `rounds` times `UNROLL_COUNT`."""
    width = llvm.lanes()
    function = llvm.compile_module(peak_kernel(width)).function("workbench_peak", ctypes.c_int64, ctypes.c_void_p)
    room = np.ones(3 * width + ALIGNMENT // 8)
    start = (-room.ctypes.data % ALIGNMENT) // 8
    numbers = room[start : start + 3 * width]
    function(rounds, numbers.ctypes.data)
    return numbers[2 * width :].copy()


def peak(rounds: int = 1_000_000) -> float:
    """Floating-point operations per second of one core that wait for nothing, a fused one counted as two."""
    peak_sum(1)
    begin = process_time()
    peak_sum(rounds)
    return 2.0 * CHAINS * UNROLL_COUNT * llvm.lanes() * rounds / (process_time() - begin)

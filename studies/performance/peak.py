"""The most that one core computes: fused multiplications and additions that wait for nothing."""

from __future__ import annotations

import ctypes
from time import process_time

import numpy as np

from workbench.simulate.kernel import llvm
from workbench.validation.refusals import Array

CHAINS = (
    12  # of operations that need each other: more than any processor's latency times its units, less than registers
)
UNROLLED = 8
ALIGNMENT = 64


def ir(width: int) -> str:
    """`void workbench_peak(i64 rounds, ptr numbers)`: numbers[0] + rounds times numbers[1], in every chain and lane.

    `numbers` are three vectors: the factor (1, or the sum is another), the summand, and where the sum of
    all chains goes.
    """
    vector = f"<{width} x double>"
    fma = f"@llvm.fma.v{width}f64"
    lines, now = [], [f"%x{i}" for i in range(CHAINS)]
    for step in range(UNROLLED):
        for i in range(CHAINS):
            name = f"%y{i}" if step == UNROLLED - 1 else f"%s{step}_{i}"
            lines.append(f"  {name} = call {vector} {fma}({vector} {now[i]}, {vector} %a, {vector} %b)")
            now[i] = name
    phis = [f"  %x{i} = phi {vector} [ zeroinitializer, %start ], [ %y{i}, %loop ]" for i in range(CHAINS)]
    sums = [f"  %t{i} = fadd {vector} {'%y0' if i == 1 else f'%t{i - 1}'}, %y{i}" for i in range(1, CHAINS)]
    return "\n".join(
        [
            f"declare {vector} {fma}({vector}, {vector}, {vector})",
            "define void @workbench_peak(i64 %rounds, ptr %numbers) {",
            "start:",
            f"  %pb = getelementptr double, ptr %numbers, i64 {width}",
            f"  %pt = getelementptr double, ptr %numbers, i64 {2 * width}",
            f"  %a = load {vector}, ptr %numbers, align {8 * width}",
            f"  %b = load {vector}, ptr %pb, align {8 * width}",
            "  br label %loop",
            "loop:",
            "  %i = phi i64 [ 0, %start ], [ %i1, %loop ]",
            *phis,
            *lines,
            "  %i1 = add i64 %i, 1",
            "  %more = icmp slt i64 %i1, %rounds",
            "  br i1 %more, label %loop, label %end",
            "end:",
            *sums,
            f"  store {vector} %t{CHAINS - 1}, ptr %pt, align {8 * width}",
            "  ret void",
            "}",
        ]
    )


def summed(rounds: int) -> Array:
    """The sum of all chains in each lane (width,), each of which has added 1 `rounds` times `UNROLLED`."""
    width = llvm.lanes()
    function = llvm.compiled(ir(width)).function("workbench_peak", ctypes.c_int64, ctypes.c_void_p)
    room = np.ones(3 * width + ALIGNMENT // 8)
    start = (-room.ctypes.data % ALIGNMENT) // 8
    numbers = room[start : start + 3 * width]
    function(rounds, numbers.ctypes.data)
    return numbers[2 * width :].copy()


def peak(rounds: int = 1_000_000) -> float:
    """Floating-point operations per second of one core, a fused one counted as two."""
    summed(1)
    begin = process_time()
    summed(rounds)
    return 2.0 * CHAINS * UNROLLED * llvm.lanes() * rounds / (process_time() - begin)

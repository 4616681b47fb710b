"""Measurements that need a process of their own: the time from its start, and the most memory it held."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np

import workbench as wb
from studies.paper.workload import HORIZON, VARIED_COLUMNS, H, rows_of, run, workload


def first_result() -> dict[str, Any]:
    """Eight runs of W, and the seconds of a core that all of this process took, imports included."""
    run(rows_of(8), HORIZON)
    return {"cpu": process_time()}


def kernel_load() -> dict[str, Any]:
    """The seconds to have the kernel of W, once its IR is there."""
    from studies.performance.arithmetic import time_loop
    from studies.performance.inner_parts import llvm

    text = time_loop(workload(), VARIED_COLUMNS)
    begin = process_time()
    llvm.compile_module(text)
    return {"load": process_time() - begin}


def least_time() -> dict[str, Any]:
    """The plan of least time of the arm, and the seconds of a core that all of this process took, imports included."""
    from studies.performance.least_time import least_time_plan

    least_time_plan()
    return {"cpu": process_time()}


def chain(n: int) -> wb.core.StepMap:
    """A planar arm of n links under proportional and derivative action, by RK4 at the step of W."""
    import workbench as wb

    ones, rest = np.ones(n), np.zeros(n)
    arm = wb.Manipulator(wb.arms.mechanics.planar(n), q=rest)
    law = wb.ArmPID(Kp=400 * ones, Ki=rest, Kd=80 * ones)
    return wb.rk4(wb.ClosedLoop(arm, wb.ArmFullState(n), law, wb.Constant("q", "rad", rest)).ode(), H)


def compilation(*links: int) -> dict[str, Any]:
    """For arms of so many links the operations of a step, and the seconds from the step to machine code."""
    from studies.performance.arithmetic import flops, time_loop
    from studies.performance.inner_parts import llvm

    found: dict[str, list[float]] = {"flops": [], "cpu": []}
    llvm.compile_module(time_loop(chain(1), (0,)))  # LLVM's own beginnings
    for n in links:
        step = chain(n)
        _ = step.F
        begin = process_time()
        llvm.compile_module(time_loop(step, (0,)))
        found["cpu"].append(process_time() - begin)
        found["flops"].append(flops(step, (0,)))
    return found


def many_runs(runs: int) -> dict[str, Any]:
    """The most memory, in bytes, that this process held while it ran so many runs for 200 steps."""
    run(rows_of(runs), 200 * H)
    return {"bytes": most_memory()}


def most_memory() -> float | None:
    """The most memory of this process, in bytes, by Linux; `getrusage` may tell that of the one which started it."""
    status = Path("/proc/self/status")
    if not status.exists():
        return None
    lines = status.read_text(encoding="ascii").splitlines()
    return 1024.0 * int(next(line for line in lines if line.startswith("VmHWM")).split()[1])


def in_a_process(probe: Callable[..., dict[str, Any]], *numbers: int, cache: str) -> dict[str, Any]:
    """The findings of a function of this file in a process of its own, with its whole `wall` time in s.

    Parameters
    ----------
    cache
        The folder of compiled kernels, or "off".
    """
    call = f"import json, sys; from {__name__} import {probe.__name__} as probe; "
    call += f"sys.stdout.write(json.dumps(probe(*{list(numbers)})))"
    environment = {**os.environ, "WORKBENCH_CACHE": cache}
    begin = perf_counter()
    done = subprocess.run([sys.executable, "-c", call], env=environment, stdout=subprocess.PIPE, check=True, text=True)
    return {"wall": perf_counter() - begin, **json.loads(done.stdout)}

"""What only a process of its own can tell: the time from its start, and the most memory it held."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter, process_time
from typing import Any

from studies.performance.workload import HORIZON, H


def first_result() -> dict[str, Any]:
    """Eight runs of W, and what all of it took of this process, imports included."""
    from studies.performance.effort import ours, rows_of

    ours(rows_of(8), HORIZON)
    return {"cpu": process_time()}


def kernel_load() -> dict[str, Any]:
    """How long it takes to have the kernel of W, once its IR is there."""
    from studies.performance.effort import rows_of
    from studies.performance.kernels import ir, varied
    from studies.performance.workload import workload
    from workbench.simulate.kernel.llvm import compiled

    text = ir(workload(), varied(rows_of(8)))
    begin = process_time()
    compiled(text)
    return {"load": process_time() - begin}


def compilation(*links: int) -> dict[str, Any]:
    """For arms of so many links the operations of a step, and the seconds from the step to machine code."""
    from studies.performance.kernels import flops, ir
    from studies.performance.links import chain
    from workbench.core import rk4
    from workbench.simulate.kernel.llvm import compiled

    found: dict[str, list[float]] = {"flops": [], "cpu": []}
    compiled(ir(rk4(chain(1), H), (0,)))  # LLVM's own beginnings
    for n in links:
        step = rk4(chain(n), H)
        _ = step.F
        begin = process_time()
        compiled(ir(step, (0,)))
        found["cpu"].append(process_time() - begin)
        found["flops"].append(flops(step, (0,)))
    return found


def many_runs(runs: int) -> dict[str, Any]:
    """The most memory, in bytes, that this process held while it ran so many runs for 200 steps."""
    from studies.performance.effort import ours, rows_of

    ours(rows_of(runs), 200 * H)
    return {"bytes": _most_memory()}


def _most_memory() -> float:
    status = Path("/proc/self/status")
    if status.exists():  # as what `getrusage` says may be that of the process which started this one
        line = next(line for line in status.read_text().splitlines() if line.startswith("VmHWM"))
        return 1024.0 * int(line.split()[1])
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)


def in_a_process(probe: Callable[..., dict[str, Any]], *numbers: int, cache: str) -> dict[str, Any]:
    """What a function of this file finds in a process of its own, with its whole `wall` time in s.

    Parameters
    ----------
    cache
        The folder of compiled kernels, or "off".
    """
    call = f"import json, sys; from {__name__} import {probe.__name__} as probe; "
    call += f"sys.stdout.write(json.dumps(probe(*{list(numbers)})))"
    begin = perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", call],
        env={**os.environ, "WORKBENCH_CACHE": cache},
        stdout=subprocess.PIPE,
        check=True,
        text=True,
    )
    return {"wall": perf_counter() - begin, **json.loads(done.stdout)}


def fresh() -> TemporaryDirectory[str]:
    """An empty folder of kernels."""
    return TemporaryDirectory(prefix="workbench-bench-")

"""What the engine is to reach by itself: its share of the machine, latency, scaling and memory."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from importlib.util import find_spec
from statistics import median
from time import perf_counter
from typing import NamedTuple

import numpy as np

from studies.performance import processes
from studies.performance.effort import Effort, cpu_seconds, our_rate, ours, rows_of
from studies.performance.row import Row
from studies.performance.workload import HORIZON, H, workload
from workbench.simulate import simulate
from workbench.validation.refusals import Array


class Found(NamedTuple):
    """What was measured, None if it could not be, how or why not, and runs a second of one core where it is a rate."""

    value: float | None
    note: str = ""
    runs_per_s: float | None = None


@dataclass(frozen=True)
class Target:
    """A bar in a unit of its own, and what measures it; `compiles` if it has a meaning for compiled code only."""

    name: str
    bar: float
    unit: str
    measure: Callable[[Effort], Found]
    at_most: bool = False
    compiles: bool = False

    def row(self, effort: Effort) -> Row:
        """The row of the table."""
        here = not self.compiles or find_spec("llvmlite") is not None
        found = self.measure(effort) if here else Found(None, "not measured: llvmlite has no wheel for this platform")
        return Row(
            self.name,
            self.bar,
            found.runs_per_s,
            value=found.value,
            unit=self.unit,
            at_most=self.at_most,
            note=found.note,
        )


def share(effort: Effort) -> Found:
    """The floating-point operations of W in a second, of all that one core can do."""
    from studies.performance.kernels import flops, varied
    from studies.performance.peak import peak

    step = flops(workload(), varied(rows_of(8)))
    pairs = [(our_rate(effort), peak()) for _ in range(effort.repetitions)]
    rate, most = (median(column) for column in zip(*pairs, strict=True))
    done = rate * step * HORIZON / H
    note = f"{done / 1e9:.3g} of {most / 1e9:.3g} Gflop/s, {step:,} flop a step"
    return Found(100 * done / most, note, rate)


def first_result(effort: Effort) -> Found:
    """From the start of a process to the end of eight runs, with no kernel on the disk."""
    found = []
    for _ in range(effort.processes):
        with processes.fresh() as folder:
            found.append(processes.in_a_process(processes.first_result, cache=folder))
    note = f"wall time; {median(f['cpu'] for f in found):.2f} s of CPU"
    return Found(median(f["wall"] for f in found), note)


def cached_kernel(effort: Effort) -> Found:
    """The kernel of W from the disk."""
    with processes.fresh() as folder:
        found = [processes.in_a_process(processes.kernel_load, cache=folder) for _ in range(effort.processes + 1)]
    compiled, *loaded = (1e3 * f["load"] for f in found)
    return Found(median(loaded), f"CPU time; compiled in {compiled:.0f} ms")


@lru_cache(maxsize=2)
def rates(effort: Effort) -> dict[int, float]:
    """Runs a second of one core by the number of runs in a call."""
    found: dict[int, list[float]] = {runs: [] for runs in effort.sizes}
    for _ in range(effort.repetitions):
        for runs in effort.sizes:
            found[runs].append(our_rate(effort, runs))
    return {runs: median(values) for runs, values in found.items()}


def flat(effort: Effort) -> Found:
    """How far the slowest number of runs in a call lies below the fastest."""
    found = rates(effort)
    note = ", ".join(f"{runs:,}: {rate:,.0f}" for runs, rate in found.items())
    return Found(100 * (1 - min(found.values()) / max(found.values())), f"runs/s/core with {note}")


def threads(effort: Effort) -> Found:
    """The wall-time rate on two cores over that on one."""
    if not hasattr(os, "sched_setaffinity") or len(os.sched_getaffinity(0)) < 2:
        return Found(None, "not measured: this system gives no two cores to choose from")
    p = rows_of(4 * effort.runs)
    cores = sorted(os.sched_getaffinity(0))
    pairs = [(_busy(p, effort, cores[:1]), _busy(p, effort, cores[:2])) for _ in range(2 * effort.repetitions)]
    one, two = (min(wall for wall, _ in column) for column in zip(*pairs, strict=True))
    kept = median(alone[1] / both[1] for alone, both in pairs)
    note = f"wall time, best of {len(pairs)}, at a load of {os.getloadavg()[0]:.1f} where idle is meant; "
    note += f"by CPU time each of two keeps {100 * kept:.0f} % of its rate"
    return Found(one / two, note)


def _busy(p: Array, effort: Effort, cores: list[int]) -> tuple[float, float]:
    """Wall and CPU seconds of a call on some cores only."""
    with _on(cores):
        begin = perf_counter()
        spent = cpu_seconds(lambda: ours(p, effort.horizon))
        return perf_counter() - begin, spent


@contextmanager
def _on(cores: list[int]) -> Iterator[None]:
    """Threads that are made in here run on these cores."""
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, cores)
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)


def memory(effort: Effort) -> Found:
    """What a process needs for very many runs of 200 steps: the horizon does not matter."""
    found = processes.in_a_process(processes.many_runs, effort.many, cache=os.environ.get("WORKBENCH_CACHE", ""))
    return Found(found["bytes"] / 1e9, f"in {found['wall']:.0f} s")


@lru_cache(maxsize=2)
def compilation(effort: Effort) -> tuple[tuple[int, float, float], ...]:
    """Links, operations of a step, and median seconds from the step to machine code."""
    found = [
        processes.in_a_process(processes.compilation, *effort.links, cache="off") for _ in range(effort.repetitions)
    ]
    seconds = np.median([f["cpu"] for f in found], axis=0)
    return tuple(zip(effort.links, found[0]["flops"], map(float, seconds), strict=True))


def growth(effort: Effort) -> Found:
    """The power of a step's operations with which the time to compile it grows: 1 is linear."""
    found = compilation(effort)
    size, seconds = np.array([row[1:] for row in found]).T
    power = np.polyfit(np.log(size), np.log(seconds), 1)[0]
    note = ", ".join(f"{links}: {1e3 * s:.0f} ms" for links, _, s in found)
    return Found(float(power), note)


def fallback(effort: Effort) -> Found:
    """The engine that needs no compiler, in the arithmetic that it is fastest in; a shorter horizon, scaled."""
    p, steps = rows_of(effort.fallback), 100
    until = steps * H

    def run() -> object:
        return simulate(workload(), p, until=until, every=until, arithmetic="portable", engine="numpy")

    rate = len(p) * until / HORIZON / median(cpu_seconds(run) for _ in range(effort.repetitions))
    return Found(rate, f"{steps} steps, scaled; with the compiled code's bits, unlike NumPy's functions", rate)


TARGETS = (
    Target("share of one core's FMA peak", 70.0, "%", share, compiles=True),
    Target("first result of a new loop, cold", 0.5, "s", first_result, at_most=True),
    Target("load of a cached kernel", 5.0, "ms", cached_kernel, at_most=True, compiles=True),
    Target("rate from 8 to 10,000 runs, spread", 10.0, "%", flat, at_most=True),
    Target("two threads over one", 1.8, "x", threads),
    Target("memory of 1,000,000 runs (200 steps)", 1.0, "GB", memory, at_most=True),
    Target("compile time over size, 2 to 7 links", 1.1, "power", growth, at_most=True, compiles=True),
    Target("portable in NumPy, 8,000 runs", 60.0, "runs/s/core", fallback),
)

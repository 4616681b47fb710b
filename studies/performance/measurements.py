"""The rows of the table: the engine compared with its peers, at equal error, and with the limits of the machine."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter, process_time

import numpy as np

import workbench as wb
from studies.paper.workload import HORIZON, VARIED_COLUMNS, H, rows_of, run, workload
from studies.performance import processes
from studies.performance.arithmetic import flops, peak
from studies.performance.inner_parts import METHODS, StepChoice
from studies.performance.peers import PEERS, Peer, Runner, casadi_cvodes
from studies.performance.processes import in_a_process
from studies.performance.steps_of_workload import by_choice, choose_step

EQUAL = ((1e-3, 20.0), (3e-5, 12.0))  # the error of the RMSE, and how many times as fast we must be
TOLERANCES, OURS = (1e-9, 1e-2), (1e-6, 1e-1)  # of CVODES and of our pilot, where the one of an error is looked for
AT_ERROR, BUSY = "at error", 0.5  # in a row's name; other processes, beside which two threads tell nothing
STEPS_A_DECADE = 24  # settings that are tried


@dataclass(frozen=True)
class Effort:
    """The size of a measurement: the `horizon` of a run in s, repetitions of a rate, and their least `seconds`.

    `runs` are those in one call of ours, `batch` in one whose steps a pilot chooses, `samples` behind a median error,
    `sizes` where the rate shall be flat, `fallback` in NumPy, `many` where memory is looked at; `fine` is the step of
    the reference in s, `links` are those of the arms that are compiled. Frequency answers are those of `draws`, and of
    `peer_draws` by a peer. Predictive laws run `loops`; peers run
    the first `peer_loops`, and the exact law the first `exact_loops`.
    """

    horizon: float = HORIZON
    repetitions: int = 3
    processes: int = 5
    seconds: float = 0.3
    runs: int = 256
    batch: int = 4000
    samples: int = 32
    fine: float = 1e-5
    sizes: tuple[int, ...] = (8, 64, 1000, 10_000)
    fallback: int = 8000
    many: int = 1_000_000
    links: tuple[int, ...] = (2, 3, 4, 5, 6, 7)
    draws: int = 1000
    peer_draws: int = 100
    loops: int = 10_000
    peer_loops: int = 20
    exact_loops: int = 6


@dataclass(frozen=True)
class Row:
    """One thing that was measured beside its bar, both in `unit`; None where it was not measured.

    `runs_per_s` are whole runs of W in a second of one core, of the peer where there is one; `error` is that of its
    RMSE; the `note` says how it was measured, or why it was not.
    """

    name: str
    bar: float
    value: float | None = None
    unit: str = "x"
    at_most: bool = False
    runs_per_s: float | None = None
    error: float | None = None
    note: str = ""

    @property
    def is_reached(self) -> bool | None:
        """The verdict; None if nothing was measured."""
        if self.value is None:
            return None
        return self.value <= self.bar if self.at_most else self.value >= self.bar


def table_rows(effort: Effort, peers: Sequence[Peer] = PEERS) -> tuple[Row, ...]:
    """The table, row by row."""
    return (
        *(peer_row(peer, effort) for peer in peers),
        *(cvodes_row(target, bar, effort) for target, bar in EQUAL),
        *(measure(effort) for measure in (share, first_result, cached_kernel, flat, threads, memory, growth, fallback)),
    )


def cpu_seconds(work: Callable[[], object]) -> float:
    """The seconds of all cores together, without the time spent waiting for a core that others use."""
    begin = process_time()
    work()
    return process_time() - begin


def rate(runner: Callable[[wb.Array], object], p: wb.Array, effort: Effort) -> float:
    """Runs of W in a second of one core, to which they are held; shorter ones are scaled by their steps."""
    calls, spent = 0, 0.0
    with wb.study.one_core():
        while spent < effort.seconds:
            calls, spent = calls + 1, spent + cpu_seconds(lambda: runner(p))
    return calls * len(p) * effort.horizon / HORIZON / spent


def our_rate(effort: Effort, runs: int = 0) -> float:
    """The rate of the engine, with so many runs in a call."""
    return rate(lambda p: run(p, effort.horizon), rows_of(runs or effort.runs), effort)


def alternate_rates(effort: Effort, mine: Callable[[], float], theirs: Callable[[], float]) -> tuple[float, float]:
    """The median rates of two, measured in turns so that a disturbance of the machine meets both."""
    pairs = [(mine(), theirs()) for _ in range(effort.repetitions)]
    return median(pair[0] for pair in pairs), median(pair[1] for pair in pairs)


@lru_cache(maxsize=4)
def reference(effort: Effort) -> wb.Array:
    """The RMSE (B, 2) of the first runs at a step so fine that its own error does not count."""
    return run(rows_of(effort.samples), effort.horizon, effort.fine)


def error(values: wb.Array, references: wb.Array) -> float:
    """The median over runs of the relative error of the RMSE, of the worse joint of each; infinite if one is NaN."""
    both = min(len(values), len(references))
    worse = np.abs(values[:both] / references[:both] - 1).max(axis=1)
    return float(np.median(np.where(np.isnan(worse), np.inf, worse)))


def peer_row(peer: Peer, effort: Effort) -> Row:
    """A peer at its settings against us at the step of W."""
    if not peer.is_installed:
        return Row(peer.name, peer.bar, note="not installed: pip install control-workbench[peers]")
    runner = peer.runner(effort.horizon)
    batches = np.split(rows_of(peer.runs * (1 + effort.repetitions)), 1 + effort.repetitions)
    found = [runner(batches[0])]  # whatever is compiled at the first call is compiled

    def theirs() -> float:
        results: list[wb.Array] = []
        speed = rate(lambda p: results.append(runner(p)), batches[len(found)], effort)
        found.append(results[-1])
        return speed

    fast, slow = alternate_rates(effort, lambda: our_rate(effort), theirs)
    wrong = error(np.concatenate(found), reference(effort))
    return Row(peer.name, peer.bar, fast / slow, runs_per_s=slow, error=wrong)


def coarsest(error_of: Callable[[float], float], target: float, low: float, high: float) -> float:
    """The first of `high` and smaller settings, in small ratios down to `low`, whose error is within the target."""
    for setting in np.geomspace(high, low, 1 + round(STEPS_A_DECADE * np.log10(high / low))):
        if error_of(float(setting)) <= target:
            return float(setting)
    raise ValueError(f"`coarsest(target={target:g})` has a larger error at every setting down to {low:g}.")


def by_pilot(target: float, effort: Effort) -> tuple[Runner, StepChoice]:
    """The fastest runner of W with that error of the RMSE, by a pilot in each call, and what the pilot chooses there.

    The tolerance is looked for with the runs of a timed call, which the pilot will see there.
    """
    wanted, rows, horizon = reference(effort), rows_of(effort.batch), effort.horizon

    def error_of(tolerance: float) -> float:
        try:
            choice = choose_step(rows, tolerance, horizon)
        except ValueError:  # no step keeps it
            return np.inf
        return error(by_choice(choice, rows[: effort.samples], horizon), wanted)

    tolerance = coarsest(error_of, target, *OURS)
    return lambda p: by_choice(choose_step(p, tolerance, horizon), p, horizon), choose_step(rows, tolerance, horizon)


def cvodes_row(target: float, bar: float, effort: Effort) -> Row:
    """CVODES against us, both at the coarsest setting that reaches the error."""
    wanted = reference(effort)
    p, many = rows_of(effort.samples), rows_of(effort.batch)
    tolerance = coarsest(lambda t: error(casadi_cvodes(effort.horizon, t)(p), wanted), target, *TOLERANCES)
    theirs, (mine, pilot) = casadi_cvodes(effort.horizon, tolerance), by_pilot(target, effort)
    fast, slow = alternate_rates(effort, lambda: rate(mine, many, effort), lambda: rate(theirs, p, effort))
    note = (
        f"CVODES has the tolerance {tolerance:.1e}. The engine runs calls of {effort.batch:,} with pilot runs at the "
        f"tolerance {pilot.tolerance:.1e}, which choose {1e3 * pilot.h:.3g} ms by {METHODS[pilot.method].about}: "
        f"{fast:,.0f} runs/s, error {error(mine(many), wanted):.1e}"
    )
    wrong = error(theirs(p), wanted)
    return Row(f"CasADi CVODES {AT_ERROR} {target:.0e}", bar, fast / slow, runs_per_s=slow, error=wrong, note=note)


def share(effort: Effort) -> Row:
    """The floating-point operations of W in a second, of all that one core can do."""
    step = flops(workload(), VARIED_COLUMNS)
    with wb.study.one_core():
        ours, most = alternate_rates(effort, lambda: our_rate(effort), peak)
    done = ours * step * HORIZON / H
    note = f"{done / 1e9:.3g} of {most / 1e9:.3g} Gflop/s, {step:,} flop per step"
    return Row("share of one core's FMA peak", 70.0, 100 * done / most, "%", runs_per_s=ours, note=note)


def first_result(effort: Effort) -> Row:
    """From the start of a process to the end of eight runs, with no kernel on the disk."""
    found = []
    for _ in range(effort.processes):
        with TemporaryDirectory() as folder:
            found.append(in_a_process(processes.first_result, cache=folder))
    wall, cpu = (median(f[clock] for f in found) for clock in ("wall", "cpu"))
    return Row("first result of a new loop, cold", 0.5, wall, "s", True, note=f"wall time; {cpu:.2f} s of CPU")


def cached_kernel(effort: Effort) -> Row:
    """The kernel of W from the disk."""
    with TemporaryDirectory() as folder:
        found = [in_a_process(processes.kernel_load, cache=folder) for _ in range(effort.processes + 1)]
    compiled, *loaded = (1e3 * f["load"] for f in found)
    note = f"CPU time; compiled in {compiled:.0f} ms"
    return Row("load of a cached kernel", 5.0, median(loaded), "ms", True, note=note)


@lru_cache(maxsize=2)
def rates(effort: Effort) -> dict[int, float]:
    """Runs a second of one core by the number of runs in a call."""
    turns = [{runs: our_rate(effort, runs) for runs in effort.sizes} for _ in range(effort.repetitions)]
    return {runs: median(turn[runs] for turn in turns) for runs in effort.sizes}


def flat(effort: Effort) -> Row:
    """The share by which the slowest number of runs in a call lies below the fastest."""
    found = rates(effort)
    spread = 100 * (1 - min(found.values()) / max(found.values()))
    note = "runs/s/core with " + ", ".join(f"{runs:,}: {rate:,.0f}" for runs, rate in found.items())
    return Row("rate from 8 to 10,000 runs, spread", 10.0, spread, "%", at_most=True, note=note)


def threads(effort: Effort) -> Row:
    """The wall-time rate on two cores over that on one; None where there are no two, or others use them."""
    name, bar, p = "two threads over one", 1.8, rows_of(4 * effort.runs)
    cores = sorted(os.sched_getaffinity(0)) if hasattr(os, "sched_setaffinity") else []
    if len(cores) < 2:
        return Row(name, bar, note="no two processors to choose from")
    others = os.getloadavg()[0] - 1  # beside this process
    if others > BUSY:
        return Row(name, bar, note=f"not measured: {others:.1f} other processes were running")

    def wall(some: Sequence[int]) -> float:
        os.sched_setaffinity(0, some)
        try:
            begin = perf_counter()
            run(p, effort.horizon)
            return perf_counter() - begin
        finally:
            os.sched_setaffinity(0, cores)

    pairs = [(wall(cores[:1]), wall(cores[:2])) for _ in range(2 * effort.repetitions)]
    one, two = map(min, zip(*pairs, strict=True))
    note = f"wall time, best of {len(pairs)}"
    return Row(name, bar, one / two, note=note)


def memory(effort: Effort) -> Row:
    """The most memory of a process with very many runs of 200 steps: the horizon does not matter."""
    found = in_a_process(processes.many_runs, effort.many, cache=os.environ.get("WORKBENCH_CACHE", ""))
    size, note = found["bytes"] and found["bytes"] / 1e9, f"in {found['wall']:.0f} s; only Linux reports the size"
    return Row("memory of 1,000,000 runs (200 steps)", 1.0, size, "GB", at_most=True, note=note)


@lru_cache(maxsize=2)
def compilation(effort: Effort) -> tuple[tuple[int, float, float], ...]:
    """Links, operations of a step, and median seconds from the step to machine code."""
    turns = [in_a_process(processes.compilation, *effort.links, cache="off") for _ in range(effort.repetitions)]
    seconds = np.median([turn["cpu"] for turn in turns], axis=0)
    return tuple(zip(effort.links, turns[0]["flops"], map(float, seconds), strict=True))


def growth(effort: Effort) -> Row:
    """The power of a step's operations with which the time to compile it grows: 1 is linear."""
    found = compilation(effort)
    _, size, seconds = np.array(found).T
    power = float(np.polyfit(np.log(size), np.log(seconds), 1)[0])
    note = ", ".join(f"{links}: {1e3 * s:.0f} ms" for links, _, s in found)
    return Row("compile time over size, 2 to 7 links", 1.1, power, "power", at_most=True, note=note)


def fallback(effort: Effort) -> Row:
    """The engine that needs no compiler, in the arithmetic that it is fastest in; a shorter horizon, scaled."""
    p, until = rows_of(effort.fallback), 100 * H

    def work() -> object:
        return wb.simulate(workload(), p, until=until, every=until, arithmetic="portable", engine="numpy")

    speed = len(p) * until / HORIZON / median(cpu_seconds(work) for _ in range(effort.repetitions))
    note = "100 steps, scaled; it computes the bits of the compiled code, which NumPy's functions do not"
    return Row("portable in NumPy, 8,000 runs", 60.0, speed, "runs/s/core", runs_per_s=speed, note=note)

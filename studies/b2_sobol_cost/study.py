"""The cost of a Sobol study of 12,288 runs, and the part of its ledger and its orchestration.

Runs in about a minute on two cores. It measures time: the page is not the same twice.
"""

import json
import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import process_time

import numpy as np

from studies.b2_sobol_cost.workload import sweep
from workbench.simulate import simulate
from workbench.study.compiled import CompiledSweep, compile_sweep
from workbench.study.document.document import Paragraph, Section, Verdict
from workbench.study.executors import on_threads
from workbench.study.ledger.store import complete, opened
from workbench.study.sample import Sample
from workbench.study.study import Results, Study
from workbench.study.sweep_runs import tasks_of
from workbench.study.writeup import testbed

WALL, MEMORY, SHARE = 10.0, 1.0, 0.05  # s, GB, of the processor time: the bars
TURNS = 3
BUSY = 0.5  # other processes, with which the clock no longer tells what the command takes
SCRIPT = Path(__file__).with_name("workload.py")
PROBE = """
import json, resource, subprocess, sys, time
begin = time.perf_counter()
subprocess.run([sys.executable, "-m", "workbench", "run", *sys.argv[1:]], check=True, stdout=subprocess.DEVNULL)
used = resource.getrusage(resource.RUSAGE_CHILDREN)
wall = time.perf_counter() - begin
memory = used.ru_maxrss * (1 if sys.platform == "darwin" else 1024) / 1e9
json.dump({"wall": wall, "cpu": used.ru_utime + used.ru_stime, "memory": memory}, sys.stdout)
"""


@dataclass(frozen=True)
class Cost:
    """Seconds, and GB of memory, of the command for a study of so many `runs`, `again` at half of the step too."""

    runs: int
    again: int
    wall: float
    cpu: float
    memory: float
    turns: tuple[tuple[float, float], ...]  # of each, processor time of the rows marched alone, and through the ledger
    others: float = 0.0  # processes that wanted a processor before the command was run

    @property
    def shares(self) -> tuple[float, ...]:
        """The part of ledger and orchestration in the processor time of each turn: their scatter is its error."""
        return tuple(1 - marched / through for marched, through in self.turns)


@cache
def cost() -> Cost:
    """All that is measured, once."""
    one = compile_sweep(sweep())
    one.chunk(0, 8)  # compiled before it is timed
    turns = tuple((timed(lambda: march(one)), timed(lambda: record(one))) for _ in range(TURNS))
    others = max(0.0, os.getloadavg()[0] - 1) if hasattr(os, "getloadavg") else 0.0
    whole, size = command(), one.sweep.design.size
    again = len(range(0, size, one.sweep.halved))
    return Cost(size, again, whole["wall"], whole["cpu"], whole["memory"], turns, others)


def timed(work: Callable[[], object]) -> float:
    """Seconds of all cores together."""
    start = process_time()
    work()
    return process_time() - start


def march(one: CompiledSweep) -> None:
    """All rows by the engine alone, those at half of the step among them, with as many kept times."""
    for first, last in one.chunks:
        p, x0 = one.rows(first, last)
        runs = np.arange(first, last)
        again = runs % one.sweep.halved == 0
        for step, some in ((one.run.half, again), (one.run.step, runs >= 0)):
            start = one.run.start(x0[some])
            simulate(step, p[some], start, until=one.run.until, every=one.run.every, runs=runs[some])


def record(one: CompiledSweep) -> Sample:
    """The same through plan, executor, ledger and sample, in a folder of its own."""
    with TemporaryDirectory(prefix="workbench-b2-") as folder, opened(Path(folder), False) as ledger:
        tasks = tasks_of([one])
        complete(tasks, ledger, lambda missing: on_threads([one], missing))
        return one.sample(ledger.read(task.name) for task in tasks)


def command() -> dict[str, float]:
    """The cost of the whole command, from its start to the report, compilation included."""
    if os.name != "posix":
        raise ValueError("`b2_sobol_cost` measures a process by `getrusage`, which this system does not have.")
    with TemporaryDirectory(prefix="workbench-b2-") as folder:
        environment = {**os.environ, "WORKBENCH_CACHE": "off", "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
        call = [sys.executable, "-c", PROBE, str(SCRIPT), "--out", str(Path(folder) / "report")]
        done = subprocess.run(call, env=environment, check=True, text=True, stdout=subprocess.PIPE)
    found: dict[str, float] = json.loads(done.stdout)
    return found


def sections(results: Results) -> Sequence[Section]:
    """The verdicts, and how they were measured."""
    del results
    found = cost()
    how = (
        f"The command: {found.runs:,} runs of 10 s at 1 ms and {found.again:,} of them again at 0.5 ms, from its start "
        "to HTML, PDF and CSV, the kernel compiled afresh. Ledger and orchestration are held against the engine on the "
        "same rows, with nothing written."
    )
    return (Section("The cost", (*verdicts(found), Paragraph(how), Paragraph(testbed()))),)


def verdicts(cost: Cost) -> tuple[Verdict, ...]:
    """The bars, and the figures that reach or miss them."""
    sure, likely = max(cost.shares) <= SHARE, median(cost.shares) <= SHARE
    quick = "holds" if cost.wall <= WALL else "fails" if cost.others < BUSY else "open"
    small = "holds" if cost.memory <= MEMORY else "fails"
    lean = "holds" if sure else "open" if likely else "fails"
    marched, through = np.median(cost.turns, axis=0)
    time = (
        f"{cost.wall:.1f} s by the clock, {cost.cpu:.1f} s of processor time, beside {cost.others:.1f} other processes "
        f"on {os.cpu_count()} processors."
    )
    share = (
        f"{median(cost.shares):.1%} in the median of {len(cost.shares)} turns, from {min(cost.shares):.1%} to "
        f"{max(cost.shares):.1%}, where below zero is noise: {through:.2f} s through them, {marched:.2f} s without."
    )
    return (
        Verdict(quick, f"The whole command takes at most {WALL:g} s.", time),
        Verdict(small, f"It holds less than {MEMORY:g} GB.", f"At most {cost.memory:.2f} GB."),
        Verdict(lean, f"Ledger and orchestration take at most {SHARE:.0%} of the processor time.", share),
    )


study = Study(
    name="b2_sobol_cost",
    title="A Sobol study of 12,288 runs: what it takes",
    question=(
        "How long does the study b2_workload take from the command to the report, with how much memory? And how much "
        "of its processor time goes to ledger and orchestration?"
    ),
    method=(
        "The command is run in a process of its own, on an empty folder. Ledger and orchestration are what the same "
        "rows take more through the ledger than marched alone, in turns, medians of processor time."
    ),
    sections=sections,
    headlines=lambda results: [f"{one.kind}: {one.statement} {one.evidence}" for one in verdicts(cost())],
    fingerprints={"W": sweep().run.loop.fingerprint[:16]},
    measures_time=True,
)

"""The cost of a Sobol study of 12,288 runs, and the part of its ledger and its orchestration.

Runs in about a minute on two cores. It measures time: the page is not the same twice.
"""

import json
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import process_time

import numpy as np

from studies.b2_sobol_cost.workload import sweep
from workbench.simulate import simulate
from workbench.study import Finding, Page, Variation
from workbench.study.compiled import CompiledSweep, compile_sweep
from workbench.study.document.document import Column, Paragraph, Section, Table
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


def sections(results: Results) -> Page:
    """The findings, and how they were measured."""
    del results
    one = cost()
    how = (
        f"The command makes {one.runs:,} runs of 10 s at 1 ms and {one.again:,} of them again at 0.5 ms, from its "
        "start to HTML, PDF and CSV, with the kernel compiled afresh. The share of ledger and orchestration compares "
        "the same rows run through the ledger and run by the engine alone, which writes nothing."
    )
    return Page(
        answer=answer(one),
        findings=findings(one),
        sections=(Section("The cost", (cost_table(one), Paragraph(how), Paragraph(testbed()))),),
    )


def word(reached: bool) -> str:
    """The answer of a bar."""
    return "reached" if reached else "missed"


def percent(share: float) -> str:
    """A share in percent."""
    return f"{100 * share:.1f} %"


def answer(cost: Cost) -> str:
    """The page in one line."""
    return (
        f"On one machine in one run, {cost.runs:,} runs from command to report took {cost.wall:.1f} s and "
        f"{cost.memory:.2f} GB; ledger and orchestration took {percent(median(cost.shares))} of the processor time."
    )


def findings(cost: Cost) -> tuple[Finding, Finding, Finding]:
    """The bars, and the figures that reach or miss them."""
    how = {"given": "One machine, named below, and one run of the page.", "chosen": "The bar, and workload W."}
    sample = "One run of the command in a process of its own, on an empty folder."
    once = "another machine, other load, and a repetition: the command was run once"
    each = [
        Variation(f"turn {i}", word(share <= SHARE), percent(share)) for i, share in enumerate(cost.shares, start=1)
    ]
    quick, idle, middle = cost.wall <= WALL, cost.others < BUSY, median(cost.shares)
    return (
        Finding(
            name="wall_time",
            statement=f"The whole command took {cost.wall:.1f} s; the bar is {WALL:g} s.",
            evidence=f"It used {cost.cpu:.1f} s of processor time on {os.cpu_count()} processors, beside "
            f"{cost.others:.1f} other processes.",
            statistic="Seconds by the clock, from the start of the command to its report.",
            sample=sample,
            answer=word(quick),
            settled=quick or idle,
            untried=once,
            **how,
        ),
        Finding(
            name="memory",
            statement=f"It held at most {cost.memory:.2f} GB; the bar is {MEMORY:g} GB.",
            evidence="The system counts the most that the process held at any time.",
            statistic="Largest resident memory of the process.",
            sample=sample,
            answer=word(cost.memory <= MEMORY),
            untried=once,
            **how,
        ),
        Finding(
            name="ledger_share",
            statement=f"Ledger and orchestration took {percent(middle)} of the processor time; the bar is "
            f"{100 * SHARE:.0f} %.",
            evidence=f"The median of {len(cost.shares)} turns, from {percent(min(cost.shares))} to "
            f"{percent(max(cost.shares))}; a share below zero is noise.",
            statistic="One minus the processor time of the engine alone over that through the ledger, median of turns.",
            sample=f"{len(cost.shares)} turns in one process.",
            answer=word(middle <= SHARE),
            variations=tuple(each),
            untried="another machine and more turns",
            **how,
        ),
    )


def cost_table(cost: Cost) -> Table:
    """The processor time of each turn."""
    rows = [
        (i, *turn, 100 * share) for i, (turn, share) in enumerate(zip(cost.turns, cost.shares, strict=True), start=1)
    ]
    columns = (
        Column("turn", align="right"),
        Column("engine alone", "s", "right", digits=3),
        Column("through the ledger", "s", "right", digits=3),
        Column("share of the ledger", "%", "right", digits=2),
    )
    return Table("turns", "Processor time of the same rows, in turns.", columns, tuple(rows))


study = Study(
    name="b2_sobol_cost",
    title="A Sobol study of 12,288 runs: what it takes",
    question=(
        "How long does the study b2_workload take from command to report, and with how much memory? How much of its "
        "processor time do ledger and orchestration take?"
    ),
    method=(
        "The command runs in a process of its own, on an empty folder. Then the same rows run through the ledger and "
        "by the engine alone, in turns; the difference in processor time is the cost of ledger and orchestration. All "
        "times are of one machine and one run."
    ),
    sections=sections,
    fingerprints={"W": sweep().run.loop.fingerprint[:16]},
    measures_time=True,
)

"""The cost of a Sobol study of 12,288 runs, and the part of its ledger and its orchestration.

Runs in about two minutes on two cores. It measures time: the page is not the same twice.
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

import workbench as wb
from studies.b2_sobol_cost.inner_parts import CompiledSweep, compile_sweep, complete, on_threads, open_ledger, tasks_of
from studies.b2_sobol_cost.workload import SEED, sweep
from studies.paper.workload import loop

WALL, MEMORY, SHARE = 10.0, 1.0, 0.05  # s, GB, of the processor time: the bars
TURNS, COMMANDS = 5, 3
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
class Command:
    """Seconds by the clock, seconds of all processors and GB of memory of the command, run once."""

    wall: float
    cpu: float
    memory: float


@dataclass(frozen=True)
class Cost:
    """Times and memory of several commands, for a study of `runs` runs, `again` of them at half of the step as well."""

    runs: int
    again: int
    commands: tuple[Command, ...]
    turns: tuple[tuple[float, float], ...]  # of each, processor time of the rows marched alone, and through the ledger
    others: float = 0.0  # processes that wanted a processor before anything was measured

    @property
    def wall(self) -> float:
        """Seconds by the clock, the median of the commands."""
        return median(one.wall for one in self.commands)

    @property
    def memory(self) -> float:
        """GB, the most of the commands."""
        return max(one.memory for one in self.commands)

    @property
    def shares(self) -> tuple[float, ...]:
        """The part of ledger and orchestration in the processor time of each turn: their scatter is its error."""
        return tuple(1 - marched / through for marched, through in self.turns)


@cache
def cost() -> Cost:
    """All that is measured, once."""
    others = os.getloadavg()[0] if hasattr(os, "getloadavg") else 0.0
    one = compile_sweep(sweep())
    one.chunk(0, 8)  # compiled before it is timed
    commands = tuple(command() for _ in range(COMMANDS))
    turns = tuple((core_seconds(lambda: march(one)), core_seconds(lambda: record(one))) for _ in range(TURNS))
    size = one.sweep.design.size
    again = len(range(0, size, half_step_every(one)))
    return Cost(size, again, commands, turns, others)


def half_step_every(one: CompiledSweep) -> int:
    """The sweep runs one row in this many again, at half of the step."""
    if one.sweep.half_step_every is None:
        raise ValueError("The sweep of workload W must run some rows again at half of the step.")
    return one.sweep.half_step_every


def core_seconds(work: Callable[[], object]) -> float:
    """Seconds of one core, to which the work is held: two threads on one core would slow each other."""
    with wb.study.one_core():
        start = process_time()
        work()
        return process_time() - start


def march(one: CompiledSweep) -> None:
    """All rows by the engine alone, those at half of the step among them, with as many kept times."""
    for first, last in one.chunks:
        p, x0 = one.rows(first, last)
        runs = np.arange(first, last)
        again = runs % half_step_every(one) == 0
        for step, some in ((one.run.half, again), (one.run.step, runs >= 0)):
            start = one.run.start(x0[some])
            wb.simulate(step, p[some], start, until=one.run.until, every=one.run.every, noise_keys=runs[some])


def record(one: CompiledSweep) -> wb.study.Sample:
    """The same through plan, executor, ledger and sample, in a folder of its own."""
    with TemporaryDirectory(prefix="workbench-b2-") as folder, open_ledger(Path(folder), False) as ledger:
        tasks = tasks_of([one])
        complete(tasks, ledger, lambda missing: on_threads([one], missing))
        return one.sample(ledger.read(task.name) for task in tasks)


def command() -> Command:
    """The cost of the whole command, from its start to the report, compilation included."""
    if os.name != "posix":
        raise ValueError("`b2_sobol_cost` measures a process by `getrusage`, which this system does not have.")
    with TemporaryDirectory(prefix="workbench-b2-") as folder:
        environment = {**os.environ, "WORKBENCH_CACHE": "off", "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
        call = [sys.executable, "-c", PROBE, str(SCRIPT), "--out", str(Path(folder) / "report")]
        done = subprocess.run(call, env=environment, check=True, text=True, stdout=subprocess.PIPE)
    return Command(**json.loads(done.stdout))


def sections(results: wb.Results) -> wb.Page:
    """The findings, and how they were measured."""
    del results
    one = cost()
    how = (
        "Workload W is the closed loop on which p0 measures speed: a two-link arm under an observer-based sliding mode "
        f"law, with 21 states. The command makes {one.runs:,} runs of 10 s at a step of 1 ms, and {one.again:,} of "
        "them again at 0.5 ms. It ends with HTML, PDF and CSV, and compiles the kernel anew. The share of ledger and "
        "orchestration follows from the times of the same rows through the ledger and by the engine alone, which "
        "writes nothing."
    )
    return wb.Page(
        answer=answer(one),
        findings=findings(one),
        sections=(
            wb.Section("The processor time", (cost_table(one), wb.Paragraph(how), wb.Paragraph(wb.study.testbed()))),
        ),
    )


def word(is_reached: bool) -> str:
    """The answer to a target."""
    return "reached" if is_reached else "missed"


def percent(share: float) -> str:
    """A share in per cent with one decimal."""
    return wb.document.percent(share, decimals=1).replace("-", "\N{MINUS SIGN}")


def answer(cost: Cost) -> str:
    """The page in one line."""
    low, high = percent(min(cost.shares)), percent(max(cost.shares))
    share = f"{low} to {high}" if is_decided(cost) else f"{low} to {high}, which decides nothing"
    return (
        f"On one machine, {cost.runs:,} runs take {cost.wall:.1f} s from command to report, and {cost.memory:.2f} GB "
        f"of memory. The share of ledger and orchestration in the processor time is {share}."
    )


def is_decided(cost: Cost) -> bool:
    """True if the share of the ledger lies on one side of its target in every turn."""
    return len({share <= SHARE for share in cost.shares}) == 1


def findings(cost: Cost) -> tuple[wb.Finding, wb.Finding, wb.Finding]:
    """The targets, and the measured numbers that reach or miss them."""
    return wall_finding(cost), memory_finding(cost), share_finding(cost)


INFORMATION, ASSUMPTIONS = "One machine, named on this page.", "The target, and workload W."
ELSEWHERE = "another machine, and a machine with other load"


def sample(cost: Cost) -> str:
    """The commands that were run."""
    return f"{len(cost.commands)} runs of the command, each in a separate process, with an empty folder."


def wall_finding(cost: Cost) -> wb.Finding:
    """The time by the clock."""
    spent = median(one.cpu for one in cost.commands)
    quick, idle = cost.wall <= WALL, cost.others < BUSY
    return wb.Finding(
        name="wall_time",
        statement=f"The whole command takes {cost.wall:.1f} s; the target is at most {WALL:g} s.",
        evidence=f"The command uses {spent:.1f} s of processor time on {os.cpu_count()} processors. The load average "
        f"of the machine was {cost.others:.1f} when the measurement began.",
        statistic="Wall-clock time in seconds from the start of the command to its report; median of the runs.",
        sample=sample(cost),
        answer=word(quick),
        variations=tuple(
            wb.Variation(f"run {i} of the command", word(one.wall <= WALL), f"{one.wall:.1f} s")
            for i, one in enumerate(cost.commands, start=1)
        ),
        is_decided=quick or idle,
        limitations=ELSEWHERE,
        information=INFORMATION,
        assumptions=ASSUMPTIONS,
    )


def memory_finding(cost: Cost) -> wb.Finding:
    """The most memory."""
    return wb.Finding(
        name="memory",
        statement=f"The command holds at most {cost.memory:.2f} GB of memory; the target is at most {MEMORY:g} GB.",
        evidence="The operating system reports the largest amount that the process held at any time.",
        statistic="Largest resident memory of the process; maximum over the runs.",
        sample=sample(cost),
        answer=word(cost.memory <= MEMORY),
        variations=tuple(
            wb.Variation(f"run {i} of the command", word(one.memory <= MEMORY), f"{one.memory:.2f} GB")
            for i, one in enumerate(cost.commands, start=1)
        ),
        limitations=ELSEWHERE,
        information=INFORMATION,
        assumptions=ASSUMPTIONS,
    )


def share_finding(cost: Cost) -> wb.Finding:
    """The part of ledger and orchestration in the processor time."""
    middle, low, high = (percent(of(cost.shares)) for of in (median, min, max))
    noise = "" if is_decided(cost) else " The turns lie on both sides of the target."
    return wb.Finding(
        name="ledger_share",
        statement=f"Ledger and orchestration take {middle} of the processor time; the target is at most "
        f"{100 * SHARE:.0f} %.",
        evidence=f"This is the median of {len(cost.shares)} turns, which range from {low} to {high}. A share below "
        f"zero is noise.{noise}",
        statistic="One minus the ratio of the processor time of the engine alone to that through the ledger; median of "
        "the turns.",
        sample=f"{len(cost.shares)} turns in one process.",
        answer=word(median(cost.shares) <= SHARE),
        variations=tuple(
            wb.Variation(f"turn {i}", word(share <= SHARE), percent(share))
            for i, share in enumerate(cost.shares, start=1)
        ),
        is_decided=is_decided(cost),
        limitations=f"{ELSEWHERE}, and more turns",
        information=INFORMATION,
        assumptions=ASSUMPTIONS,
    )


def cost_table(cost: Cost) -> wb.document.ReportTable:
    """The processor time of each turn."""
    rows = [
        (i, *turn, 100 * share) for i, (turn, share) in enumerate(zip(cost.turns, cost.shares, strict=True), start=1)
    ]
    columns = (
        wb.document.TableColumn("turn", align="right"),
        wb.document.TableColumn("engine alone", "s", "right", digits=3),
        wb.document.TableColumn("through the ledger", "s", "right", digits=3),
        wb.document.TableColumn("share of the ledger", "%", "right", digits=2),
    )
    return wb.document.ReportTable(
        "turns",
        "Processor time of the same rows, by the engine alone and through the ledger, in turns.",
        columns,
        tuple(rows),
    )


study = wb.Study(
    name="b2_sobol_cost",
    title="A Sobol study of 12,288 runs: time and memory",
    question=(
        "How long does the study b2_workload take from command to report, and how much memory does it hold? How much "
        "of the processor time do ledger and orchestration take?"
    ),
    method=(
        f"The command runs {COMMANDS} times, each time in a separate process with an empty folder. Then the same rows "
        f"run through the ledger and by the engine alone, in {TURNS} turns on one core. The difference between the two "
        "is the processor time of ledger and orchestration. All times are of one machine."
    ),
    sections=sections,
    fingerprints={"W": loop().fingerprint[:16]},
    seed=SEED,
    measures_time=True,
)

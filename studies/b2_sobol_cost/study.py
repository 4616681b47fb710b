"""What does a Sobol study of 12,288 runs take, and what do its ledger and its orchestration add to the runs?

Runs in about a minute on two cores. It measures time: the page is not the same twice.
"""

from __future__ import annotations

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
from time import perf_counter, process_time

import numpy as np

from studies.b2_sobol_cost.workload import sweep
from studies.performance.peers import PEERS
from studies.performance.workload import HORIZON
from workbench.simulate import simulate
from workbench.study.compiled import CompiledSweep, compile_sweep
from workbench.study.document.document import Cell, Column, Itemize, Paragraph, Section, Table, Verdict
from workbench.study.execution import tasks_of
from workbench.study.executors import on_threads
from workbench.study.ledger.resumption import complete
from workbench.study.ledger.store import opened
from workbench.study.processor import machine
from workbench.study.sample import Sample
from workbench.study.study import Results, Study
from workbench.study.uncertainty import sobol_by_salib

BARS = {"wall": 10.0, "memory": 1.0, "share": 0.05}  # s, GB, of the processor time
TURNS, PEER_RUNS = 3, 3
BUSY = 0.5  # other processes, with which the clock no longer tells what the command takes
SCRIPT = Path(__file__).with_name("workload.py")
PROBE = """
import json, resource, subprocess, sys, time
begin = time.perf_counter()
subprocess.run([sys.executable, "-m", "workbench", "run", *sys.argv[1:]], check=True, stdout=subprocess.DEVNULL)
used = resource.getrusage(resource.RUSAGE_CHILDREN)
wall = time.perf_counter() - begin
json.dump({"wall": wall, "cpu": used.ru_utime + used.ru_stime, "memory": used.ru_maxrss * 1024 / 1e9}, sys.stdout)
"""


@dataclass(frozen=True)
class Cost:
    """What was measured, in s and GB.

    Attributes
    ----------
    runs, again
        Of the study, and how many of them are run at half of the step too.
    wall, cpu, memory
        Of the whole command.
    marched, kept
        Processor time of the rows marched alone, and through ledger and orchestration; medians.
    kept_wall
        Time of the latter by the clock.
    peer_run, peer_rest
        Of python-control for a run, and of SALib for the analysis; None where it is not installed.
    others
        How many other processes wanted a processor before the command was run, by the load average of a minute.
    shares
        The part of the processor time that ledger and orchestration have, of each turn: their scatter is its error.
    """

    runs: int
    again: int
    wall: float
    cpu: float
    memory: float
    marched: float
    kept: float
    kept_wall: float
    peer_run: float | None
    peer_rest: float | None
    others: float = 0.0
    shares: tuple[float, ...] = (0.0,)

    @property
    def peer(self) -> float | None:
        """What the peer would take for the same runs, those at half of the step among them, on one core."""
        if self.peer_run is None or self.peer_rest is None:
            return None
        return self.runs * self.peer_run + self.peer_rest


@cache
def measured() -> Cost:
    """The table, measured once."""
    one = compile_sweep(sweep())
    one.chunk(0, 8)  # compiled before it is timed
    turns = [(timed(lambda: march(one)), timed(lambda: keep(one))) for _ in range(TURNS)]
    others = max(0.0, os.getloadavg()[0] - 1) if hasattr(os, "getloadavg") else 0.0
    whole = command()
    peer_run, peer_rest = peer(one)
    return Cost(
        one.sweep.design.size,
        len(range(0, one.sweep.design.size, one.sweep.halved)),
        whole["wall"],
        whole["cpu"],
        whole["memory"],
        median(turn[0][0] for turn in turns),
        median(turn[1][0] for turn in turns),
        median(turn[1][1] for turn in turns),
        peer_run,
        peer_rest,
        others,
        tuple(1 - marched[0] / kept[0] for marched, kept in turns),
    )


def timed(work: Callable[[], object]) -> tuple[float, float]:
    """Seconds of all cores together, and by the clock."""
    cpu, wall = process_time(), perf_counter()
    work()
    return process_time() - cpu, perf_counter() - wall


def march(one: CompiledSweep) -> None:
    """All rows by the engine alone, those at half of the step among them, with as many kept times."""
    for first, last in one.chunks:
        p, x0 = one.rows(first, last)
        runs = np.arange(first, last)
        again = runs % one.sweep.halved == 0
        for step, some in ((one.fine, again), (one.coarse, runs >= 0)):
            simulate(step, p[some], x0[some], until=one.sweep.run.until, every=one.every, runs=runs[some])


def keep(one: CompiledSweep) -> Sample:
    """The same through plan, executor, ledger and sample, in a folder of its own."""
    with TemporaryDirectory(prefix="workbench-b2-") as folder, opened(Path(folder), False) as ledger:
        tasks = tasks_of([one])
        complete(tasks, ledger, lambda missing: on_threads([one], missing))
        return one.sample(ledger.read(task.name) for task in tasks)


def command() -> dict[str, float]:
    """What the whole command takes, from its start to the report, compilation included."""
    with TemporaryDirectory(prefix="workbench-b2-") as folder:
        environment = {**os.environ, "WORKBENCH_CACHE": "off", "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
        call = [sys.executable, "-c", PROBE, str(SCRIPT), "--out", str(Path(folder) / "report")]
        done = subprocess.run(call, env=environment, check=True, text=True, stdout=subprocess.PIPE)
    found: dict[str, float] = json.loads(done.stdout)
    return found


def peer(one: CompiledSweep) -> tuple[float | None, float | None]:
    """Seconds of python-control for one run, and of SALib for the analysis of all outputs."""
    control = next(each for each in PEERS if each.package == "control")
    if not control.installed:
        return None, None
    design = sweep().design
    noise = np.random.default_rng(0).random((design.size, len(one.columns)))
    analysis, _ = timed(lambda: sobol_by_salib(design, noise))
    run = control.runner(HORIZON)
    p, _ = one.rows(0, PEER_RUNS)
    spent, _ = timed(lambda: run(p))
    return spent / PEER_RUNS, analysis


def sections(results: Results) -> Sequence[Section]:
    """What the report says."""
    del results
    return (section(measured()),)


def section(cost: Cost) -> Section:
    """The bars and the table."""
    about = dict(machine())
    versions = ", ".join(f"{name} {version}" for name, version in about.items() if name != "cpu")
    return Section(
        "What it takes",
        (
            Paragraph(
                f"Measured on {about['cpu']} with {versions}. These are times: another run of this study gives other "
                "digits, and a machine that others use too gives longer ones by the clock; processor time is then the "
                "fairer measure."
            ),
            *verdicts(cost),
            table(cost),
            Itemize(
                (
                    f"The command: {cost.runs:,} runs of 10 s at 1 ms and {cost.again:,} of them again at 0.5 ms, from "
                    "its start to HTML, PDF and CSV, the kernel compiled afresh.",
                    "Ledger and orchestration: the names of chunks, their bytes, digests and commits, and the sample "
                    "put together again; against the engine on the same rows, with nothing kept.",
                    f"The peer: python-control with its default settings on {PEER_RUNS} of the same rows, scaled to "
                    "all of them, without any at half of the step; SALib analyses four outputs.",
                )
            ),
        ),
    )


def verdicts(cost: Cost) -> tuple[Verdict, ...]:
    """What was asked for, and whether it was reached."""
    reached = {name: getattr(cost, name) <= BARS[name] for name in ("wall", "memory")}
    sure, likely = max(cost.shares) <= BARS["share"], median(cost.shares) <= BARS["share"]
    return (
        Verdict(
            "holds" if reached["wall"] else "fails" if cost.others < BUSY else "open",
            f"The whole command takes at most {BARS['wall']:g} s.",
            f"{cost.wall:.1f} s by the clock, {cost.cpu:.1f} s of processor time, beside {cost.others:.1f} other "
            f"processes on {os.cpu_count()} processors.",
        ),
        Verdict(
            "holds" if reached["memory"] else "fails",
            f"It holds less than {BARS['memory']:g} GB.",
            f"At most {cost.memory:.2f} GB.",
        ),
        Verdict(
            "holds" if sure else "open" if likely else "fails",
            f"Ledger and orchestration take at most {BARS['share']:.0%} of the processor time.",
            f"{median(cost.shares):.1%} in the median of {len(cost.shares)} turns, from {min(cost.shares):.1%} to "
            f"{max(cost.shares):.1%}, where below zero is noise: {cost.kept:.2f} s through them, {cost.marched:.2f} s "
            "without.",
        ),
    )


def table(cost: Cost) -> Table:
    """Rows for the command, its parts and the peer."""
    rows: list[tuple[Cell, ...]] = [
        ("the whole command", f"{cost.runs:,} + {cost.again:,}", _s(cost.wall), _s(cost.cpu), f"{cost.memory:.2f}"),
        ("its runs through the ledger", f"{cost.runs:,} + {cost.again:,}", _s(cost.kept_wall), _s(cost.kept), None),
        ("its runs alone", f"{cost.runs:,} + {cost.again:,}", None, _s(cost.marched), None),
        ("SALib and python-control, extrapolated", f"{cost.runs:,}", None, cost.peer and f"{cost.peer:,.0f}", None),
    ]
    columns = (
        Column("what"),
        Column("runs + at half of the step", align="right"),
        Column("by the clock", "s", "right"),
        Column("processor time", "s", "right"),
        Column("memory", "GB", "right"),
    )
    if cost.peer is None:
        note = "SALib and python-control are not installed here."
    else:
        note = f"The peer would take {cost.peer / cost.cpu:,.0f} times as much processor time as the whole command."
    return Table("cost", "What a Sobol study takes.", columns, tuple(rows), (note,))


def _s(seconds: float) -> str:
    return f"{seconds:.2f}"


def headlines(results: Results) -> Sequence[str]:
    """The verdicts in a line each."""
    del results
    return tuple(f"{one.kind}: {one.statement} {one.evidence}" for one in verdicts(measured()))


study = Study(
    name="b2_sobol_cost",
    title="A Sobol study of 12,288 runs: what it takes",
    question=(
        "How long does the study b2_workload take from the command to the report, with how much memory? How much of "
        "its processor time goes to ledger and orchestration? And how long would SALib and python-control take?"
    ),
    method=(
        "The command is run in a process of its own, on an empty folder. Ledger and orchestration are what the same "
        "rows take more through the ledger than marched alone, in turns, medians of processor time. The peer runs a "
        "few of the same rows; its time for all of them is extrapolated, with SALib's analysis."
    ),
    sections=sections,
    headlines=headlines,
    fingerprints={"W": sweep().run.loop.fingerprint[:16]},
    measures_time=True,
)

"""A sampled loop run in the portable arithmetic, as the rows of its law, and the law in Python on these rows."""

import json
import subprocess
import sys
from typing import NamedTuple

import numpy as np

import workbench as wb
from tests.support.c_runs import differing, recorded
from workbench.blocks.loop import ClosedLoop
from workbench.core.sampled_law import SampledLaw
from workbench.core.validation.refusals import Array


class Record(NamedTuple):
    """The rows of a run, one an instant: what the law was handed, what it commanded, and what it kept."""

    law: SampledLaw
    readings: Array  # (n, readings)
    references: Array  # (n, references)
    commands: Array  # (n, commands)
    memory: Array  # (n, memory), after each instant


def record(loop, period, instants, instruments=None, delay=False, reference="input"):
    """The law of a loop in a computer, and so many instants of it."""
    sampled = loop.digital(period, instruments, delay=delay)
    law = sampled.law(reference, truths=tuple(name for name in loop.plant.truths.names if name in loop.observer.reads))
    return Record(law, *recorded(sampled, law, instants))


MOTOR = wb.DCMotor()
STEP = wb.Step("omega", "rad/s", 1.0)


def pid(**others):
    law = wb.PID(MOTOR.outputs, MOTOR.inputs, Kp=100.0, Ki=200.0, Kd=10.0, b=0.7, **others)
    return ClosedLoop(MOTOR, controller=law, reference=STEP)


REPLAY = """
import importlib.util, json, sys
from struct import pack
spec = importlib.util.spec_from_file_location("law", sys.argv[1])
module = importlib.util.module_from_spec(spec)
spec.loader.exec_module(module)
settings, rows = json.load(sys.stdin)
law = module.Law(**settings)
for readings, references in rows:
    commands = law.step(readings, references)
    print(json.dumps([commands, law.memory, law.flags]))
assert "workbench" not in sys.modules and "numpy" not in sys.modules and "casadi" not in sys.modules
"""


def of(port, row):
    """The numbers of a port by name, as a module of Python takes them."""
    return {
        e.name: row[port.slice(e.name)].tolist() if e.shape else float(row[port.slice(e.name)][0]) for e in port.entries
    }


def flat(port, values):
    return np.concatenate([np.zeros(0), *(np.atleast_1d(values[name]) for name in port.names)])


def replayed(run, text, folder, settings=None):
    """The commands and memories that the module gives in a Python of its own, without our packages."""
    (folder / "law.py").write_text(text, encoding="utf-8")
    law = run.law
    rows = [[of(law.readings, y), of(law.references, r)] for y, r in zip(run.readings, run.references, strict=True)]
    command = [sys.executable, "-S", "-I", "-c", REPLAY, folder / "law.py"]
    told = subprocess.run(
        command, input=json.dumps([settings or {}, rows]), capture_output=True, text=True, timeout=60, check=True
    )
    return [json.loads(line) for line in told.stdout.splitlines()]


def run_here(run, text):
    """The same in this process, which has our packages: no other one starts."""
    space = {"__name__": "law"}
    exec(compile(text, "law", "exec"), space)
    law, told = space["Law"](), []
    for y, r in zip(run.readings, run.references, strict=True):
        commands = law.step(of(run.law.readings, y), of(run.law.references, r))
        told.append([commands, law.memory, law.flags])
    return told


def agree(run, told):
    assert {flags for *_, flags in told} == {0}
    ours = np.array([flat(run.law.commands, commands) for commands, *_ in told])
    assert differing(ours, run.commands) == 0
    memories = np.array([flat(run.law.memory, memory) for _, memory, _ in told])
    assert differing(memories, run.memory) == 0

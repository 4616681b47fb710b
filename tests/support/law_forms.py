"""A sampled loop run in the portable arithmetic, as the rows of its law; and the loop of a motor with a PID law."""

from typing import NamedTuple

import workbench as wb
from tests.support.c_runs import recorded
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
    law = wb.PID2(MOTOR.outputs, MOTOR.inputs, Kp=100.0, Ki=200.0, Kd=10.0, b=0.7, **others)
    return ClosedLoop(MOTOR, controller=law, reference=STEP)

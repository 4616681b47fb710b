"""A sampled loop run in the portable arithmetic, as the readings, references, memories and commands of its law."""

from typing import NamedTuple

import casadi as ca
import numpy as np

import workbench as wb
from workbench.core import Entry, Layout
from workbench.core.sampled_law import SampledLaw
from workbench.validation.refusals import Array


class Record(NamedTuple):
    """The rows of a run, one an instant: what the law was handed, what it kept, and what it commanded."""

    law: SampledLaw
    readings: Array  # (n, readings)
    references: Array  # (n, references)
    memory: Array  # (n, memory), after each instant
    commands: Array  # (n, commands)


def record(loop, period, instants, instruments=None, delay=False, seed=1):
    """The law of a digital loop and what a run of so many instants in the portable arithmetic handed it and got."""
    digital = loop.digital(period, instruments, delay=delay)
    truths = tuple(name for name in loop.plant.truths.names if name in loop.observer.reads)
    law = digital.law(truths=truths)
    taken = Layout(tuple(Entry(name, np.zeros(part.numel())) for name, part in digital.taken.items()))
    step = digital.step(4).extended(
        taken, ca.SX.sym("taken", taken.size), ca.vertcat(*map(ca.vec, digital.taken.values()))
    )
    run = wb.simulate(step, until=instants * period, arithmetic="portable", seed=seed)
    rows = run.x[0][1:]

    def of(names, empty=len(rows)):
        return np.concatenate([np.zeros((empty, 0)), *(rows[:, step.states.slice(name)] for name in names)], axis=1)

    return Record(
        law,
        of(f"y.{name}" for name in law.readings.names),
        of(f"r.{name}" for name in law.references.names),
        of(law.memory.names),
        of(f"hold.{name}" for name in law.commands.names),
    )


def bits(rows):
    """The bits of doubles."""
    return np.ascontiguousarray(rows, dtype=float).view(np.int64)

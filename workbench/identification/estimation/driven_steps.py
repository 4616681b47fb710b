"""Steps of an equation along a record, and with directions of change beside the states, built once for all records."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from workbench.core import Ode, StepMap
from workbench.core.recorded_step import SignalRecord, recorded_step, with_directions
from workbench.core.validation.refusals import Array


def plain_step(ode: Ode, record: SignalRecord) -> StepMap:
    """The step of an equation along a record."""
    return replace(_plain(ode, record.labels), recorded_numbers=record.rows)


def directed_step(ode: Ode, record: SignalRecord, parameters: tuple[int, ...], slopes: tuple[Array, ...]) -> StepMap:
    """The same with a direction of change carried along, as `with_directions` has it."""
    step = _directed(ode, record.labels, parameters, len(slopes))
    return replace(step, recorded_numbers=np.column_stack([record.rows, *slopes]))


@lru_cache(maxsize=64)
def _plain(ode: Ode, labels: tuple[str, ...]) -> StepMap:
    return recorded_step(ode, _any_record(labels))


@lru_cache(maxsize=64)
def _directed(ode: Ode, labels: tuple[str, ...], parameters: tuple[int, ...], delays: int) -> StepMap:
    record = _any_record(labels)
    slopes = {str(i): np.zeros_like(record.rows) for i in range(delays)}
    return with_directions(recorded_step(ode, record), parameters, slopes)


def _any_record(labels: tuple[str, ...]) -> SignalRecord:
    return SignalRecord(np.arange(2.0), labels, np.zeros((1, len(labels))), np.zeros((1, len(labels))))

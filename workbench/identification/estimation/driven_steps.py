"""Steps of a system along a record, and with directions of change beside the states, built once for all records."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from workbench.core import Ode, SampledSystem, StepMap
from workbench.core.recorded_step import SignalRecord, recorded_step, with_directions
from workbench.core.sampled_record import SampledRecord, recorded_sampled_step
from workbench.core.validation.refusals import Array


def plain_step(system: Ode | SampledSystem, record: SignalRecord | SampledRecord) -> StepMap:
    """The step of a system along a record, which has the jumps of a `SampledSystem`."""
    return replace(_plain(system, record.labels), recorded_numbers=record.rows)


def directed_step(
    system: Ode | SampledSystem,
    record: SignalRecord | SampledRecord,
    parameters: tuple[int, ...],
    slopes: tuple[Array, ...],
) -> StepMap:
    """The same with a direction of change carried along, as `with_directions` has it."""
    step = _directed(system, record.labels, parameters, len(slopes))
    return replace(step, recorded_numbers=np.column_stack([record.rows, *slopes]))


@lru_cache(maxsize=64)
def _plain(system: Ode | SampledSystem, labels: tuple[str, ...]) -> StepMap:
    none = np.zeros((1, len(labels)))
    record = SignalRecord(np.arange(2.0), labels, none, none)
    if isinstance(system, SampledSystem):
        return recorded_sampled_step(system, SampledRecord(record, np.zeros(1, dtype=int), none))
    return recorded_step(system, record)


@lru_cache(maxsize=64)
def _directed(
    system: Ode | SampledSystem, labels: tuple[str, ...], parameters: tuple[int, ...], delays: int
) -> StepMap:
    step = _plain(system, labels)
    assert step.recorded_numbers is not None  # of the one row of any record
    slopes = {str(i): np.zeros_like(step.recorded_numbers) for i in range(delays)}
    return with_directions(step, parameters, slopes)

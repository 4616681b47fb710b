"""The sampling instants of a computer among the samples of a log, and the record of a run that meets them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from workbench.core.recorded_step import SignalRecord
from workbench.core.sampled_record import SampledRecord
from workbench.core.validation.refusals import Array, Integers

SAME = 1e-6  # of a period: a sample so near to a sampling instant is at that instant


class SamplingInstants(NamedTuple):
    """Sampling instants by their numbers k (K,), and their times (K,) in s: k T, or those of the samples there."""

    numbers: Integers
    times: Array


def sampling_instants(t: Array, period: float) -> SamplingInstants:
    """The sampling instants k T, k = 0, 1, ..., from the first of the times t (N,) to the last."""
    first, last = np.ceil(t[0] / period - SAME), np.floor(t[-1] / period + SAME)
    numbers = np.arange(max(int(first), 0), int(last) + 1)
    times = numbers * period
    right = np.clip(np.searchsorted(t, times), 1, len(t) - 1)
    near = t[np.where(times - t[right - 1] <= t[right] - times, right - 1, right)]
    return SamplingInstants(numbers, np.where(np.abs(near - times) <= SAME * period, near, times))


def with_jumps(
    record: SignalRecord, places: Integers, times: Array, at_times: Array, instants: SamplingInstants, starts: bool
) -> SampledRecord:
    """The record of a run with a jump at each sampling instant behind its begin.

    Parameters
    ----------
    record
        The inputs in intervals as short as a step.
    places
        (M,), the places of the instants `times` among those of the record.
    times, at_times
        (M,) and (M, nd), all instants in s, and the inputs as they are read there.
    starts
        True if the run begins with the jump of its first instant, in an interval of no length; else it begins behind.
    """
    jumps, readings = np.full(len(record.begins), -1), record.ends.copy()
    at = np.searchsorted(times, instants.times)
    later = at > 0
    jumps[places[at[later]] - 1] = instants.numbers[later]
    readings[places[at[later]] - 1] = at_times[at[later]]
    if starts:
        first = record.begins[:1]
        record = SignalRecord(
            np.append(record.t[0], record.t),
            record.labels,
            np.vstack([first, record.begins]),
            np.vstack([first, record.ends]),
        )
        jumps, readings = np.append(instants.numbers[0], jumps), np.vstack([at_times[:1], readings])
    return SampledRecord(record, jumps, readings)

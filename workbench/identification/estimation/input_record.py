"""The record of an experiment's inputs along its samples, and how it changes with the delays of the inputs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from workbench.core.recorded_step import SignalRecord, record_rows
from workbench.core.sampled_record import SampledRecord
from workbench.core.validation.refusals import Array, Integers
from workbench.identification.datasets import Experiment
from workbench.identification.datasets.experiment import Marks
from workbench.identification.estimation.sampling_instants import sampling_instants, with_jumps

HOLDS = {
    "hold": "the value of a sample until the next sample, as a computer holds its command",
    "linear": "straight lines between the samples",
}


class MeasuredInput(NamedTuple):
    """A signal of a log that drives a parameter of an equation."""

    signal: str  # the label in the log
    label: str  # of the parameter
    hold: str  # a name of `HOLDS`


class InputPieces(NamedTuple):
    """Instants t (N + 1,) and numbers at the begin and the end of each interval (N, nd); or their derivatives."""

    t: Array
    begins: Array
    ends: Array

    def divide(self, counts: Integers) -> InputPieces:
        """The same with each interval divided into as many equal parts as `counts` (N,) says."""
        of = np.repeat(np.arange(len(counts)), counts)
        place = np.arange(len(of)) - np.repeat(np.cumsum(counts) - counts, counts)  # of a part in its interval
        first, last = ((part / counts[of])[:, np.newaxis] for part in (place, place + 1.0))
        instants = np.append(self.t[of] + first[:, 0] * np.diff(self.t)[of], self.t[-1])
        begins, ends = (self.begins[of] + share * (self.ends - self.begins)[of] for share in (first, last))
        return InputPieces(instants, begins, ends)


class InputRecord(NamedTuple):
    """Inputs between instants in s, among which are the samples of an experiment."""

    record: SignalRecord | SampledRecord
    samples: Integers  # (N,), the places of the samples among the instants
    at_samples: Array  # (N, nd), the inputs at the samples
    changes: Mapping[str, Array]  # by input with a delay, the derivative of `at_samples` with respect to the delay
    slopes: Mapping[str, Array]  # by input with a delay, the derivative of `record.rows` with respect to the delay


def input_record(
    experiment: Experiment,
    inputs: Sequence[MeasuredInput],
    delays: Mapping[str, float],
    instants: Array,
    h: float,
    begin: float = 0.0,
    period: float | None = None,
) -> InputRecord:
    """The record of the inputs of an experiment.

    Parameters
    ----------
    experiment
        The experiment, whose times increase and whose inputs are finite.
    inputs, delays
        The inputs, and delays in s of some, by their labels in the experiment. Before its first delayed sample an input
        has the value of that sample.
    instants
        Further instants in s, such as those at which a reference jumps.
    h, begin
        The longest interval in s, as longer ones are divided into equal parts, and the time of the first sample in s.
    period
        The sampling period in s of a computer. A run from 0 begins with its jump, a later one behind its first one.
    """
    t = experiment.t - experiment.t[0] + begin
    clock = None if period is None else sampling_instants(t, period)
    inner = _within(t, instants if clock is None else np.union1d(instants, clock.times))
    knots = {one.signal: t + delays[one.signal] for one in inputs if one.signal in delays}
    times, owner = _instants(t, [inner, *knots.values()])
    sources = {one.signal: 0 for one in inputs} | {signal: 2 + i for i, signal in enumerate(knots)}
    parts = [
        _between(times, owner == sources[one.signal], knots.get(one.signal, t), _values(experiment, one), one.hold)
        for one in inputs
    ]
    begins, ends, rates = np.reshape(parts, (len(inputs), 3, len(times) - 1)).transpose(1, 2, 0)
    counts = np.maximum(np.ceil(np.diff(times) / h * (1 - 1e-9)), 1).astype(int)
    whole, samples = InputPieces(times, begins, ends).divide(counts), np.flatnonzero(owner == 0)
    changes, slopes = {}, {}
    for signal in knots:
        own, moves = rates * [one.signal == signal for one in inputs], (owner == sources[signal]).astype(float)
        slopes[signal] = record_rows(*_slope(moves, rates, own).divide(counts))
        changes[signal] = -np.vstack([own[samples[:-1]], own[-1:]])
    final = [ends[-1, i] if one.signal in delays else _values(experiment, one)[-1] for i, one in enumerate(inputs)]
    at_times, places = np.vstack([begins, np.reshape(final, (1, -1))]), np.append(0, np.cumsum(counts))
    record = SignalRecord(whole.t, tuple(one.label for one in inputs), whole.begins, whole.ends)
    sampled = record if clock is None else with_jumps(record, places, times, at_times, clock, begin == 0.0)
    places = places[samples] + len(sampled.t) - len(record.t)  # one more where a run begins with a jump
    return InputRecord(sampled, places, at_times[samples], changes, slopes)


def _within(t: Array, instants: Array) -> Array:
    """The instants between the first and the last of the times t (N,) that are none of them."""
    return np.setdiff1d(instants[(instants > t[0]) & (instants < t[-1])], t)


def _instants(t: Array, others: Sequence[Array]) -> tuple[Array, Integers]:
    """All instants up to the last sample in their order, and of each its owner: 0 for samples, then the `others`.

    A sample is before the knots at its time, as a delay moves them behind it.
    """
    times = np.concatenate([t, *others])
    owner = np.repeat(np.arange(1 + len(others)), [len(t), *map(len, others)])
    order = np.lexsort((owner, times))
    order = order[(times[order] < t[-1]) | (owner[order] == 0)]
    return times[order], owner[order]


def _values(experiment: Experiment, one: MeasuredInput) -> Array:
    """The samples (N,) of an input."""
    return np.asarray(experiment.values[:, experiment.signals.labels.index(one.signal)])


def _between(times: Array, is_knot: Marks, knots: Array, values: Array, hold: str) -> tuple[Array, Array, Array]:
    """The begin, the end and the rate of change of an input in each interval between the times."""
    count = np.cumsum(is_knot)[:-1]  # of knots at or before the begin of each interval
    row = np.maximum(count - 1, 0)
    begin = values[row]
    if hold == "hold":
        return begin, begin, np.zeros_like(begin)
    slopes = np.append(np.diff(values) / np.diff(knots), 0.0)
    rates = np.where(count > 0, slopes[row], 0.0)
    first, last = (begin + rates * (at - knots[row]) for at in (times[:-1], times[1:]))
    return first, last, rates


def _slope(moves: Array, rates: Array, own: Array) -> InputPieces:
    """The derivative of the pieces by a delay, which moves instants by `moves` (N + 1,), and inputs of `own` rates."""
    first, last = moves[:-1, np.newaxis], moves[1:, np.newaxis]
    return InputPieces(moves, rates * first - own, rates * last - own)

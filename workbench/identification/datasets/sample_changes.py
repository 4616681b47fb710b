"""Changes of the samples of one experiment, each with the number of samples that it touched."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from workbench.core import Entry, Layout
from workbench.core.units import per_second
from workbench.core.validation.refusals import Array, describe, positive, whole
from workbench.identification.datasets.experiment import Experiment, Marks

NORMAL = 1.482602218505602  # standard deviations of a normal distribution in its median absolute deviation
GAP = 2.5  # periods: a step of time beyond it is a gap, unless the user says another one


def select_signals(experiment: Experiment, places: Sequence[int], layout: Layout) -> Experiment:
    """The experiment with some of its columns."""
    columns = list(places)
    return Experiment(
        experiment.name, experiment.t, layout, experiment.values[:, columns], experiment.marks[:, columns]
    )


def join_signals(one: Experiment, other: Experiment) -> Experiment:
    """The signals of both at the union of their times; NaN where one of them has no sample."""
    for part in (one, other):
        refuse_fallen_times("Dataset.join(other=...)", part)
    t = np.union1d(one.t, other.t)
    values = np.full((t.size, one.signals.size + other.signals.size), np.nan)
    marks = np.zeros(values.shape, dtype=bool)
    for part, columns in ((one, slice(None, one.signals.size)), (other, slice(one.signals.size, None))):
        rows = np.searchsorted(t, part.t)
        values[rows, columns] = part.values
        marks[rows, columns] = part.marks
    return Experiment(one.name, t, one.signals + other.signals, values, marks)


def unwrap_columns(experiment: Experiment, places: Sequence[int], turns: Sequence[float]) -> tuple[Experiment, int]:
    """Angles with full turns added so that no step is longer than half of one; NaN stays; and the number of jumps."""
    values, count = experiment.values.copy(), 0
    for place, turn in zip(places, turns, strict=True):
        rows = np.flatnonzero(np.isfinite(values[:, place]))
        angle = values[rows, place]
        values[rows, place] = np.unwrap(angle, period=turn)
        count += int((np.abs(np.diff(angle)) > turn / 2).sum())
    return replace(experiment, values=values), count


def merge_times(experiment: Experiment, keep: str) -> tuple[Experiment, int]:
    """One row of those with the same time, and the number of rows that were left out."""
    steps = np.diff(experiment.t)
    starts = np.flatnonzero(np.append(True, steps != 0)) if len(experiment) else np.zeros(0, dtype=int)
    if keep == "mean":
        groups = np.split(np.arange(len(experiment)), starts[1:])
        weighed = np.where(experiment.is_weighed, experiment.values, np.nan)
        values = np.array(
            [_mean(weighed[group]) if len(group) > 1 else experiment.values[group[0]] for group in groups]
        )
        marks = np.array([experiment.marks[group].all(axis=0) for group in groups])
        merged = Experiment(experiment.name, experiment.t[starts], experiment.signals, values, marks)
        return merged, len(experiment) - len(merged)
    rows = starts if keep == "first" else np.append(starts[1:], len(experiment)) - 1
    return experiment.at_rows(rows), len(experiment) - len(rows)


def _mean(rows: Array) -> Array:
    counts = np.isfinite(rows).sum(axis=0)
    return np.where(counts, np.nansum(rows, axis=0) / np.maximum(counts, 1), np.nan)


def resample_samples(
    experiment: Experiment, period: float, is_held: Marks, gap: float | None
) -> tuple[Experiment, int, int]:
    """Samples at even times, and the numbers of those that are NaN in gaps and of marked ones that were passed over."""
    call = "Dataset.resample(period=...)"
    refuse_fallen_times(call, experiment)
    span = experiment.t[-1] - experiment.t[0]
    if not 0 < period <= span:
        raise ValueError(
            f"`{call}` must be positive and at most the length of the experiment; '{experiment.name}' has {span:.6g} "
            f"s, and the period is {period:g} s."
        )
    # 1e-9: the rounding of a quotient of times
    t = experiment.t[0] + period * np.arange(int(np.floor(span / period * (1 + 1e-9))) + 1)
    values = np.full((t.size, experiment.signals.size), np.nan)
    for column in range(experiment.signals.size):
        use = experiment.is_weighed[:, column]
        if use.sum() > 1:
            values[:, column] = _between(experiment.t[use], experiment.values[use, column], t, is_held[column], gap)
    passed = int((experiment.marks & np.isfinite(experiment.values)).sum())
    return Experiment(experiment.name, t, experiment.signals, values), int(np.isnan(values).sum()), passed


def _between(times: Array, numbers: Array, t: Array, is_held: bool, gap: float | None) -> Array:
    """Numbers at the times t between samples, NaN in a gap and outside of them."""
    longest = GAP * float(np.median(np.diff(times))) if gap is None else gap
    near = 1e-9 * max(float(np.median(np.diff(times))), 1e-12)  # of a period: the rounding of a time
    left = np.clip(np.searchsorted(times, t + near, side="right") - 1, 0, times.size - 1)
    right = np.minimum(left + 1, times.size - 1)
    lengths = times[right] - times[left]
    shares = np.where(lengths > 0, (t - times[left]) / np.where(lengths > 0, lengths, 1.0), 0.0)
    is_at = np.abs(t - times[left]) <= near
    shares = np.where(is_at, 0.0, shares)
    inside = (t >= times[0] - near) & (t <= times[-1] + near) & (is_at | (lengths <= longest * (1 + 1e-9)))
    result = numbers[left] + (0.0 if is_held else shares * (numbers[right] - numbers[left]))
    return np.where(inside, result, np.nan)


def filter_samples(experiment: Experiment, places: Sequence[int], cutoff: float, order: int) -> Experiment:
    """The experiment with columns filtered forward and backward by a Butterworth filter, without a phase."""
    from scipy.signal import butter, sosfiltfilt

    call = "Dataset.filter(cutoff=...)"
    refuse_uneven(call, experiment, places)
    highest = 0.5 / experiment.period
    if not 0 < positive(call, cutoff, " of Hz") < highest:
        raise ValueError(
            f"`{call}` must lie below half of the rate, {highest:.6g} Hz in '{experiment.name}'; got {cutoff:g} Hz."
        )
    sections = butter(whole("Dataset.filter(order=...)", order, 1, 20), cutoff, fs=1 / experiment.period, output="sos")
    least = 3 * (2 * len(sections) + 1)  # of the reflected ends of `sosfiltfilt`, for any order
    if len(experiment) <= least:
        raise ValueError(
            f"`{call}` must have more than {least} samples for its order; '{experiment.name}' has {len(experiment)}."
        )
    values = experiment.values.copy()
    values[:, list(places)] = sosfiltfilt(sections, values[:, list(places)], axis=0)
    return replace(experiment, values=values)


def differentiate_samples(
    experiment: Experiment, signal: str, name: str, window: float, degree: int, order: int
) -> Experiment:
    """The experiment with the derivative of a signal as a further one, by the polynomials of Savitzky and Golay."""
    from scipy.signal import savgol_filter

    call = "Dataset.differentiate(window=...)"
    places = experiment.columns([signal])
    refuse_uneven(call, experiment, places)
    count = 2 * round(window / experiment.period / 2) + 1
    if not max(degree + 1, 3) <= count <= len(experiment):
        raise ValueError(
            f"`{call}` must span more than {degree} samples, the degree, and at most all {len(experiment)} of "
            f"'{experiment.name}'; {window:g} s are {count} samples of {experiment.period:.6g} s."
        )
    numbers = experiment.values[:, list(places)]
    slopes = savgol_filter(numbers, count, degree, deriv=order, delta=experiment.period, axis=0)
    own = next((entry for entry in experiment.signals.entries if entry.name == signal), None)
    units = [unit for entry in experiment.signals.entries for unit in entry.units]
    unit = per_second(own.unit if own else units[places[0]], order)
    entry = replace(own, name=name, unit=unit) if own else Entry(name, np.zeros(()), unit)
    marks = np.hstack([experiment.marks, np.zeros(slopes.shape, dtype=bool)])
    signals = experiment.signals + Layout((entry,))
    return Experiment(experiment.name, experiment.t, signals, np.hstack([experiment.values, slopes]), marks)


def find_outliers(experiment: Experiment, places: Sequence[int], window: int, threshold: float) -> Marks:
    """True for samples that lie `threshold` deviations off the median of their window (Hampel)."""
    marks = np.zeros(experiment.values.shape, dtype=bool)
    for column in places:
        rows = np.flatnonzero(experiment.is_weighed[:, column])
        numbers = experiment.values[rows, column]
        if rows.size < window:
            continue
        steps = np.abs(np.diff(numbers))
        quantum = float(steps[steps > 0].min()) if (steps > 0).any() else 0.0
        medians, deviations = _window_medians(numbers, window)
        least = max(quantum, float(np.median(deviations)))  # a window of few samples may have next to no spread
        off = np.abs(numbers - medians) > threshold * np.maximum(deviations, least)
        marks[rows[off], column] = True
    return marks


def _window_medians(numbers: Array, window: int) -> tuple[Array, Array]:
    """The median of each sample with its neighbours, and the standard deviation by their median absolute deviation."""
    padded = np.pad(numbers, window // 2, mode="reflect")
    medians, deviations = np.zeros(numbers.size), np.zeros(numbers.size)
    for first in range(0, numbers.size, 2**16):  # so that the windows of a long log fit into memory
        part = slice(first, first + 2**16)
        windows = np.lib.stride_tricks.sliding_window_view(padded[first : first + 2**16 + window - 1], window)
        medians[part] = np.median(windows, axis=1)
        deviations[part] = NORMAL * np.median(np.abs(windows - medians[part, np.newaxis]), axis=1)
    return medians, deviations


def refuse_fallen_times(call: str, experiment: Experiment) -> None:
    """Refuse times that do not increase."""
    falls = np.flatnonzero(~(np.diff(experiment.t) > 0))
    if falls.size or len(experiment) < 2:
        row = int(falls[0]) + 1 if falls.size else 0
        got = f"row {row} has {experiment.t[row]:.9g} s after {experiment.t[row - 1]:.9g} s" if falls.size else "it has"
        raise ValueError(
            f"`{call}` must have at least two times that increase; in '{experiment.name}' {got}"
            f"{'' if falls.size else f' {len(experiment)}'}: `merge_repeated` merges rows of one time, and a log whose "
            "time runs backward is cut there."
        )


def refuse_uneven(call: str, experiment: Experiment, places: Sequence[int]) -> None:
    """Refuse columns whose samples are not even in time, are missing, or are marked."""
    if not experiment.is_uniform:
        steps = np.diff(experiment.t)
        spread = f"from {steps.min():.6g} to {steps.max():.6g} s" if steps.size else "of less than two samples"
        raise ValueError(
            f"`{call}` must have samples at even times; '{experiment.name}' has periods {spread}: write "
            "`log.resample(period)` first."
        )
    labels = experiment.signals.labels
    for column in places:
        lost = int((~experiment.is_weighed[:, column]).sum())
        if lost:
            raise ValueError(
                f"`{call}` must have all samples, as it spreads each over its neighbours; {describe(labels[column])} "
                f"of '{experiment.name}' has {lost} that are NaN or marked: `log.resample(period)` passes over them."
            )


def convert_columns(experiment: Experiment, factors: Mapping[str, tuple[float, str]]) -> Experiment:
    """The experiment with signals multiplied by factors, in new units."""
    entries = tuple(
        replace(entry, unit=factors[entry.name][1]) if entry.name in factors else entry
        for entry in experiment.signals.entries
    )
    values = experiment.values.copy()
    for name, (factor, _) in factors.items():
        values[:, experiment.signals.slice(name)] *= factor
    return replace(experiment, signals=Layout(entries), values=values)

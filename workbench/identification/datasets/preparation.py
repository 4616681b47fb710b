"""The preparation of samples for a fit: each step gives a new dataset, with a sentence in its notes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Self

import numpy as np

from workbench.core import Layout
from workbench.core.units import checked_unit
from workbench.core.validation.refusals import known_name, one_of, positive, refusal, seconds, whole
from workbench.core.validation.signatures import check_arguments
from workbench.identification.datasets.delay import DelayEstimate, estimate_delay
from workbench.identification.datasets.experiment import HOLDS, Experiment
from workbench.identification.datasets.sample_changes import (
    convert_columns,
    differentiate_samples,
    filter_samples,
    find_outliers,
    merge_times,
    resample_samples,
    select_signals,
    unwrap_columns,
)
from workbench.identification.datasets.signal_checks import TURNS, units_of
from workbench.identification.datasets.unit_scales import scale

KEEPS = ("first", "last", "mean")


class AbstractPreparation(ABC):
    """Experiments whose samples can be selected, resampled, filtered and marked; nothing is dropped in silence."""

    experiments: tuple[Experiment, ...]

    @abstractmethod
    def with_changes(self, experiments: Sequence[Experiment], note: str) -> Self:
        """The dataset with other experiments, and a sentence on what was done."""

    def _change(self, change: Callable[[Experiment], Experiment], note: str) -> Self:
        return self.with_changes([change(experiment) for experiment in self.experiments], note)

    @check_arguments
    def select(self, signals: Sequence[str]) -> Self:
        """The dataset with some of its signals, in the order in which they are named.

        Raises
        ------
        LookupError
            If there is no such signal.
        """
        layout = self.experiments[0].signals
        for name in signals:
            known_name(name, layout.names, "signals of this dataset")
        chosen = Layout(tuple(layout[name] for name in signals))
        others = [name for name in layout.names if name not in signals]
        note = f"The signals {', '.join(others)} were left out." if others else ""
        places = self.experiments[0].columns(signals)
        return self._change(lambda experiment: select_signals(experiment, places, chosen), note)

    @check_arguments
    def convert(self, units: Mapping[str, str]) -> Self:
        """The dataset with signals in other units of the same kind: `log.convert({"h": "m"})` of a signal in cm.

        Raises
        ------
        LookupError
            If there is no such signal.
        ValueError
            If its unit is unknown or of another kind.
        """
        layout, factors = self.experiments[0].signals, {}
        for name, text in units.items():
            known_name(name, layout.names, "signals of this dataset")
            unit, own = checked_unit("Dataset.convert(units=...)", text), layout[name].unit
            factor = None if own == "?" or "," in own + unit else scale(own, unit)
            if factor is None:
                raise ValueError(
                    f"`Dataset.convert(units=...)` must have a unit of the same kind; '{name}' is in [{own}], and got "
                    f"'{text}': give the unit of the file by `units` where it is read."
                )
            factors[name] = factor, unit
        words = [f"{name} from {layout[name].unit} to {unit}" for name, (_, unit) in factors.items()]
        note = f"Converted were {', '.join(words)}."
        return self._change(lambda experiment: convert_columns(experiment, factors), note)

    @check_arguments
    def merge_repeated(self, keep: str = "first") -> Self:
        """The dataset with one row for each time: of rows of one time the "first", the "last" or their "mean".

        The count of rows that were left out stands in the notes.
        """
        one_of("Dataset.merge_repeated(keep=...)", keep, KEEPS)
        merged = [merge_times(experiment, keep) for experiment in self.experiments]
        count = sum(rows for _, rows in merged)
        note = f"{count} rows had the time of the row before them; the {keep} of each was used."
        return self.with_changes([experiment for experiment, _ in merged], note)

    @check_arguments
    def resample(self, period: float, hold: Sequence[str] = (), gap: float | None = None) -> Self:
        """The dataset at even times from the first sample of each experiment, by interpolation between its samples.

        Samples in a gap are NaN, and so are those before the first sample of a signal and behind its last. Marked
        samples are passed over. There is no filter before it: signals above half of the new rate fold back.

        Parameters
        ----------
        period
            The time between two samples in s.
        hold
            Signals that keep a value until the next sample, such as the command of a computer. The others are
            interpolated by straight lines.
        gap
            The time in s without a sample that is a gap. The default is 2.5 of the median period of each signal;
            `np.inf` interpolates over everything.

        Raises
        ------
        ValueError
            If the period is not positive or longer than an experiment, or times do not increase.
        LookupError
            If there is no such signal.
        """
        seconds("Dataset.resample(period=...)", period)
        first = self.experiments[0]
        is_held = np.zeros(first.signals.size, dtype=bool)
        if hold:
            is_held[list(first.columns(hold))] = True
        parts = [resample_samples(experiment, period, is_held, gap) for experiment in self.experiments]
        lost, passed = sum(part[1] for part in parts), sum(part[2] for part in parts)
        note = f"Resampled at {period:g} s, {'held: ' + ', '.join(hold) if hold else 'by straight lines'}"
        note += f"; {lost} numbers in gaps or outside of a signal's samples are NaN" if lost else ""
        note += f"; {passed} marked samples were passed over" if passed else ""
        return self.with_changes([part[0] for part in parts], f"{note}.")

    @check_arguments
    def filter(self, cutoff: float, signals: Sequence[str] = (), order: int = 4) -> Self:
        """The dataset with signals low-passed without a phase: a Butterworth filter run forward and backward.

        At the cutoff the gain is 1/2, as each of the two runs has 1/sqrt(2). A filter of the outputs changes a fit,
        too, unless the inputs get the same.

        Parameters
        ----------
        cutoff
            The cutoff in Hz.
        signals
            The signals; the default is all of them.
        order
            The order of the filter in one direction.

        Raises
        ------
        ValueError
            If samples are not even in time, are NaN or are marked, or the cutoff is not below half of the rate.

        References
        ----------
        Gustafsson, Determining the initial states in forward-backward filtering, IEEE Trans. Signal Processing 44
        (1996) 988; `scipy.signal.sosfiltfilt`.
        """
        places = self.experiments[0].columns(signals)
        chosen = ", ".join(signals) or "all signals"
        note = f"Filtered at {cutoff:g} Hz, order {order} forward and backward: {chosen}."
        return self._change(lambda experiment: filter_samples(experiment, places, cutoff, order), note)

    @check_arguments
    def differentiate(self, signal: str, name: str, window: float, degree: int = 3, order: int = 1) -> Self:
        """The dataset with the derivative of a signal as a further signal, by local polynomials.

        Parameters
        ----------
        signal, name
            The signal, and the name of its derivative.
        window
            The span of one polynomial in s, rounded to an odd number of samples.
        degree, order
            The degree of the polynomials, and the order of the derivative.

        Raises
        ------
        ValueError
            If samples are not even in time, are NaN or are marked; or the window has too few or too many of them.

        References
        ----------
        Savitzky and Golay, Analytical Chemistry 36 (1964) 1627; `scipy.signal.savgol_filter`.
        """
        whole("Dataset.differentiate(order=...)", order, 1, degree)
        seconds("Dataset.differentiate(window=...)", window)
        note = f"{name} is derivative {order} of {signal}, by polynomials of degree {degree} over {window:g} s."
        return self._change(
            lambda experiment: differentiate_samples(experiment, signal, name, window, degree, order), note
        )

    @check_arguments
    def estimate_delay(self, u: str, y: str, longest: float | None = None, hold: str = "hold") -> DelayEstimate:
        """The delay of an output behind an input in s, with a 95 % interval.

            y(t) = c + K g(u(t - d)),   g a lag of first order or none, d >= 0

        Delay, lag and gain come from least squares, and the interval from the profile of the likelihood, with a number
        of samples that is lowered by the correlation of the residuals. A plant of higher order looks like a delay,
        too: `explained_share` says how well one lag serves.

        Parameters
        ----------
        u, y
            The input and the output: signals of one number, or labels of single numbers such as `q[0]`.
        longest
            The longest delay in s; the default is a quarter of an experiment.
        hold
            "hold" if the input keeps its value between samples, else "linear".

        Raises
        ------
        ValueError
            If samples are not even in time, are NaN or are marked; or the output is constant.

        References
        ----------
        Bjorklund, A survey and comparison of time-delay estimation methods in linear systems (2003), section 5.
        """
        one_of("Dataset.estimate_delay(hold=...)", hold, HOLDS)
        places = [self.experiments[0].columns([name]) for name in (u, y)]
        for name, columns in zip((u, y), places, strict=True):
            if len(columns) != 1:
                raise refusal("Dataset.estimate_delay(...)", "two signals of one number each, such as `q[0]`", name)
        return estimate_delay(self.experiments, (places[0][0], places[1][0]), longest, hold == "hold")

    @check_arguments
    def mark_outliers(self, signals: Sequence[str] = (), window: int = 11, threshold: float = 5.0) -> Self:
        """The dataset with outliers marked: samples that lie off the median of their neighbours (Hampel's identifier).

        They keep their values and get no weight in a fit.

        Parameters
        ----------
        signals
            The signals; the default is all of them.
        window
            An odd number of samples: one and its neighbours.
        threshold
            The distance from the median in standard deviations, by the median absolute deviation of the window. That
            counts as at least the one of the median window, and as one quantum of the signal.

        References
        ----------
        Pearson, Outliers in process modeling and identification, IEEE Trans. Control Systems Technology 10 (2002) 55.
        """
        whole("Dataset.mark_outliers(window=...)", window, 3)
        positive("Dataset.mark_outliers(threshold=...)", threshold)
        if not window % 2:
            raise refusal("Dataset.mark_outliers(window=...)", "odd, as a sample lies in its middle", window)
        places = self.experiments[0].columns(signals)
        marks = [find_outliers(experiment, places, window, threshold) for experiment in self.experiments]
        return self._marked(marks, f"outliers, {threshold:g} deviations off the median of {window} samples")

    @check_arguments
    def unwrap(self, signals: Sequence[str]) -> Self:
        """The dataset with full turns added to angles in rad, mrad, deg or rev, so that no step exceeds half of one."""
        places, units = self.experiments[0].columns(signals), units_of(self.experiments[0].signals)
        if other := next((units[place] for place in places if units[place] not in TURNS), None):
            raise ValueError(f"`Dataset.unwrap(signals=...)` must name angles in {', '.join(TURNS)}; got [{other}].")
        parts = [unwrap_columns(one, places, [TURNS[units[i]] for i in places]) for one in self.experiments]
        note = f"Full turns were added to {', '.join(signals)} at {sum(count for _, count in parts)} jumps."
        return self.with_changes([experiment for experiment, _ in parts], note)

    @check_arguments
    def mark_limits(self, signal: str, low: float = -np.inf, high: float = np.inf) -> Self:
        """The dataset with the samples of a signal marked that lie at or beyond the limits of its sensor."""
        if not low < high:
            raise ValueError(f"`Dataset.mark_limits(low=..., high=...)` must be a range; got {low:g} to {high:g}.")
        marks = []
        for experiment in self.experiments:
            columns = list(experiment.columns([signal]))
            part = np.zeros(experiment.values.shape, dtype=bool)
            numbers = experiment.values[:, columns]
            part[:, columns] = (numbers <= low) | (numbers >= high)
            marks.append(part)
        ends = " or ".join(
            f"{word} {end:g}" for word, end in (("at least", high), ("at most", low)) if np.isfinite(end)
        )
        return self._marked(marks, f"samples of {signal} at its limits, {ends}")

    def _marked(self, marks: Sequence[np.ndarray[tuple[int, ...], np.dtype[np.bool_]]], of: str) -> Self:
        parts = zip(self.experiments, marks, strict=True)
        experiments = [replace(experiment, marks=experiment.marks | part) for experiment, part in parts]
        labels = self.experiments[0].signals.labels
        counts = {label: sum(int(part[:, i].sum()) for part in marks) for i, label in enumerate(labels)}
        words = ", ".join(f"{count} of {label}" for label, count in counts.items() if count) or "none"
        return self.with_changes(experiments, f"Marked as {of}: {words}.")

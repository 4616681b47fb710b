"""The check of the times of one experiment: their number, order, unit, gaps and jitter."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.identification.datasets.data_finding import DataFinding, count_text
from workbench.identification.datasets.experiment import Experiment

LEAST = 10  # samples of any log that is to be fitted
RATE_ERROR = 0.05  # of the stated rate: a clock is better, and a wrong unit or a lost half is worse
SCALES = {"ms": 1e3, "us": 1e6, "ns": 1e9, "min": 1 / 60, "h": 1 / 3600}
NEAR = 0.2  # of such a factor
STEADY = 0.02  # of a period: jitter below it is no remark
LOST = 0.85  # of a period: a longer step has lost a sample, if jitter does not explain it
SPREADS = 3.0  # times the 90 % point of jitter that a step may have beyond its period
WHOLE = 0.1  # of a period: closer to whole periods than that, steps tell lost rows and not jitter


def check_times(experiment: Experiment, rate: float | None) -> Iterator[DataFinding]:
    """The points of the times, each at most once."""
    name, t = experiment.name, experiment.t
    if len(experiment) < LEAST:
        got = "no samples: the log is empty" if not len(experiment) else f"{len(experiment)} samples"
        text = f"'{name}' must have at least {LEAST} samples, and is too short with {got}: record a longer one."
        yield DataFinding("too short", "refused", text)
        if len(experiment) < 3:
            return
    if not np.isfinite(t).all():
        row = int(np.argmax(~np.isfinite(t)))
        text = f"'{name}' must have a time in each row, and row {row} has {t[row]:g} (not a number): leave the row out."
        yield DataFinding("time missing", "refused", text)
        return
    steps = np.diff(t)
    yield from _order(experiment, steps)
    steps = steps[steps > 0]
    if steps.size < 2:
        return
    period = float(np.median(steps))
    if rate is not None:
        yield from _unit(name, period, rate)
    yield from _spread(experiment, steps, period)


def _order(experiment: Experiment, steps: Array) -> Iterator[DataFinding]:
    name, t = experiment.name, experiment.t
    if (backward := np.flatnonzero(steps < 0)).size:
        row = int(backward[0])
        text = (
            f"'{name}' must have times that increase, and its time runs backward in {backward.size} of its steps, "
            f"first from {t[row]:.9g} to {t[row + 1]:.9g} s in row {row + 1}: cut the log there, or read another clock."
        )
        yield DataFinding("time backward", "refused", text)
    if (repeats := np.flatnonzero(steps == 0)).size:
        row = int(repeats[0])
        text = (
            f"'{name}' must have one sample for each time, and {count_text(repeats.size, 'time')} repeated, first "
            f"{t[row]:.9g} s in row {row + 1}: say which sample is meant by `log.merge_repeated('first')`, 'last' "
            "or 'mean'."
        )
        yield DataFinding("time repeated", "refused", text)


def _unit(name: str, period: float, rate: float) -> Iterator[DataFinding]:
    ratio = period * rate
    for unit, factor in SCALES.items():
        if abs(ratio / factor - 1) < NEAR:
            text = (
                f"'{name}' must have times in s at its rate of {rate:g} Hz, and its median period is {period:.6g} s: "
                f"the unit of its times seems to be {unit}, so read it with that unit."
            )
            yield DataFinding("time unit", "refused", text)
            return
    if abs(ratio - 1) > RATE_ERROR:
        text = (
            f"'{name}' should have the period of its rate of {rate:g} Hz, {1 / rate:.6g} s, and its median period is "
            f"{period:.6g} s: say which of the two holds, or whether samples were left out."
        )
        yield DataFinding("time unit", "question", text)


def _jitter(ratios: Array) -> float:
    """The 90 % point of how far steps are from a period, or from whole periods if nearly all are close to these."""
    whole = float(np.quantile(np.abs(ratios - np.maximum(np.rint(ratios), 1.0)), 0.9))
    return whole if whole <= WHOLE else float(np.quantile(np.abs(ratios - 1), 0.9))


def _spread(experiment: Experiment, steps: Array, period: float) -> Iterator[DataFinding]:
    """Gaps, and jitter of the other steps."""
    name = experiment.name
    jitter = _jitter(steps / period)
    limit = (1 + max(LOST, SPREADS * jitter)) * period
    gaps = steps > limit
    if gaps.any():
        all_steps = np.diff(experiment.t)
        row, lost = int(np.argmax(all_steps > limit)), int(np.round(steps[gaps] / period - 1).sum())
        text = (
            f"'{name}' should have a sample each {period:.6g} s, and {count_text(int(gaps.sum()), 'step')} longer than "
            f"{limit:.3g} s, with about {lost} missing samples in all; the first gap is from {experiment.t[row]:.6g} "
            f"to {experiment.t[row + 1]:.6g} s: say what the inputs did in the gap, or cut the log there."
        )
        yield DataFinding("gap", "question", text)
    even = steps[~gaps]
    if float(np.quantile(np.abs(even / period - 1), 0.9)) > STEADY:
        text = (
            f"The periods of '{name}' jitter from {even.min():.4g} to {even.max():.4g} s about {period:.4g} s; a fit "
            "takes the times as they are, and `log.resample(period)` gives even ones for filters."
        )
        yield DataFinding("jitter", "remark", text)

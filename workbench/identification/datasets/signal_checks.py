"""The check of the samples of signals: missing, constant, saturated or stuck ones, and the excitation."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.identification.datasets.data_finding import DataFinding, count_text
from workbench.identification.datasets.experiment import Experiment, Marks

FLAT = 3  # equal samples at an extreme that can be a limit
LONG = 5  # of such samples in a row, where the signal is quantised and so repeats its values anyway
QUANTA = 4.0  # steps of the signal's quantum that it would have gone beyond its limit,
RANGE = 5e-3  # and the share of its range: a quantised signal may rest at an extreme
SLOPE = 5  # samples before and behind a flat part that tell its slope
LIMIT_LEAST = 20  # samples that can tell a limit from chance
SHARE = 0.01  # of all samples at the extreme of a noisy signal that make a limit
STUCK = 10  # equal samples of a signal that else never repeats
NOISY = 0.02  # of steps that are zero in a signal that never repeats
WINDOWS = 4000  # columns of the Hankel matrix
SMALL = 1e-6  # of the largest singular value: the rounding of a text with seven digits


def check_missing(experiment: Experiment, column: int, is_input: bool) -> Iterator[DataFinding]:
    """The samples of a signal that are NaN."""
    label, numbers = experiment.signals.labels[column], experiment.values[:, column]
    if (lost := np.flatnonzero(~np.isfinite(numbers))).size:
        row = int(lost[0])
        what = (
            f"{count_text(lost.size, 'sample')} missing (NaN) of {len(experiment)}, first at {experiment.t[row]:.9g} s"
        )
        if is_input:
            text = f"The input {label} must have a finite number at each time; {what}: `log.resample` fills them."
        else:
            text = f"The output {label} should have a sample at each time; {what}: say why; a fit passes over them."
        yield DataFinding("missing samples", "refused" if is_input else "question", text, label)


def check_constant(experiment: Experiment, column: int, inputs: Sequence[int]) -> Iterator[DataFinding]:
    """A signal that does not change; an input may be constant beside others that change."""
    label, use = experiment.signals.labels[column], experiment.is_weighed[:, column]
    numbers = experiment.values[use, column]
    if len(experiment) and not numbers.size:
        text = f"The signal {label} must have samples in '{experiment.name}', and all are NaN or marked: leave it out."
        yield DataFinding("missing samples", "refused", text, label)
    if numbers.size < 2 or np.ptp(numbers) > 0:
        return
    got = f"it is constant at {numbers[0]:.6g} in all {numbers.size} samples of '{experiment.name}'"
    if column not in inputs:
        text = f"The output {label} must change to tell a parameter, and {got}: look at the sensor and the recorder."
        yield DataFinding("constant signal", "refused", text, label)
        return
    others = [experiment.values[experiment.is_weighed[:, place], place] for place in inputs]
    severity = "remark" if any(part.size and np.ptp(part) > 0 for part in others) else "question"
    text = f"The input {label} should change to excite the system, and {got}: say what moves the system instead."
    yield DataFinding("constant signal", severity, text, label)


def check_saturated(experiment: Experiment, column: int) -> Iterator[DataFinding]:
    """A signal that stays at an extreme as if its sensor ended there, or repeats a value though it has noise."""
    label, use = experiment.signals.labels[column], experiment.is_weighed[:, column]
    numbers = experiment.values[use, column]
    if numbers.size < LIMIT_LEAST or np.ptp(numbers) == 0:
        return
    for side, word, call in ((1.0, "largest", "high"), (-1.0, "smallest", "low")):
        if count := _at_limit(side * numbers):
            limit = side * float((side * numbers).max())
            text = (
                f"The output {label} should lie within the range of its sensor, and {count} of {numbers.size} samples "
                f"of '{experiment.name}' stay at its {word} value {limit:.6g} as if it were clipped (saturated): "
                f"say what happened there, or mark them by `log.mark_limits('{label}', {call}={limit!r})`."
            )
            yield DataFinding("saturated signal", "question", text, label)
            return
    if run := _stuck(numbers):
        row = int(np.flatnonzero(use)[run[0]])
        text = (
            f"The output {label} has noise and should not repeat a value, and {run[1]} samples of '{experiment.name}' "
            f"from {experiment.t[row]:.6g} s on are stuck at {numbers[run[0]]:.6g}: say what happened there."
        )
        yield DataFinding("stuck signal", "question", text, label)


def _runs(is_equal: Marks) -> list[tuple[int, int]]:
    """The first places and the ends of the runs of true values."""
    edges = np.diff(np.concatenate([[0], is_equal.astype(int), [0]]))
    return list(zip(np.flatnonzero(edges == 1).tolist(), np.flatnonzero(edges == -1).tolist(), strict=True))


def _at_limit(numbers: Array) -> int:
    """The number of samples at the maximum if they are there by a limit, else 0.

    By a limit is a flat part that the signal enters and leaves so fast that without the limit it would have gone
    several quanta beyond, or that it enters at several quanta a sample and stays to the end; or an exact maximum that
    recurs in a signal that else never repeats. A flat part at the begin is a system at rest.
    """
    top = numbers == numbers.max()
    runs = [(first, last) for first, last in _runs(top) if first and last < numbers.size]
    between = ~top & (numbers > numbers.min())
    repeats = int(((np.diff(numbers) == 0) & between[1:]).sum())
    never = repeats <= NOISY * numbers.size and np.unique(numbers[between]).size > numbers[between].size / 2
    inside = sum(last - first for first, last in runs)
    if never and max(FLAT, SHARE * numbers.size) <= inside <= numbers.size / 2:
        return int(top.sum())
    steps = np.abs(np.diff(numbers))
    quantum = float(steps[steps > 0].min()) if repeats > NOISY * numbers.size else 0.0
    least = max(QUANTA * quantum, RANGE * float(np.ptp(numbers)))
    for first, last in _runs(top):
        if last - first < LONG or first < SLOPE + 1:
            continue
        rise = (numbers[first - 1] - numbers[first - 1 - SLOPE]) / SLOPE
        fall = (numbers[last] - numbers[last + SLOPE]) / SLOPE if last + SLOPE < numbers.size else rise
        slowest = 0.0 if last + SLOPE < numbers.size else QUANTA * quantum
        # a parabola with these slopes at its ends has its top a quarter of their mean times its length above them
        if min(rise, fall) > slowest and (rise + fall) / 2 * (last - first) / 4 > least:
            return int(top.sum())
    return 0


def _stuck(numbers: Array) -> tuple[int, int] | None:
    """The place and the length of the longest run of equal samples in a signal that else never repeats."""
    equal = np.diff(numbers) == 0
    runs = [(first, last - first + 1) for first, last in _runs(equal) if first]
    longest = max(runs, key=lambda run: run[1], default=(0, 0))
    others = int(equal.sum()) - longest[1] + 1
    return longest if longest[1] >= STUCK and others <= NOISY * numbers.size else None


def excited_directions(experiments: Sequence[Experiment], columns: Sequence[int], order: int) -> int:
    """The rank of the block Hankel matrix of the inputs with `order` block rows, spread over a twentieth of the log.

    Willems, Rapisarda, Markovsky and De Moor, A note on persistency of excitation, Systems & Control Letters 54 (2005)
    325: an input is persistently exciting of order L if its Hankel matrix of L block rows has full row rank.
    """
    blocks = []
    for experiment in experiments:
        u = np.nan_to_num(experiment.values[:, list(columns)])
        stride = max(1, len(u) // (20 * order))
        count = len(u) - stride * (order - 1)
        if count > 0:
            starts = np.unique(np.linspace(0, count - 1, min(count, WINDOWS)).astype(int))
            blocks.append(np.hstack([u[starts + stride * i] for i in range(order)]))
    if not blocks:
        return 0
    table = np.vstack(blocks)
    sizes = np.abs(table).max(axis=0)
    values = np.linalg.svd(table / np.where(sizes > 0, sizes, 1.0), compute_uv=False)
    return int((values > SMALL * max(values[0], 1e-300)).sum()) if values.size and values[0] > 0 else 0


def check_excitation(
    experiments: Sequence[Experiment], columns: Sequence[int], labels: Sequence[str], unknowns: int
) -> Iterator[DataFinding]:
    """Inputs that do not move the system in enough ways for a number of parameters of a linear system."""
    order = max(1, -(-unknowns // len(columns)))
    rank = excited_directions(experiments, columns, order)
    if rank < min(unknowns, order * len(columns)):
        text = (
            f"The input{'s' if len(labels) > 1 else ''} {', '.join(labels)} should excite {unknowns} directions, one "
            f"for each parameter, and the rank of the Hankel matrix is {rank}; a linear system at rest cannot tell "
            "more parameters than that for each output: excite with more frequencies or steps."
        )
        yield DataFinding("excitation", "remark", text)

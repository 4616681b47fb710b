"""The check of the samples of signals: missing, constant, saturated or stuck ones, and the excitation."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from workbench.core import Layout
from workbench.core.validation.refusals import Array, Integers
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
TURNS = {"rad": 2 * np.pi, "mrad": 2000 * np.pi, "deg": 360.0, "\N{DEGREE SIGN}": 360.0, "rev": 1.0}
WRAPPED = 0.25  # of a turn, to which all steps of a wrapped angle keep when its turns are added
FAR = 2.0  # times the range of all others that an outlier lies from both of its neighbours
RARE = 0.01  # of the samples that can be outliers
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


def units_of(signals: Layout) -> tuple[str, ...]:
    """The unit of each number of some signals."""
    return tuple(unit for entry in signals.entries for unit in entry.units)


def wrapped_rows(numbers: Array, unit: str) -> Integers:
    """The rows behind which an angle jumps by a full turn, as one does that its sensor keeps within a turn."""
    turn = TURNS.get(unit, 0.0)
    steps = np.diff(numbers)
    if not turn or not steps.size or np.ptp(numbers) > 1.01 * turn or np.ptp(numbers) < 0.75 * turn:
        return np.zeros(0, dtype=int)
    jumps = np.flatnonzero(np.abs(steps) > turn / 2)
    is_smooth = bool((np.abs(np.diff(np.unwrap(numbers, period=turn))) <= WRAPPED * turn).all())
    return jumps if is_smooth else np.zeros(0, dtype=int)


def check_wrapped(experiment: Experiment, column: int) -> Iterator[DataFinding]:
    """An angle that jumps by a full turn."""
    label, use = experiment.signals.labels[column], np.flatnonzero(experiment.is_weighed[:, column])
    rows = wrapped_rows(experiment.values[use, column], units_of(experiment.signals)[column])
    if rows.size:
        text = (
            f"The output {label} should be continuous, and it jumps by a full turn {rows.size} times in "
            f"'{experiment.name}', first behind {experiment.t[use[rows[0]]]:.6g} s: add the turns by "
            f"`log.unwrap(['{label}'])`, or say why the model jumps, too."
        )
        yield DataFinding("wrapped angle", "question", text, label)


def check_outliers(experiment: Experiment, column: int) -> Iterator[DataFinding]:
    """Single samples that lie farther from both neighbours than all others go."""
    label, use = experiment.signals.labels[column], np.flatnonzero(experiment.is_weighed[:, column])
    numbers = experiment.values[use, column]
    if numbers.size < LIMIT_LEAST:
        return
    before, behind = numbers[1:-1] - numbers[:-2], numbers[1:-1] - numbers[2:]
    heights = np.where(before * behind > 0, np.minimum(np.abs(before), np.abs(behind)), 0.0)
    most = 1 + int(RARE * numbers.size)
    tops = 1 + np.sort(np.argsort(heights)[-most:])
    others = float(np.ptp(np.delete(numbers, tops)))
    tops = tops[heights[tops - 1] > FAR * others] if others > 0 else tops[:0]
    if tops.size:
        text = (
            f"The output {label} should have no outliers, and {count_text(tops.size, 'sample')} farther from both "
            f"neighbours than all others of '{experiment.name}' go, first {numbers[tops[0]]:.6g} at "
            f"{experiment.t[use[tops[0]]]:.6g} s: mark them by `log.mark_outliers()`, or say what they are."
        )
        yield DataFinding("outliers", "question", text, label)


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

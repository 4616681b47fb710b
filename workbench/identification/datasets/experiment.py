"""Experiment: one record of samples over time, with their names, units and marks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from workbench.core import Layout
from workbench.core.layout import layouts_to_html
from workbench.core.recorded_step import SignalRecord
from workbench.core.validation.refusals import Array, Integers, known_name, one_of, refusal
from workbench.core.validation.signatures import check_arguments

if TYPE_CHECKING:
    import pandas as pd

Marks = NDArray[np.bool_]
HOLDS = ("hold", "linear")
UNIFORM = 1e-3  # of a period: the jitter below which samples count as uniform, far above the rounding of a text


@dataclass(frozen=True, eq=False)
class Experiment:
    """One record of N samples: times, signals, and marks of the samples that a fit must not weigh.

    Parameters
    ----------
    name
        The name of the experiment.
    t
        (N,), the times in s, in the order of the log. A log may be read whose times do not increase; `check_data` says
        so, and no fit takes it.
    signals
        Names, shapes and units of the signals.
    values
        (N, size), the samples in the order of `signals`; NaN where a sensor has none.
    marks
        (N, size), true for samples that are kept and get no weight, such as outliers.

    Raises
    ------
    ValueError
        If the shapes do not fit each other.
    """

    name: str
    t: Array
    signals: Layout
    values: Array
    marks: Marks = field(default_factory=lambda: np.zeros((0, 0), dtype=bool))

    def __post_init__(self) -> None:
        for part, kind in (("t", float), ("values", float), ("marks", bool)):
            object.__setattr__(self, part, np.array(getattr(self, part), dtype=kind))
        shape = (self.t.size, self.signals.size)
        if self.t.ndim != 1 or self.values.shape != shape:
            raise ValueError(
                f"`Experiment(values=...)` must have shape {shape}, a row for each time and a column for each of "
                f"{self.signals}; got {self.values.shape} for times {self.t.shape}."
            )
        marks = np.zeros(shape, dtype=bool) if self.marks.size == 0 else self.marks
        if marks.shape != shape:
            raise ValueError(f"`Experiment(marks=...)` must have shape {shape}, as its values; got {marks.shape}.")
        object.__setattr__(self, "marks", marks)

    def __getitem__(self, signal: str) -> Array:
        """The samples of a signal, (N,) or (N, *shape), or of one number of it by its label, such as `q[0]`, (N,)."""
        if signal in self.signals.labels:
            return self.values[:, self.signals.labels.index(signal)]
        known_name(signal, self.signals.names, f"signals of '{self.name}'")
        return self.signals.unpack(self.values)[signal]

    def __len__(self) -> int:
        return self.t.size

    @property
    def is_weighed(self) -> Marks:
        """(N, size), true for samples that are finite and not marked."""
        return np.isfinite(self.values) & ~self.marks

    @property
    def period(self) -> float:
        """The median time between two samples in s; NaN if there are fewer than two."""
        return float(np.median(np.diff(self.t))) if len(self) > 1 else np.nan

    @property
    def is_uniform(self) -> bool:
        """True if all periods are equal to a thousandth of their median."""
        steps = np.diff(self.t)
        return bool(steps.size and np.isfinite(steps).all() and np.ptp(steps) <= UNIFORM * self.period)

    @check_arguments
    def columns(self, signals: Sequence[str]) -> tuple[int, ...]:
        """The columns of signals, or of single numbers by their labels; of all signals if none is named."""
        places: list[int] = []
        for name in signals or self.signals.names:
            if name in self.signals.labels:
                places.append(self.signals.labels.index(name))
            else:
                known_name(name, self.signals.names, f"signals of '{self.name}'")
                part = self.signals.slice(name)
                places.extend(range(part.start, part.stop))
        return tuple(dict.fromkeys(places))

    def __repr__(self) -> str:
        return f"<Experiment '{self.name}': {len(self)} samples of {', '.join(self.signals.names)}>"

    def _repr_html_(self) -> str:
        return layouts_to_html(repr(self)[1:-1], {"signal": self.signals})

    @check_arguments
    def rows(self, first: int, last: int) -> Experiment:
        """The samples from row `first` up to row `last`, which is left out."""
        return self.at_rows(np.arange(len(self))[first:last])

    @check_arguments
    def between(self, begin: float, end: float) -> Experiment:
        """The samples at times from `begin` to `end` in s, both included; the times stay as they are."""
        return self.at_rows(np.flatnonzero((self.t >= begin) & (self.t <= end)))

    @check_arguments
    def at_rows(self, rows: Integers) -> Experiment:
        """The samples of some rows by their numbers, from 0 on.

        Raises
        ------
        ValueError
            If there is no row of a number.
        """
        if rows.ndim != 1 or not ((rows >= 0) & (rows < len(self))).all():
            raise refusal("Experiment.at_rows(rows=...)", f"numbers of rows from 0 to {len(self) - 1}", rows)
        return replace(self, t=self.t[rows], values=self.values[rows], marks=self.marks[rows])

    @check_arguments
    def record(self, labels: Sequence[str], hold: Mapping[str, str] | None = None) -> SignalRecord:
        """The measured numbers of some labels as a `SignalRecord`, which drives a loop by `recorded_step`.

        Parameters
        ----------
        labels
            Names of signals, or labels such as `u[0]`: they are the parameters of the loop that the samples replace.
        hold
            For a label or a signal "hold", as a computer holds its command until the next sample, or "linear". The
            default is "hold".

        Raises
        ------
        LookupError
            If there is no such signal.
        ValueError
            If the times do not increase, there are fewer than two samples, or a sample is missing.
        """
        places = self.columns(labels)
        names = tuple(self.signals.labels[i] for i in places)
        rules: dict[str, str] = {}
        for label, rule in (hold or {}).items():
            one_of(f"Experiment.record(hold={{{label!r}: ...}})", rule, HOLDS)
            rules |= {self.signals.labels[i]: rule for i in self.columns([label])}
        steps = np.diff(self.t)
        if not steps.size or not (steps > 0).all():
            row = int(np.argmax(~(steps > 0))) + 1
            got = f"row {row} has {self.t[row]:.9g} s after {self.t[row - 1]:.9g} s" if steps.size else "it has fewer"
            raise ValueError(
                f"`Experiment.record(...)` must have at least two times that increase; in '{self.name}' {got}: "
                "`check_data` says what to do."
            )
        numbers = self.values[:, places]
        if not np.isfinite(numbers).all():
            row, column = map(int, np.argwhere(~np.isfinite(numbers))[0])
            raise ValueError(
                f"`Experiment.record(...)` must have a finite number of an input at each time; '{names[column]}' of "
                f"'{self.name}' has {numbers[row, column]:g} at {self.t[row]:.9g} s, in row {row}: fill it by "
                "`Dataset.resample`, or leave the time out."
            )
        is_linear = np.array([rules.get(name, "hold") == "linear" for name in names])
        return SignalRecord(self.t, names, numbers[:-1], np.where(is_linear, numbers[1:], numbers[:-1]))

    def to_frame(self) -> pd.DataFrame:
        """A table with a column for each number of the signals, `v [V]` or `q[0] [rad]`, indexed by the time in s."""
        import pandas as pd

        units = [unit for entry in self.signals.entries for unit in entry.units]
        heads = [f"{label} [{unit}]" if unit else label for label, unit in zip(self.signals.labels, units, strict=True)]
        return pd.DataFrame(self.values, index=pd.Index(self.t, name="t [s]"), columns=heads)

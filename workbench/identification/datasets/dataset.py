"""Dataset: measured or simulated signals over time, in one or several experiments, with names and units."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from workbench.core import Entry, Layout
from workbench.core.validation.refusals import Array, describe, finite, known_name
from workbench.core.validation.signatures import check_arguments

if TYPE_CHECKING:
    import pandas as pd

Marks = NDArray[np.bool_]


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
        """The samples of a signal, (N,) or (N, *shape)."""
        known_name(signal, self.signals.names, f"signals of '{self.name}'")
        return self.signals.unpack(self.values)[signal]

    def __len__(self) -> int:
        return self.t.size

    @property
    def is_weighed(self) -> Marks:
        """(N, size), true for samples that are finite and not marked."""
        return np.isfinite(self.values) & ~self.marks

    @check_arguments
    def rows(self, first: int, last: int) -> Experiment:
        """The samples from row `first` up to row `last`, which is left out."""
        part = slice(first, last)
        return replace(self, t=self.t[part], values=self.values[part], marks=self.marks[part])

    @check_arguments
    def between(self, begin: float, end: float) -> Experiment:
        """The samples at times from `begin` to `end` in s, both included; the times stay as they are."""
        inside = (self.t >= begin) & (self.t <= end)
        return replace(self, t=self.t[inside], values=self.values[inside], marks=self.marks[inside])

    def to_frame(self) -> pd.DataFrame:
        """A table with a column for each number of the signals, `v [V]` or `q[0] [rad]`, indexed by the time in s."""
        import pandas as pd

        units = [unit for entry in self.signals.entries for unit in entry.units]
        heads = [f"{label} [{unit}]" if unit else label for label, unit in zip(self.signals.labels, units, strict=True)]
        return pd.DataFrame(self.values, index=pd.Index(self.t, name="t [s]"), columns=heads)


@dataclass(frozen=True, eq=False)
@check_arguments
class Dataset:
    """Signals over time in one or several experiments, which all have the same names and units.

    `Dataset.of` makes one from arrays, and `Dataset.from_csv` and the like from a file. Nothing is dropped in silence:
    what was done to the samples since they were recorded stands in `notes`.

    Parameters
    ----------
    experiments
        The experiments, at least one, with different names.
    source
        Where the samples come from, for reports: a file, or the loop that was simulated.
    notes
        Sentences on what was done to the samples.

    Raises
    ------
    ValueError
        If there is no experiment, two have one name, or their signals differ in name, shape or unit.

    Examples
    --------
    >>> t = np.linspace(0.0, 1.0, 5)
    >>> log = wb.Dataset.of(t, {"v": np.sin(t), "omega": np.cos(t)}, units={"v": "V", "omega": "rad/s"})
    >>> log
    <Dataset of v [V], omega [rad/s]: 1 experiment, 5 samples, 1 s>
    >>> log["omega"][0]
    1.0
    """

    experiments: tuple[Experiment, ...]
    source: str = ""
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not self.experiments:
            raise ValueError("`Dataset(experiments=...)` must have at least one experiment; got none.")
        names = [experiment.name for experiment in self.experiments]
        if len(set(names)) < len(names):
            raise ValueError(f"`Dataset(experiments=...)` must have different names; got {describe(names)}.")
        first = _ports(self.experiments[0].signals)
        for other in self.experiments[1:]:
            if _ports(other.signals) != first:
                raise ValueError(
                    f"`Dataset(experiments=...)` must have the same signals in each experiment; "
                    f"'{self.experiments[0].name}' has {self.experiments[0].signals} and '{other.name}' has "
                    f"{other.signals}."
                )

    @staticmethod
    @check_arguments
    def of(
        t: Array,
        signals: Mapping[str, Array],
        units: Mapping[str, str] | None = None,
        *,
        name: str = "log",
        source: str = "",
    ) -> Dataset:
        """A dataset of one experiment from arrays: times t (N,) in s and signals (N,) or (N, n) by name.

        A signal without a unit has the unit '?', which fits any other, and `check_data` says so.

        Raises
        ------
        ValueError
            If there is no signal, a signal does not have N rows, or a unit is no unit.
        LookupError
            If a unit is for a signal that does not exist.
        """
        if not signals:
            raise ValueError("`Dataset.of(signals=...)` must have at least one signal; got none.")
        for unit in units or {}:
            known_name(unit, signals, "signals of this dataset")
        columns = {}
        for signal, samples in signals.items():
            if samples.ndim not in (1, 2) or len(samples) != t.size:
                raise ValueError(
                    f"`Dataset.of(signals=...)` must have {t.size} rows for each signal, as there are times; "
                    f"'{signal}' has shape {samples.shape}."
                )
            columns[signal] = samples.reshape(t.size, -1)
        entries = tuple(
            Entry(signal, np.zeros(samples.shape[1:]), (units or {}).get(signal, "?"))
            for signal, samples in signals.items()
        )
        experiment = Experiment(name, t, Layout(entries), np.hstack(list(columns.values())))
        return Dataset((experiment,), source)

    @property
    def signals(self) -> Layout:
        """Names, shapes and units of the signals."""
        return self.experiments[0].signals

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the experiments."""
        return tuple(experiment.name for experiment in self.experiments)

    def __getitem__(self, name: str) -> Array:
        """The samples of a signal of the only experiment; of several, `log.experiment(name)[signal]` has them."""
        if len(self.experiments) > 1:
            raise LookupError(
                f"`dataset[{describe(name)}]` needs a dataset of one experiment; this one has {len(self.experiments)}: "
                f"write `dataset.experiment(name)[{describe(name)}]`."
            )
        return self.experiments[0][name]

    def __iter__(self) -> Iterator[Experiment]:
        return iter(self.experiments)

    @check_arguments
    def experiment(self, name: str) -> Experiment:
        """The experiment of a name."""
        known_name(name, self.names, "experiments of this dataset")
        return self.experiments[self.names.index(name)]

    @check_arguments
    def of_experiments(self, names: Sequence[str]) -> Dataset:
        """The dataset of some of the experiments."""
        return replace(self, experiments=tuple(self.experiment(name) for name in names))

    @check_arguments
    def with_experiments(self, other: Dataset) -> Dataset:
        """The experiments of both datasets, whose signals must be the same."""
        sources = tuple(dict.fromkeys(filter(None, (self.source, other.source))))
        notes = tuple(dict.fromkeys((*self.notes, *other.notes)))
        return Dataset(self.experiments + other.experiments, ", ".join(sources), notes)

    @check_arguments
    def split(self, share: float) -> tuple[Dataset, Dataset]:
        """The first part of each experiment for a fit, and the last `share` of its samples, from 0 to 1, as a hold-out.

        Raises
        ------
        ValueError
            If the share is not between 0 and 1, or leaves a part without two samples.
        """
        share = finite("Dataset.split(share=...)", share)
        if not 0 < share < 1:
            raise ValueError(f"`Dataset.split(share=...)` must lie between 0 and 1; got {share:g}.")
        parts: tuple[list[Experiment], list[Experiment]] = ([], [])
        for experiment in self.experiments:
            middle = round((1 - share) * len(experiment))
            if min(middle, len(experiment) - middle) < 2:
                raise ValueError(
                    f"`Dataset.split(share=...)` must leave at least two samples in each part; '{experiment.name}' has "
                    f"{len(experiment)} samples, and the share {share:g} leaves {len(experiment) - middle} of them."
                )
            parts[0].append(experiment.rows(0, middle))
            parts[1].append(experiment.rows(middle, len(experiment)))
        first, last = (replace(self, experiments=tuple(part)) for part in parts)
        return first, last

    def to_frame(self) -> pd.DataFrame:
        """A table of all samples, indexed by the time in s, or by experiment and time where there are several."""
        import pandas as pd

        frames = {experiment.name: experiment.to_frame() for experiment in self.experiments}
        return pd.concat(frames, names=["experiment"]) if len(frames) > 1 else frames[self.names[0]]

    def __repr__(self) -> str:
        units = [f"{entry.name} [{entry.unit}]" if entry.unit else entry.name for entry in self.signals.entries]
        samples = sum(map(len, self.experiments))
        span = sum(float(np.ptp(experiment.t)) for experiment in self.experiments if len(experiment))
        count = f"{len(self.experiments)} experiment{'' if len(self.experiments) == 1 else 's'}"
        return f"<Dataset of {', '.join(units)}: {count}, {samples} samples, {span:.6g} s>"


def _ports(layout: Layout) -> list[tuple[str, tuple[int, ...], str]]:
    """What two layouts must have in common: name, shape and unit of each entry."""
    return [(entry.name, entry.shape, entry.unit) for entry in layout.entries]

"""The columns of a log as a reader has them, with names, units and times in s; and the experiment that they make."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.core import Entry, Layout
from workbench.core.csv_file import TIMES, name_and_unit, time_names
from workbench.core.units import BASE, DERIVED_UNITS, UnitError, checked_unit, join_units, read
from workbench.core.validation.refusals import Array, describe, known_name, seconds
from workbench.identification.datasets.experiment import Experiment
from workbench.identification.datasets.unit_scales import WORDS

MOST_NUMBERS = 2**27  # of one log in memory, 1 GiB
PER_SECOND = {"s": 1.0, "ms": 1e3, "us": 1e6, "\N{MICRO SIGN}s": 1e6, "\N{GREEK SMALL LETTER MU}s": 1e6, "ns": 1e9}
SECONDS = {"min": 60.0, "h": 3600.0}
TIME_WORDS = {  # that logs use for these units
    **dict.fromkeys(("sec", "secs", "second", "seconds"), "s"),
    **dict.fromkeys(("msec", "msecs", "millis", "millisecond", "milliseconds"), "ms"),
    **dict.fromkeys(("usec", "usecs", "micros", "microsecond", "microseconds"), "us"),
    **dict.fromkeys(("nsec", "nsecs", "nanos", "nanosecond", "nanoseconds"), "ns"),
    **dict.fromkeys(("mins", "minute", "minutes"), "min"),
    **dict.fromkeys(("hr", "hrs", "hour", "hours"), "h"),
}
KNOWN = {*BASE, *DERIVED_UNITS, *WORDS, *PER_SECOND, *SECONDS, *TIME_WORDS}
LONGEST_NAME = 60  # characters of a name in a message
ROUND = re.compile(r"(.*\S)\s+\(([^()]+)\)", re.S)  # a name, and its unit in round brackets
INDEX = re.compile(r"(.*)\[(\d+)\]", re.S)


@dataclass(frozen=True)
class LogChoice:
    """The signals that a user asks a reader for, with their new names, their units and the source of their times."""

    call: str  # for messages
    source: str
    signals: tuple[str, ...] = ()
    names: Mapping[str, str] | None = None
    units: Mapping[str, str] | None = None
    time: str | float | None = None

    def refuse_size(self, rows: float, columns: int, advice: str) -> None:
        """Refuse a log whose numbers would need too much memory."""
        if rows * columns > MOST_NUMBERS:
            raise ValueError(
                f"`{self.call}` must have at most {MOST_NUMBERS / 1e6:.0f} million numbers, {MOST_NUMBERS >> 27} GiB; "
                f"{self.source} has about {rows * columns / 1e6:.0f} million, {columns} columns of {rows:.3g} rows: "
                f"{advice}."
            )

    def pick(self, heads: Sequence[str], never: Iterable[str] = ()) -> dict[str, tuple[str, str]]:
        """For each column that is wanted, by its head, its new name and its unit ('?' if neither side has one).

        A column goes by its head, by the name in its head, or by its new name; `q` stands for all of q[0], q[1], ...
        """
        own = {head: head_parts(head) for head in heads if head and head not in never}
        new = {head: name for head, (name, _) in own.items()}
        for old, name in (self.names or {}).items():
            new |= dict.fromkeys(_columns_called(self, old, own, new), name)
        units = {head: unit or "?" for head, (_, unit) in own.items()}
        for label, unit in (self.units or {}).items():
            if label == self.time or label in TIMES or label in never:
                continue
            for head in _columns_called(self, label, own, new):
                units[head] = self._agreed_unit(head, own[head][1], unit)
        wanted = list(own)
        if self.signals:
            wanted = [head for label in self.signals for head in _columns_called(self, label, own, new)]
        twice = {new[head] for head in wanted if [new[other] for other in wanted].count(new[head]) > 1}
        if twice:
            raise ValueError(
                f"`{self.call}` must have different names of signals; {self.source} has several columns "
                f"'{min(twice)}': rename them by `names`, or choose by `signals`."
            )
        return {head: (new[head], checked_unit(f"{head}", units[head])) for head in wanted}

    def _agreed_unit(self, head: str, own: str, unit: str) -> str:
        if own and read(checked_unit(head, own)) != read(checked_unit(f"{self.call}: units", unit)):
            raise ValueError(
                f"`{self.call}` must have the units of the file, in which nothing is converted; '{head}' is in "
                f"[{own}], and `units` says '{unit}': leave it out, and write `log.convert(...)`."
            )
        return unit

    def time_head(self, heads: Sequence[str], advice: str = "") -> str | None:
        """The head of the column of time, or None if `time` is a period; `advice` ends the refusal of another table."""
        if self.time is not None and not isinstance(self.time, str):
            return None
        own = {head: head_parts(head)[0] for head in heads if head}
        if self.time is not None:
            known_name(self.time, [*own.values(), *own], f"columns of {self.source}")
            return next(head for head in own if self.time in (head, own[head]))
        names = time_names(own.values())
        times = [head for head, name in own.items() if name in names]
        if len(times) == 1:
            return times[0]
        listed = ", ".join(describe(name, LONGEST_NAME) for name in list(own.values())[:12])
        raise ValueError(
            f"`{self.call}` must have one column of time called 't' or 'time'; {self.source} has {listed}: name it "
            f"by `time`, or give the period in s there{advice}."
        )

    def seconds(self, head: str | None, numbers: Array | None, rows: int) -> tuple[Array, tuple[str, ...]]:
        """The times (rows,) in s from a column with its unit, or from a period, and a note if they were converted."""
        if head is None or numbers is None:
            assert isinstance(self.time, float)  # `time_head` has None for a period alone
            period = seconds(f"{self.call}: time", self.time)
            return np.asarray(np.arange(rows) * period, dtype=np.float64), (
                f"The times are those of a period of {period:g} s.",
            )
        name, unit = head_parts(head)
        unit = unit or (self.units or {}).get(name) or (self.units or {}).get(head) or ""
        unit = TIME_WORDS.get(unit.lower(), unit)
        if unit == "s":
            return numbers, ()
        if not unit or unit == "?":
            return numbers, (f"The times '{name}' have no unit in {self.source} and were read in s.",)
        if unit not in PER_SECOND and unit not in SECONDS:
            raise ValueError(
                f"`{self.call}` must have times in one of {', '.join((*PER_SECOND, *SECONDS))}; '{name}' of "
                f"{self.source} is in [{unit}]: change the head of the column."
            )
        values = numbers / PER_SECOND[unit] if unit in PER_SECOND else numbers * SECONDS[unit]
        return values, (f"The times '{name}' were converted from {unit} to s.",)


def head_parts(head: str) -> tuple[str, str]:
    """The name and the unit in a head; a unit may stand in round brackets behind a space, too, if its words are known.

    So is `Speed (rad/s)` a speed in rad/s, and `Speed (raw)` is a name.
    """
    name, unit = name_and_unit(head)
    bracket = None if unit else ROUND.fullmatch(name)
    if bracket is None:
        return name, unit
    try:
        words = {word for word, _ in read(bracket[2]).powers}
    except UnitError:
        return name, unit
    return (bracket[1], bracket[2].strip()) if words and words <= KNOWN else (name, unit)


def _columns_called(
    choice: LogChoice, label: str, own: Mapping[str, tuple[str, str]], new: Mapping[str, str]
) -> list[str]:
    """The heads of the columns that a label names."""
    exact = [head for head in own if label in (head, own[head][0], new[head])]
    several = [head for head in own if (m := INDEX.fullmatch(own[head][0])) and label == m[1]]
    if not exact and not several:
        known_name(label, [name for name, _ in own.values()], f"columns of {choice.source}")
    return exact or several


@dataclass(frozen=True, eq=False)
class LogColumns:
    """Columns (N,) by name with their units, at times (N,) in s, and sentences on what the reader did."""

    source: str
    t: Array
    columns: Mapping[str, Array]
    units: Mapping[str, str]
    notes: tuple[str, ...] = ()

    def experiment(self, call: str, name: str) -> Experiment:
        """The experiment of the columns, in which `q[0]`, `q[1]`, ... are one signal q."""
        if not self.columns:
            raise ValueError(f"`{call}` must have at least one column besides the time; {self.source} has none.")
        groups: dict[str, list[str]] = {}
        for label in self.columns:
            index = INDEX.fullmatch(label)
            groups.setdefault(index[1] if index and index[1] else label, []).append(label)
        entries, order = [], []
        for signal, labels in groups.items():
            several = sorted(labels, key=_number_in)
            if several == [f"{signal}[{i}]" for i in range(len(several))]:
                unit = join_units([self.units[label] for label in several])
                entries.append(Entry(signal, np.zeros(len(several)), unit))
                order += several
            else:
                entries += [Entry(label, np.zeros(()), self.units[label]) for label in labels]
                order += labels
        values = np.column_stack([self.columns[label] for label in order]).astype(float)
        return Experiment(name, np.asarray(self.t, dtype=float), Layout(tuple(entries)), values)

    def with_notes(self, *notes: str) -> LogColumns:
        """The same columns with further notes."""
        return replace(self, notes=(*self.notes, *notes))


def _number_in(label: str) -> int:
    index = INDEX.fullmatch(label)
    return int(index[2]) if index else -1


def unite_clocks(
    choice: LogChoice,
    groups: Sequence[tuple[Array, Mapping[str, Array]]],
    units: Mapping[str, str],
    notes: Sequence[str],
) -> LogColumns:
    """Columns of several clocks at the union of their times, NaN where a column has no sample at a time."""
    if len(groups) == 1:
        return LogColumns(choice.source, groups[0][0], groups[0][1], units, tuple(notes))
    t = np.unique(np.concatenate([times for times, _ in groups])) if groups else np.zeros(0)
    choice.refuse_size(t.size, sum(len(columns) for _, columns in groups), "choose fewer by `signals`")
    columns, more = {}, []
    for times, parts in groups:
        if (repeats := times.size - np.unique(times).size) > 0:
            more.append(
                f"{repeats} samples of {describe(next(iter(parts)))} and its neighbours have the time of another one, "
                "and the last was taken."
            )
        places = np.searchsorted(t, times)
        for label, numbers in parts.items():
            columns[label] = np.full(t.size, np.nan)
            columns[label][places] = numbers
    more.append(f"{len(groups)} clocks were united: a signal is NaN at the times of the others.")
    return LogColumns(choice.source, t, columns, units, (*notes, *more))

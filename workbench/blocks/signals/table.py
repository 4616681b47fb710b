"""Signals by their numbers: a table over time, from arrays or from a CSV file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from workbench.blocks.signals.piecewise import MOST_PIECES, piecewise_motion
from workbench.blocks.signals.profiles import refuse_times
from workbench.blocks.signals.signal import AbstractSignal, Motion
from workbench.core import block, option
from workbench.core.block import Number
from workbench.core.csv_file import CsvFile
from workbench.core.validation.refusals import Array, Integers, finite, matrix, one_of, whole

MOST_ROWS = MOST_PIECES


@block
class Table(AbstractSignal):
    """A signal given by a table of times and values, and interpolated between them.

    A run must end at the last time or before. The numbers of the table are constants of the equations, and no
    parameters that a study could vary.

    Parameters
    ----------
    times
        The m times of the rows in s, in increasing order. The first is 0 or negative.
    values
        The values at these times, of shape (m, n); for a signal of one number also (m,).
    interpolation
        The rule between two rows.

    Raises
    ------
    ValueError
        If a number is not finite; the times do not increase, or begin after 0; there are fewer than two rows or more
        than 2000; or the numbers of times and of rows of values differ.

    Examples
    --------
    >>> wb.Table("h", "m", times=[0.0, 1.0, 2.0], values=[0.1, 0.2, 0.2]).at(0.5).h
    SX(0.15)
    >>> np.savetxt("log.csv", [[0.0, 0.1], [1.0, 0.2]], delimiter=",", header="t [s],h [m]", comments="")
    >>> wb.Table.from_csv("log.csv", "h").at(0.5).h
    SX(0.15)
    """

    signal: str
    unit: str
    times: Array
    values: Array
    interpolation: str = option(
        {
            "linear": "straight lines between the rows; the second derivative is taken to be zero",
            "cubic": "a cubic spline with two continuous derivatives and not-a-knot ends",
            "hold": "the value of a row until the next row, as a computer holds its command",
        },
        default="linear",
    )

    def __post_init__(self) -> None:
        times, values = np.array(self.times), np.array(self.values)
        if times.ndim != 1 or values.ndim not in (1, 2) or len(values) != len(times):
            raise ValueError(
                f"`Table(times=..., values=...)` must have one row of values for each time, (m,) and (m, n); got "
                f"shapes {times.shape} and {values.shape}."
            )
        refuse_times("Table(times=...)", times)
        if times[0] > 0 or len(times) > MOST_ROWS:
            raise ValueError(
                f"`Table(times=...)` must begin at 0 s or before, as every run does, and have at most {MOST_ROWS} "
                f"rows, each of which costs at every step; got {len(times)} from {times[0]:g} s on."
            )
        matrix("Table(values=...)", values.reshape(len(times), -1))
        for name, numbers in (("times", times), ("values", values.reshape(len(times), -1))):
            numbers.flags.writeable = False
            object.__setattr__(self, name, numbers)

    @staticmethod
    def from_csv(
        path: str | Path,
        signal: str,
        unit: str | None = None,
        *,
        columns: tuple[str, ...] = (),
        time: str | float | None = None,
        begin: float = 0.0,
        end: float = np.inf,
        every: int = 1,
        duplicates: str = "refuse",
        interpolation: str = "linear",
    ) -> Table:
        """A table from a CSV file, plain or gzipped, whose first line has names and units: `t [s],omega [rad/s]`.

        It reads the files that `to_frame().to_csv(...)` writes, and others. Tabs, semicolons or commas separate the
        cells: the first of these that the first line contains. Lines that begin with # are skipped.

        Parameters
        ----------
        path, signal, unit
            The file, the name of the signal, and its unit, which is needed only if the first line has none.
        columns
            Names of the columns, one for each component. The default is `q`, or `q[0]`, `q[1]`, ..., for a signal q.
        time
            Column of the time in s; the default is `t` or `time`. Or the period between two lines in s, from 0 s on.
        begin, end
            Times of the file in s. A run starts at `begin`, which becomes t = 0. The lines used are those from the last
            one at or before `begin` to the first one at or after `end`.
        every
            A whole number n: every n-th line from `begin` to `end` is used, and the last one.
        duplicates
            Of several lines with the same time, the "first" or "last" is used; "refuse" raises an error.

        Raises
        ------
        LookupError
            If there is no such file, or no such column.
        ValueError
            If the file is no CSV with a first line of names; a cell of a used column is no number; the times do not
            increase; the unit is missing, or not that of the file; or `Table` refuses the numbers.
        """
        file = CsvFile.read("Table.from_csv(path=...)", path)
        names = columns or file.columns_of(signal)
        times, values = file.times(time), np.column_stack([file.numbers(name) for name in names])
        rows = file.rising_lines(
            times, one_of("Table.from_csv(duplicates=...)", duplicates, ("refuse", "first", "last"))
        )
        rows = rows[_window(file.name, times[rows], begin, end, every)]
        return Table(signal, file.unit(names, unit), times[rows] - begin, values[rows], interpolation)

    @property
    def dof(self) -> int:
        return int(self.values.shape[1])

    @property
    def ends(self) -> float:
        """The time of the last row, in s."""
        return float(self.times[-1])

    def motion(self, t: Number) -> Motion:
        return piecewise_motion(t, self._pieces())

    def _pieces(self) -> Array:
        """For each piece its begin and the coefficients of 1, s, s^2 and s^3: (m - 1, 1 + 4 n)."""
        begins, zero = self.values[:-1], np.zeros_like(self.values[:-1])
        slopes = np.diff(self.values, axis=0) / np.diff(self.times)[:, np.newaxis]
        coefficients: tuple[Array, ...] = (begins, slopes, zero, zero)
        if self.interpolation == "hold":
            coefficients = (begins, zero, zero, zero)
        elif self.interpolation == "cubic":
            from scipy.interpolate import CubicSpline  # half a second, which only splines pay

            coefficients = tuple(CubicSpline(self.times, self.values).c[::-1])
        return np.hstack([self.times[:-1, np.newaxis], *coefficients])


def _window(file: str, times: Array, begin: float, end: float, every: int) -> Integers:
    """The numbers of the lines from the last one at `begin` or before to the first one at `end` or behind."""
    start = finite("Table.from_csv(begin=...)", begin)
    if not end > start:
        raise ValueError(f"`Table.from_csv(end=...)` must lie behind `begin`, {start:.9g} s; got {end:.9g} s.")
    if not times[0] <= start < times[-1]:
        raise ValueError(
            f"`Table.from_csv(begin=...)` must be a time that the file has, with a line before or at it and one behind "
            f"it; {file} has {times[0]:.9g} to {times[-1]:.9g} s, and a run would start at {start:.9g} s."
        )
    first, last = int(np.searchsorted(times, start, side="right")) - 1, int(np.searchsorted(times, end))
    last = min(len(times) - 1, last)
    step = whole("Table.from_csv(every=...)", every)
    return np.unique(np.append(np.arange(first, last + 1, step), last))

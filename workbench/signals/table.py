"""Signals that are given by numbers: a table over time, from an array or a file."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from pathlib import Path

import casadi as ca
import numpy as np
from scipy.interpolate import CubicSpline

from workbench.core import block, option
from workbench.core.block import Number
from workbench.signals.profiles import refuse_times
from workbench.signals.signal import AbstractSignal, Motion, clock
from workbench.validation.refusals import Array, known, refusal

MOST_ROWS = 2000  # each is a comparison at each evaluation, and a part of what is compiled


@block
class Table(AbstractSignal):
    """A signal between the rows of a table, as an expression in time: polynomials piece by piece.

    A run that goes on behind its last row is refused. The numbers of a table are no parameters.

    Parameters
    ----------
    times
        (m,), in s, increasing, from 0 or before.
    values
        (m, n), a row a time; of a signal of one number (m,).

    Raises
    ------
    ValueError
        If a number is not finite, the times do not increase or begin after 0, there are fewer than two rows or more
        than 2000, or times and values are not equally many.

    Examples
    --------
    >>> wb.Table("h", "m", times=[0.0, 1.0, 2.0], values=[0.1, 0.2, 0.2]).at(0.5).h
    SX(0.15)
    """

    signal: str
    unit: str
    times: Array
    values: Array
    interpolation: str = option(
        {
            "linear": "straight lines, whose corners have no second derivative",
            "cubic": "a cubic spline with two continuous derivatives, whose outer two pieces are one at each end",
            "hold": "each row until the next, as a computer's command is held",
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
        for name, numbers in (("times", times), ("values", values)):
            if len(odd := np.argwhere(~np.isfinite(numbers))):
                raise ValueError(
                    f"`Table({name}=...)` must be finite numbers, as no value can be guessed; got "
                    f"{numbers[tuple(odd[0])]:g} at {odd[0].tolist()}: leave the row out."
                )
        refuse_times("Table(times=...)", times)
        if times[0] > 0:
            raise ValueError(
                f"`Table(times=...)` must begin at 0 s or before, as every run does; got {times[0]:g} s: subtract it, "
                "or add a row."
            )
        if len(times) > MOST_ROWS:
            raise ValueError(
                f"`Table(times=...)` must be at most {MOST_ROWS} rows, each of which costs at every step; got "
                f"{len(times)}: thin it out."
            )
        for name, numbers in (("times", times), ("values", values.reshape(len(times), -1))):
            numbers.flags.writeable = False
            object.__setattr__(self, name, numbers)

    @staticmethod
    def of_csv(
        path: str | Path, signal: str, unit: str, columns: Sequence[str] = (), interpolation: str = "linear"
    ) -> Table:
        """A table from a CSV file, whose first column is the time in s.

        Parameters
        ----------
        columns
            The names of the columns of the signal's numbers, as the file's first line has them; without any, all
            columns behind the first.

        Raises
        ------
        ValueError
            If the file cannot be read, a cell is no number, or `Table` refuses the numbers.
        LookupError
            If the file has no column of a name.
        """
        call = "Table.of_csv(path=...)"
        try:
            with Path(path).open(newline="", encoding="utf-8-sig") as file:
                lines = [(number, line) for number, line in enumerate(csv.reader(file), 1) if any(map(str.strip, line))]
        except (OSError, UnicodeDecodeError, csv.Error) as error:
            raise refusal(call, "a CSV file that can be read", str(path), f": {error}") from None
        head = [cell.strip() for cell in lines[0][1]] if lines and not all(map(_is_number, lines[0][1])) else []
        if columns and not head:
            raise ValueError(f"`Table.of_csv(columns=...)` needs a first line with names; '{path}' has numbers there.")
        places = [head.index(known(name, head, f"columns of '{path}'")) for name in columns]
        rows = list(_rows(call, lines[bool(head) :], places))
        if len(rows) < 2:
            raise ValueError(f"`{call}` must be a file of at least two rows of numbers; '{path}' has {len(rows)}.")
        numbers = np.array(rows)
        return Table(signal, unit, numbers[:, 0], numbers[:, 1:], interpolation)

    @property
    def dof(self) -> int:
        """How many numbers it has, n."""
        return int(self.values.shape[1])

    @property
    def ends(self) -> float:
        """The time of its last row, in s."""
        return float(self.times[-1])

    def motion(self, t: Number) -> Motion:
        """The polynomial of the row that t lies behind, and its derivatives."""
        rows = self._pieces()
        chosen = ca.SX(rows[0])
        for row, time in zip(rows[1:], self.times[1:-1], strict=True):
            chosen = ca.if_else(clock(t) >= time, ca.SX(row), chosen)
        s = t - chosen[0]
        a, b, c, d = ca.vertsplit(chosen[1:], self.dof)
        return a + s * (b + s * (c + s * d)), b + s * (2 * c + s * 3 * d), 2 * c + 6 * d * s

    def _pieces(self) -> Array:
        """For each piece its begin and the coefficients of 1, s, s^2 and s^3: (m - 1, 1 + 4 n)."""
        begins, zero = self.values[:-1], np.zeros_like(self.values[:-1])
        slopes = np.diff(self.values, axis=0) / np.diff(self.times)[:, np.newaxis]
        coefficients: tuple[Array, ...] = (begins, slopes, zero, zero)
        if self.interpolation == "hold":
            coefficients = (begins, zero, zero, zero)
        elif self.interpolation == "cubic":
            coefficients = tuple(CubicSpline(self.times, self.values).c[::-1])
        return np.hstack([self.times[:-1, np.newaxis], *coefficients])


def _rows(call: str, lines: Sequence[tuple[int, list[str]]], places: list[int]) -> Iterator[list[float]]:
    """The numbers of each line: of the first column, and of those places or all others."""
    width = len(lines[0][1]) if lines else 0
    for number, line in lines:
        if len(line) != width:
            raise ValueError(f"`{call}` must have {width} cells in each line; line {number} has {len(line)}.")
        cells = [line[place] for place in (0, *(places or range(1, width)))]
        for cell in cells:
            if not _is_number(cell):
                raise ValueError(f"`{call}` must have a number in each cell; line {number} has {cell[:60]!r}.")
        yield list(map(float, cells))


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True

"""Cells: how a horizon is divided into parts, and parts into steps, before a method and a step are chosen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.validation.refusals import multiple, positive, seconds

COUNT = 100  # cells of a horizon, or about that many
LADDER = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000)
REFERENCES = (200, 1000, 4000)  # steps a cell of RK4, from which errors are told; the next where one is too coarse


@dataclass(frozen=True)
class Cells:
    """Cells of one length in s, and the numbers of steps into which one may be divided.

    Attributes
    ----------
    divisors, references
        Steps a cell, of candidates and of the runs that judge them.
    """

    length: float
    count: int
    divisors: tuple[int, ...]
    references: tuple[int, ...]


def cells_of(until: float, tolerance: float, cell: float | None, grid: float | None) -> Cells:
    """The cells of a horizon [s], each a multiple of the grid [s], for `choose`, whose numbers are checked.

    Raises
    ------
    ValueError
        If a number is not positive and finite, or the horizon no multiple of cell or grid.
    """
    until = seconds("choose(until=...)", until)
    positive("choose(tolerance=...)", tolerance)
    if grid is not None:
        grid = seconds("choose(grid=...)", grid)
    if cell is None:
        count = COUNT if grid is None else _divisor(multiple("choose(until=...)", until, grid, "the grid"))
    else:
        count = multiple("choose(until=...)", until, seconds("choose(cell=...)", cell), "the cell")
    length = until / count
    least = 1 if grid is None else multiple("choose(cell=...)", length, grid, "the grid")
    divisors = [least * n for n in LADDER if n <= 20 or least * n <= LADDER[-1]]
    references = sorted({least * max(2, -(-n // least)) for n in REFERENCES} | {2 * divisors[-1]})
    return Cells(length, count, tuple(divisors), tuple(references))


def _divisor(number: int) -> int:
    """The divisor of a number that is nearest to the usual count of cells."""
    divisors = [n for n in range(1, min(number, 10 * COUNT) + 1) if number % n == 0]
    return min(divisors, key=lambda n: abs(np.log(n / COUNT)))


def lost(runs: int, until: float, h: float) -> ValueError:
    """The refusal of pilot runs none of which lasts to the horizon [s], at steps down to h [s]."""
    return ValueError(
        f"`choose(...)`: none of the {runs} pilot runs stays finite up to {until:g} s at steps down to {h:.2g} s: the "
        "loop runs away, or one of its modes is too fast for these; where it is, name a shorter step `h`."
    )

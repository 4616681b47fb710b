"""Envelopes over the draws of a sweep: the median, the middle 90 %, the range, and the worst draw by its name."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from workbench.core.validation.refusals import Array, numbers, refusal
from workbench.core.validation.signatures import check_arguments
from workbench.design.frequency.frequency_axis import phases
from workbench.report.loop_pictures.bode_pictures import DECIBELS, DEEPEST, DEGREES, FREQUENCY, limits_of, nyquist_lines
from workbench.study.document.figure import Band, Figure, Label, Mark, Panel, Series
from workbench.study.document.frequency_curves import (
    Complexes,
    FrequencyCurve,
    add_remarks,
    check_frequencies,
    complexes,
    decibels,
    join_words,
)
from workbench.study.document.gain_bounds import GainBound, shaded_bounds
from workbench.study.document.phrases_and_tables import Phrase, ReportTable, TableColumn, superscript_powers

QUANTILES = (0.05, 0.5, 0.95)
MAX_NAMES = 5  # draws without an answer that a caption names


@dataclass(frozen=True, eq=False)
@check_arguments
class Envelope:
    """The responses `rows` (N, m) of N samples over one abscissa `x` (m,), real or complex; a row with a NaN is left
    out.

    `worst` is the number of the row that is worst by a measure of the caller, or None; `worst_name` is its name, as
    'draw 17 (Ms 3.2)'.
    """

    x: Array
    rows: Complexes
    worst: int | None = None
    worst_name: str = ""

    def __post_init__(self) -> None:
        x = numbers("Envelope(x=...)", self.x, 1)
        if len(x) < 2 or not np.isfinite(x).all() or (np.diff(x) <= 0).any():
            raise refusal("Envelope(x=...)", "two or more finite numbers in rising order", self.x)
        rows = complexes("Envelope(rows=...)", self.rows, 2, gaps=True, infinite=True)
        if rows.shape[1] != len(x) or not np.isfinite(rows).all(axis=1).any():
            must = f"an array (N, {len(x)}) with a draw or more without NaN"
            raise refusal("Envelope(rows=...)", must, self.rows)
        if self.worst is not None and not 0 <= self.worst < len(rows):
            raise refusal("Envelope(worst=...)", f"the place of one of {len(rows)} draws, the first 0", self.worst)
        object.__setattr__(self, "x", x)
        object.__setattr__(self, "rows", rows)

    @property
    def sound(self) -> NDArray[np.bool_]:
        """True for the rows without a NaN, (N,)."""
        return np.asarray(np.isfinite(self.rows).all(axis=1))


@check_arguments
def bode_envelope(
    name: str,
    caption: Phrase,
    draws: Envelope,
    period: float | None = None,
    bounds: tuple[GainBound, ...] = (),
    ylabel: Label = "magnitude",
) -> Figure:
    """The gains and phases of many samples over frequencies in rad/s: median, middle 90 %, range, and the worst one.

    Quantiles are taken at each frequency; no single sample need follow one of them.

    Raises
    ------
    ValueError
        If the frequencies are not positive, or lie above Nyquist's of the period.

    Examples
    --------
    >>> from workbench.report.loop_pictures import Envelope, bode_envelope
    >>> draws = Envelope([0.5, 1.0], [[1 - 1j, 0.5 - 1j], [2 - 1j, 1 - 1j]], 0, "draw 0")
    >>> bode_envelope("draws", "Two draws", draws).name
    'draws'
    """
    omega = check_frequencies("bode_envelope(draws=...)", draws.x, period)
    if omega[0] <= 0:
        raise refusal("bode_envelope(draws=...)", "frequencies above zero, which have a logarithm", draws.x)
    held = draws.rows[draws.sound]
    gains = np.array([decibels(row) for row in held])
    turns = np.array([phases(omega, row) for row in held])
    worst = None
    if draws.worst is not None and draws.sound[draws.worst]:
        worst = decibels(draws.rows[draws.worst]), phases(omega, draws.rows[draws.worst])
    panels, limits = [], (float(omega[0]), float(omega[-1]))
    tops = nyquist_lines([FrequencyCurve("", omega, held[0], period)])
    own = ylabel if isinstance(ylabel, tuple) else (ylabel,)
    labels: tuple[Label, Label] = (*own, " [dB]"), "phase [degrees]"
    for k, (rows, steps, deepest) in enumerate(((gains, DECIBELS, DEEPEST), (turns, DEGREES, np.inf))):
        marks = envelope_marks(omega, rows, None if worst is None else worst[k], draws.worst_name)
        up = limits_of([rows.ravel()], [], deepest)
        lines = tuple(at for at in ((0.0,) if not k else (-180.0,)) if up[0] < at < up[1])
        shaded = shaded_bounds(bounds) if not k else []
        panels.append(
            Panel(
                labels[k],
                (*marks, *shaded),
                FREQUENCY,
                limits,
                up,
                "log",
                hlines=lines,
                vlines=tops if tops and omega[-1] * (1 + 1e-9) >= tops[0] else (),
                ysteps=steps,
            )
        )
    table = envelope_table(name, caption, TableColumn("frequency", "rad/s"), omega, gains, "dB")
    return Figure(name, add_remarks(caption, envelope_remarks(draws)), tuple(panels), 1, table)


@check_arguments
def envelope_figure(
    name: str,
    caption: Phrase,
    draws: Envelope,
    xlabel: Label,
    ylabel: Label,
    unit: str = "",
) -> Figure:
    """A real response of many samples, such as a step response over time: median, middle 90 %, range and worst.

    Raises
    ------
    ValueError
        If an answer is not real.

    Examples
    --------
    >>> from workbench.report.loop_pictures import Envelope, envelope_figure
    >>> envelope_figure("draws", "Two draws", Envelope([0.0, 1.0], [[0.0, 1.0], [0.0, 2.0]]), "t [s]", "y", "m").name
    'draws'
    """
    if np.abs(draws.rows[draws.sound].imag).max() > 0:
        raise refusal("envelope_figure(draws=...)", "real answers; `bode_envelope` takes complex ones", draws)
    held = draws.rows[draws.sound].real
    worst = None
    if draws.worst is not None and draws.sound[draws.worst]:
        worst = draws.rows[draws.worst].real
    own = ylabel if isinstance(ylabel, tuple) else (ylabel,)
    label = (*own, f" [{superscript_powers(unit)}]") if unit not in ("", "1") else own
    limits = float(draws.x[0]), float(draws.x[-1])
    panel = Panel(label, tuple(envelope_marks(draws.x, held, worst, draws.worst_name)), xlabel, limits)
    table = envelope_table(name, caption, TableColumn(xlabel), draws.x, held, unit)
    return Figure(name, add_remarks(caption, envelope_remarks(draws)), (panel,), 1, table)


def envelope_marks(x: Array, rows: Array, worst: Array | None, worst_name: str) -> list[Mark]:
    """The worst draw, the median, the middle 90 % and the range at each abscissa at which any draw has a number."""
    there = np.isfinite(rows).any(axis=0)
    low, middle, high = np.nanquantile(rows[:, there], QUANTILES, axis=0)
    least, most = np.nanmin(rows[:, there], axis=0), np.nanmax(rows[:, there], axis=0)
    marks: list[Mark] = []
    if worst is not None:
        marks.append(Series(f"worst: {worst_name}" if worst_name else "worst draw", x, worst, 1))
    marks.append(Series("median", x[there], middle, 0))
    marks.append(Band("middle 90 %", x[there], low, high, 0))
    marks.append(Band("all draws", x[there], least, most, "reference"))
    return marks


def envelope_table(name: str, caption: Phrase, head: TableColumn, x: Array, rows: Array, unit: str) -> ReportTable:
    """The least, the quantiles and the largest at each abscissa."""
    there = np.isfinite(rows).any(axis=0)
    columns = (
        *np.nanquantile(rows[:, there], QUANTILES, axis=0),
        np.nanmin(rows[:, there], axis=0),
        np.nanmax(rows[:, there], axis=0),
    )
    heads = [TableColumn(words, unit) for words in ("5 % quantile", "median", "95 % quantile", "least", "largest")]
    return ReportTable(
        name, caption, (head, *heads), tuple(tuple(map(float, row)) for row in zip(x[there], *columns, strict=True))
    )


def envelope_remarks(draws: Envelope) -> list[Phrase]:
    """Sentences on the number of draws, on those that are left out, and on the worst."""
    count, lost = len(draws.rows), np.flatnonzero(~draws.sound)
    said: list[Phrase] = [f"Of {count} draws, the median, the middle 90 % and the range at each place."]
    if lost.size:
        some = join_words([str(k) for k in lost[:MAX_NAMES].tolist()])
        more = f" and {lost.size - MAX_NAMES} others" if lost.size > MAX_NAMES else ""
        words = "1 draw that has" if lost.size == 1 else f"{lost.size} draws that have"
        said.append(f"Left out: {words} no answer somewhere ({some}{more}, counted from 0).")
    if draws.worst is not None:
        name = draws.worst_name or f"draw {draws.worst}"
        shown = "" if draws.sound[draws.worst] else ", which has no answer somewhere and is not drawn"
        said.append(f"The worst is {name}{shown}.")
    return said

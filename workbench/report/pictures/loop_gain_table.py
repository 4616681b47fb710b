"""The margins of a loop gain, its peaks and its poles as a table, which moves on a live page."""

from __future__ import annotations

import math

import numpy as np

from workbench.design.frequency import CertifiedValue, StabilityMargins
from workbench.report.loop_pictures.margin_words import fall_in_decibels, in_decibels
from workbench.report.pictures.loop_gains import Complex, LoopGain, linear_source
from workbench.study.document.phrases_and_tables import (
    Cell,
    MissingCell,
    Phrase,
    ReportTable,
    TableColumn,
    ValueWithError,
    superscript_powers,
)
from workbench.study.document.source import Source
from workbench.study.study_results import Outcome

UNSTABLE = "unstable"  # in place of a margin, where the closed loop has none
BOUNDLESS = "no limit"  # in place of a margin that nothing limits
EPS = float(np.finfo(float).eps)
OF_CHANNELS = {  # quantities and their units
    "phase margin": "degrees",
    "gain margin": "dB",
    "gain may fall by": "dB",
    "delay margin": "s",
    "Ms": "1",
    "Mt": "1",
}
SEVERAL = (
    "The margins of one channel hold while the loops of all others are closed and stay as they are. Only the disk "
    "margin allows for changes of all at once."
)


def margin_table(name: str, caption: Phrase, outcome: Outcome, gain: LoopGain) -> ReportTable:
    """A row for each margin and each peak, a column for each channel, then what all channels have in common."""
    several = len(gain.channels) > 1
    rows: list[tuple[Cell, ...]] = []
    for quantity, unit in OF_CHANNELS.items():
        cells = (
            _cell(_value(margins, quantity), _reason(margins), linear_source(outcome, quantity, i, channel, unit))
            for i, (channel, margins) in enumerate(zip(gain.channels, gain.margins, strict=True))
        )
        rows.append((quantity, superscript_powers(unit), *cells, *([""] if several else [])))
    for quantity, unit, value in _common(gain):
        reason = UNSTABLE if quantity == "disk margin" else "none"
        cell = _cell(value, reason, linear_source(outcome, quantity, unit=unit))
        rows.append((quantity, superscript_powers(unit), *([""] * len(gain.channels) if several else []), cell))
    heads = [*gain.channels, "all at once"] if several else ["value"]
    columns = TableColumn("quantity"), TableColumn("unit"), *(TableColumn(head, align="right") for head in heads)
    return ReportTable(name, caption, columns, tuple(rows), (SEVERAL,) if several else ())


def _value(found: StabilityMargins | None, quantity: str) -> CertifiedValue | None:
    """A margin or a peak of a channel; None if there is none."""
    held = None if found is None else found.margins
    if held is None:
        return None
    if quantity == "gain may fall by":
        return fall_in_decibels(held.gain_low)
    if quantity == "gain margin":
        return in_decibels(held.gain_high)
    values = {
        "phase margin": held.phase_margin,
        "delay margin": held.delay_margin,
        "Ms": held.Ms.gain,
        "Mt": held.Mt.gain,
    }
    return values[quantity]


def _reason(found: StabilityMargins | None) -> str:
    return "not known" if found is None else UNSTABLE


def _common(gain: LoopGain) -> list[tuple[str, str, CertifiedValue | None]]:
    """The disk margin of all channels at once, the largest pole, and the least damping of a pole."""
    disk = gain.disk_margin
    margin = None if disk is None else CertifiedValue(disk.alpha, disk.alpha, disk.alpha_above)
    poles = gain.poles
    if gain.period is None:
        largest, name, unit = poles.real.max(initial=-math.inf), "largest real part of a pole", "1/s"
    else:
        largest, name, unit = np.abs(poles).max(initial=-math.inf), "largest pole, absolute value", "1"
    return [
        ("disk margin", "1", margin),
        (name, unit, _rounded(largest, float(np.abs(poles).max(initial=0.0)))),
        ("least damping of a pole", "1", _rounded(least_damping(poles, gain.period), 1.0)),
    ]


def least_damping(poles: Complex, period: float | None) -> float:
    """The least -Re(s) / |s| of poles s, in a computer of s = log(z) / period; infinite if there is none."""
    with np.errstate(divide="ignore", invalid="ignore"):
        s = poles if period is None else np.log(poles[poles != 0]) / period
        damping = -s.real / np.abs(s)
    damping = damping[np.isfinite(damping)]
    return float(damping.min(initial=math.inf))


def _rounded(value: float, size: float) -> CertifiedValue | None:
    """A number that was computed in doubles, from others of a size."""
    if not math.isfinite(value):
        return None
    doubt = 1e3 * EPS * max(size, abs(value))
    return CertifiedValue(float(value), float(value) - doubt, float(value) + doubt)


def _cell(value: CertifiedValue | None, reason: str, source: Source) -> Cell:
    """The cell of a number, or of the words in its place."""
    if value is None:
        return MissingCell(reason, source)
    if math.isinf(value.value):
        return MissingCell(BOUNDLESS, source)
    return ValueWithError(value.value, value.error, source)

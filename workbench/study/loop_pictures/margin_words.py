"""The margins of loops in words: names of marked crossovers, and sentences for a caption."""

from __future__ import annotations

import math
from collections.abc import Sequence

from workbench.design.frequency import CertifiedValue, Crossover, StabilityMargins
from workbench.study.document.figure import Label
from workbench.study.document.phrases import Phrase
from workbench.study.loop_pictures.frequency_curves import FrequencyCurve, number, written

SAME = 1e-12  # relative, of two figures that are one
ROUNDED = 1e-12  # a factor below which a gain margin is none, but for the rounding of poles of L at zero


def in_decibels(gain: CertifiedValue) -> CertifiedValue:
    """A positive factor in decibels."""
    return CertifiedValue(
        *(20 * math.log10(part) if part > 0 else -math.inf for part in (gain.value, gain.low, gain.high))
    )


def names_of_gains(found: StabilityMargins, rows: Sequence[Crossover]) -> tuple[Label, ...]:
    """The names of phase crossovers: 'gain margin 6.02 dB, 1.73 rad/s' at the one or two that decide."""
    if found.margins is None:
        return tuple(f"{number(row.frequency.value)} rad/s" for row in rows)
    held = (found.margins.gain_low, found.margins.gain_high)
    decides = [any(_same(row.margin, one) for one in held) for row in rows]
    return tuple(
        f"gain margin {written(in_decibels(row.margin))} dB, {written(row.frequency)} rad/s" if here else ""
        for row, here in zip(rows, decides, strict=True)
    )


def names_of_phases(found: StabilityMargins, rows: Sequence[Crossover]) -> tuple[Label, ...]:
    """The names of gain crossovers: 'phase margin 45 degrees, 1.2 rad/s' at the one that decides."""
    if found.margins is None:
        return tuple(f"{number(row.frequency.value)} rad/s" for row in rows)
    return tuple(
        f"phase margin {written(row.margin)} degrees, {written(row.frequency)} rad/s"
        if math.isclose(abs(row.margin.value), found.margins.phase_margin.value, rel_tol=SAME)
        else ""
        for row in rows
    )


def _same(one: CertifiedValue, other: CertifiedValue) -> bool:
    return math.isclose(one.value, other.value, rel_tol=SAME)


def margin_remarks(curves: Sequence[FrequencyCurve], several: bool) -> list[Phrase]:
    """A sentence for each curve with margins, which begins with its label if the picture has several curves."""
    said: list[Phrase] = []
    for one in curves:
        if one.margins is not None:
            sentence = margin_sentence(one.margins)
            if one.all_channels is not None:
                sentence = f"{sentence[:-1]}; disk margin of all channels at once {number(one.all_channels)}."
            label = one.label if isinstance(one.label, tuple) else (one.label,)
            said.append((*label, ": ", f"{sentence[0].lower()}{sentence[1:]}") if several else sentence)
    return said


def margin_sentence(found: StabilityMargins) -> str:
    """The margins in a sentence, or that there are none."""
    held = found.margins
    if held is None:
        return "The closed loop is not stable, so that it has no margins."
    parts = []
    if math.isfinite(held.gain_high.value):
        parts.append(f"gain margin {written(in_decibels(held.gain_high))} dB upwards")
    if held.gain_low.value > ROUNDED:
        parts.append(f"gain margin {written(in_decibels(held.gain_low))} dB downwards")
    if math.isfinite(held.phase_margin.value):
        parts.append(f"phase margin {written(held.phase_margin)} degrees")
        if math.isfinite(held.delay_margin.value):
            parts.append(f"delay margin {written(held.delay_margin)} s")
    parts += [f"Ms {written(held.Ms.gain)}", f"disk margin {written(held.disk_margin)}"]
    sentence = ", ".join(parts)
    return f"{sentence[0].upper()}{sentence[1:]}."

"""The margins of loops in words: names of marked crossovers, and sentences for a caption."""

from __future__ import annotations

import math
from collections.abc import Sequence

from workbench.design.frequency import CertifiedValue, Crossover, StabilityMargins
from workbench.study.document.figure import Label
from workbench.study.document.frequency_curves import FrequencyCurve, certified_text, number
from workbench.study.document.phrases_and_tables import Phrase

SAME = 1e-12  # relative, of two figures that are one
ROUNDING = 1e-12  # a factor below which a gain margin is none, but for the rounding of poles of L at zero


def in_decibels(gain: CertifiedValue) -> CertifiedValue:
    """A positive factor in decibels."""
    return CertifiedValue(
        *(20 * math.log10(part) if part > 0 else -math.inf for part in (gain.value, gain.low, gain.high))
    )


def fall_in_decibels(factor: CertifiedValue) -> CertifiedValue:
    """By how many decibels a gain falls that is multiplied by a factor; infinite for zero."""
    gain = in_decibels(factor)
    return CertifiedValue(-gain.value, -gain.high, -gain.low)


def names_of_gains(margins: StabilityMargins, rows: Sequence[Crossover]) -> tuple[Label, ...]:
    """The names of phase crossovers: 'gain margin 6.02 dB, 1.73 rad/s' at the one or two that decide.

    Where the gain may fall, the name is 'gain may fall by 13.3 dB, 2.1 rad/s'.
    """
    if margins.margins is None:
        return tuple(f"{number(row.frequency.value)} rad/s" for row in rows)
    held = (margins.margins.gain_low, margins.margins.gain_high)
    decides = [any(_same(row.margin, one) for one in held) for row in rows]
    return tuple(
        f"{_of_gain(row.margin)}, {certified_text(row.frequency)} rad/s" if here else ""
        for row, here in zip(rows, decides, strict=True)
    )


def _of_gain(factor: CertifiedValue) -> str:
    """The factor of a gain in words: 'gain margin 6.02 dB', below one 'gain may fall by 13.3 dB'."""
    return f"gain may fall by {_fall(factor)} dB" if factor.value < 1 else f"gain margin {_rise(factor)} dB"


def _rise(factor: CertifiedValue) -> str:
    return certified_text(in_decibels(factor))


def _fall(factor: CertifiedValue) -> str:
    return certified_text(fall_in_decibels(factor))


def names_of_phases(margins: StabilityMargins, rows: Sequence[Crossover]) -> tuple[Label, ...]:
    """The names of gain crossovers: 'phase margin 45 degrees, 1.2 rad/s' at the one that decides."""
    if margins.margins is None:
        return tuple(f"{number(row.frequency.value)} rad/s" for row in rows)
    return tuple(
        f"phase margin {certified_text(row.margin)} degrees, {certified_text(row.frequency)} rad/s"
        if math.isclose(abs(row.margin.value), margins.margins.phase_margin.value, rel_tol=SAME)
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
            if one.multiloop_disk_margin is not None:
                sentence = f"{sentence[:-1]}; disk margin of all channels at once {number(one.multiloop_disk_margin)}."
            label = one.label if isinstance(one.label, tuple) else (one.label,)
            said.append((*label, ": ", f"{sentence[0].lower()}{sentence[1:]}") if several else sentence)
    return said


def margin_sentence(margins: StabilityMargins) -> str:
    """The margins in a sentence, or that there are none.

    The gain margin is how far the gain may rise. Where it may not fall to zero, the sentence says how far it may fall.
    """
    held = margins.margins
    if held is None:
        return "The closed loop is not stable, so that it has no margins."
    parts, falls = [], held.gain_low.value > ROUNDING
    if math.isfinite(held.gain_high.value):
        also = f" (the gain may also fall by {_fall(held.gain_low)} dB)" if falls else ""
        parts.append(f"gain margin {_rise(held.gain_high)} dB{also}")
    head = f"the gain may fall by {_fall(held.gain_low)} dB and rise without limit; " if falls and not parts else ""
    if math.isfinite(held.phase_margin.value):
        parts.append(f"phase margin {certified_text(held.phase_margin)} degrees")
        if math.isfinite(held.delay_margin.value):
            parts.append(f"delay margin {certified_text(held.delay_margin)} s")
    parts += [f"Ms {certified_text(held.Ms.gain)}", f"disk margin {certified_text(held.disk_margin)}"]
    sentence = head + ", ".join(parts)
    return f"{sentence[0].upper()}{sentence[1:]}."

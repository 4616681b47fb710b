"""Frequency answers as plain data, and what pictures read from them: decibels, phases without jumps, and words."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from workbench.core.validation.refusals import Array, refusal, seconds
from workbench.core.validation.signatures import check_arguments
from workbench.design.frequency import CertifiedValue, StabilityMargins
from workbench.design.frequency.frequency_axis import checked_frequencies
from workbench.study.document.figure import STYLES, Label, Style
from workbench.study.document.phrases_and_tables import Phrase
from workbench.study.document.source import Source

Complex = NDArray[np.complex128]
if TYPE_CHECKING:
    Complexes: TypeAlias = Complex | Array
else:
    Complexes = object  # any numbers, which the field's class makes into an array: it names the place that is wrong
DOUBTFUL = 120.0  # degrees between two frequencies, beyond which the direction of a turn is not certain


@dataclass(frozen=True, eq=False)
@check_arguments
class CornerFrequencies:
    """The poles (n,), zeros (m,) and gain of G(s) = gain (s - z1) ... / (s - p1) ..., for its asymptotes.

    Examples
    --------
    >>> from workbench.report.loop_pictures import CornerFrequencies
    >>> CornerFrequencies([-1.0], [-2.0], 1.0)
    CornerFrequencies(poles=[-1+0j], zeros=[-2+0j], gain=1)
    """

    poles: Complexes
    zeros: Complexes
    gain: float

    def __post_init__(self) -> None:
        for name in ("poles", "zeros"):
            object.__setattr__(self, name, complexes(f"CornerFrequencies({name}=...)", getattr(self, name), 1))
        if not (math.isfinite(self.gain) and self.gain):
            raise refusal("CornerFrequencies(gain=...)", "a finite number that is not zero", self.gain)


@dataclass(frozen=True, eq=False)
@check_arguments
class FrequencyCurve:
    """The response `values` (m,) of one channel at `frequencies` (m,) in rad/s; NaN is a gap, as at a pole.

    For a loop in a computer, `period` is its period in s; frequencies then end at Nyquist's, pi / period. `unit` is
    that of the values, '' for a loop gain. `margins` are the certified margins of a loop, and `corners` its poles,
    zeros and gain. If the loop has several channels, `multiloop_disk_margin` is the disk margin for simultaneous
    changes in all of them. `style` is as in `Series`; if it is None, it follows from the position among the curves of
    the picture. `source` is the loop and the channel of the response. With it, a live page draws the picture again when
    a knob turns. The caption then has no numbers, as it is not written again. `integrators` is the number of poles of L
    at zero, or at z = 1, if it is known. `covariance` (m, 2, 2) is that of the real and the imaginary part of an
    estimate; pictures draw its region of 95 %.

    Examples
    --------
    >>> omega = np.geomspace(0.1, 10.0, 200)
    >>> lag = wb.FrequencyCurve("a lag", omega, 1 / (1 + 1j * omega))
    >>> len(wb.bode(lag).figure.panels)
    2
    """

    label: Label
    frequencies: Array
    values: Complexes
    period: float | None = None
    unit: str = ""
    margins: StabilityMargins | None = None
    corners: CornerFrequencies | None = None
    style: Style | None = None
    multiloop_disk_margin: float | None = None
    source: Source | None = None
    integrators: int | None = None
    covariance: Array | None = None

    def __post_init__(self) -> None:
        omega = check_frequencies("FrequencyCurve(frequencies=...)", self.frequencies, self.period)
        values = complexes("FrequencyCurve(values=...)", self.values, 1, gaps=True)
        if values.shape != omega.shape:
            raise ValueError(
                f"`FrequencyCurve(values=...)` must have an answer for each of {len(omega)} frequencies; got "
                f"{len(values)}."
            )
        if self.covariance is not None and self.covariance.shape != (len(omega), 2, 2):
            raise ValueError(
                f"`FrequencyCurve(covariance=...)` must have shape {(len(omega), 2, 2)}, a matrix for each frequency; "
                f"got {self.covariance.shape}."
            )
        object.__setattr__(self, "frequencies", omega)
        object.__setattr__(self, "values", values)

    @property
    def logarithmic(self) -> tuple[Array, Complex]:
        """The frequencies above zero, which have a logarithm, and the values there."""
        above = self.frequencies > 0
        return self.frequencies[above], np.asarray(self.values[above], dtype=complex)

    @check_arguments
    def sources(self, up: str, across: str = "frequency", scale: float = 1.0) -> tuple[Source, Source] | None:
        """The sources of the two columns of a `Series` of this curve, by the names of ordinate and abscissa."""
        if self.source is None:
            return None
        return self.source.with_name(across), self.source.with_name(up).times(scale)


def check_frequencies(call: str, frequencies: Array, period: float | None) -> Array:
    """Frequencies (m,) of a picture in rad/s: two or more, each above the one before, up to Nyquist's of a period."""
    if period is not None:
        seconds(f"{call.partition('(')[0]}(period=...)", period)
    omega = checked_frequencies(call, frequencies, period)
    if len(omega) < 2 or (omega[1:] == omega[:-1]).any():
        raise refusal(call, "two or more frequencies in rad/s, each above the one before", frequencies)
    return omega


def complexes(call: str, value: object, ndim: int, gaps: bool = False, infinite: bool = False) -> Complex:
    """Complex numbers on `ndim` axes, finite but for NaN where `gaps` are allowed; `infinite` ones become gaps."""
    must = f"complex numbers on {ndim} {'axis' if ndim == 1 else 'axes'}{', NaN for a gap' if gaps else ', finite'}"
    try:
        array = np.array(value, dtype=complex)
    except Exception:  # an object of the user's may raise anything when it is asked for its numbers
        raise refusal(call, must, value) from None
    if infinite:
        array[np.isinf(array.real) | np.isinf(array.imag)] = np.nan
    bad = np.isinf(array.real) | np.isinf(array.imag) if gaps else ~np.isfinite(array)
    if array.ndim != ndim or bad.any():
        raise refusal(call, must, value)
    array.flags.writeable = False
    return array


def styles(curves: Sequence[FrequencyCurve]) -> list[Style]:
    """The style of each curve: its own, or else its place."""
    return [k % STYLES if one.style is None else one.style for k, one in enumerate(curves)]


def decibels(values: Complex) -> Array:
    """20 log10 |values|, NaN where a value is zero or a gap."""
    sizes = np.abs(values)
    with np.errstate(divide="ignore"):
        return np.where(sizes > 0, 20 * np.log10(sizes), np.nan)


def doubts(curve: FrequencyCurve, several: bool) -> list[Phrase]:
    """A sentence on the frequencies between which the phase turns so far that its direction is not certain.

    It begins with the label of the curve if the picture has several.
    """
    omega, values = curve.logarithmic
    held = np.isfinite(values) & (values != 0)
    omega, values = omega[held], values[held]
    steps = np.degrees(np.abs(np.angle(values[1:] / values[:-1]))) if len(values) > 1 else np.zeros(0)
    label = curve.label if isinstance(curve.label, tuple) else (curve.label,)
    return [
        (
            *((*label, ": ") if several else ()),
            f"{_span(omega[k], omega[k + 1], several)} rad/s the phase turns by {steps[k]:.0f} degrees in one step, so "
            "that its direction is not certain.",
        )
        for k in np.flatnonzero(steps > DOUBTFUL)[:1]
    ]


def _span(low: float, high: float, inside: bool) -> str:
    """Where a step lies, as the words of a sentence or of its second part: 'Between 1 and 2', or 'At 1'."""
    ends = number(low), number(high)
    words = f"At {ends[0]}" if ends[0] == ends[1] else f"Between {ends[0]} and {ends[1]}"
    return words[0].lower() + words[1:] if inside else words


def number(value: float, digits: int = 3) -> str:
    """A number in words for a picture, of a few significant digits."""
    if math.isinf(value):
        return "infinity" if value > 0 else "minus infinity"
    rounded = float(f"{value:.{digits}g}")
    if rounded == 0 or 1e-3 <= abs(rounded) < 1e5:
        return np.format_float_positional(rounded, trim="-").replace("-", "−")
    mantissa, exponent = f"{rounded:.{digits - 1}e}".split("e")
    return f"{float(mantissa):g}e{int(exponent)}".replace("-", "−")


def certified_text(value: CertifiedValue, factor: float = 1.0) -> str:
    """A certified value times a factor with the digits that its bounds support, three at most; else the bounds."""
    ends = [factor * value.low, factor * value.value, factor * value.high]
    for digits in (3, 2):
        texts = {number(end, digits) for end in ends}
        if len(texts) == 1:
            return texts.pop()
    return f"{number(ends[0], 2)} to {number(ends[2], 2)}"


def between(omega: Array, numbers_at: Array, at: float) -> float:
    """A number at a frequency, on the straight line over the logarithm between its neighbours; NaN outside."""
    held = np.isfinite(numbers_at)
    if held.sum() < 2:
        return float("nan")
    return float(np.interp(math.log(at), np.log(omega[held]), numbers_at[held], left=np.nan, right=np.nan))


def add_remarks(caption: Phrase, remarks: Sequence[Phrase]) -> Phrase:
    """A caption that ends with sentences of remarks."""
    if not remarks:
        return caption
    parts = [part for part in (caption if isinstance(caption, tuple) else (caption,)) if part != ""]
    if parts and not (isinstance(parts[-1], str) and parts[-1].rstrip().endswith((".", "!", "?"))):
        parts.append(".")
    for remark in remarks:
        parts += [*([" "] if parts else []), *(remark if isinstance(remark, tuple) else (remark,))]
    return tuple(parts)


def join_words(parts: Sequence[Phrase]) -> str:
    """Words in a row: 'a', 'a and b', 'a, b and c'."""
    texts = [str(part) for part in parts]
    return texts[0] if len(texts) == 1 else f"{', '.join(texts[:-1])} and {texts[-1]}"


def breaks(inside: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """The first place of each stretch of True, and the place behind its last."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], np.asarray(inside, dtype=int), [0]])))
    return list(pairwise(edges.tolist()))[::2]

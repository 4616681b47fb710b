"""The figures of a step response in a computer: the samples that reach, leave and exceed a level, decided exactly."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction

from workbench.design.frequency.stable_ratios import StableRatio
from workbench.design.matrices import DesignError
from workbench.design.step_response.complex_balls import ComplexBall
from workbench.design.step_response.piece_figures import Top
from workbench.design.step_response.response_modes import ResponseMode, ResponseModes

PLACES = 240
MOST_SAMPLES = 100_000
LONGEST_EXACT = 400  # samples whose fractions are still short
QUIET = 2.0**-70
Bounds = tuple[Fraction, Fraction]


@dataclass(frozen=True, eq=False)
class ExactSamples:
    """The samples of a step response as fractions, each from those before it, for what bounds do not decide."""

    ratio: StableRatio
    scale: Fraction
    values: list[Fraction] = field(default_factory=list)

    def value(self, k: int) -> Fraction:
        """The sample y_k."""
        if k >= LONGEST_EXACT:
            raise DesignError(
                f"`step_info(system)`: sample {k} lies on a level that decides a figure, as far as bounds tell; change "
                "a number of the system in its last digits, and look on both sides."
            )
        N, D = self.ratio.numerator, self.ratio.denominator
        while len(self.values) <= k:
            m, n = len(self.values), len(D) - 1
            driven = sum(N[n - i] for i in range(min(m, n) + 1) if n - i < len(N))
            past = sum(D[n - i] * self.values[m - i] for i in range(1, min(m, n) + 1))
            self.values.append((driven / self.scale - past) / D[n])
        return self.values[k]


@dataclass(frozen=True)
class SampledFigures:
    """Numbers of periods: to 10 %, to 90 %, and after which all samples lie within 2 %; and the extreme samples."""

    low: int | None
    high: int | None
    settling_count: int | None
    top: Top
    bottom: Top


def sampled_figures(
    ratio: StableRatio, response: ResponseModes, scale: Fraction, rise: tuple[Fraction, Fraction], band: Fraction
) -> SampledFigures:
    """The figures of the samples y_k over `scale`; those relative to the final value are None if that is zero."""
    relative = response.final != 0
    reached: list[int | None] = [None, None]
    outside, rows = -1, list[tuple[int, Bounds]]()
    best, worst = max(response.final, Fraction(0)), max(-response.final, Fraction(0))
    exact = ExactSamples(ratio, scale)
    for k, (low, high) in enumerate(samples(response, exact)):
        known = low, high
        if relative:
            for i, level in enumerate(rise):
                if reached[i] is None and _not_less(known, level, k, exact):
                    reached[i] = k
            if _not_less(known, 1 + band, k, exact) or _not_less((-high, -low), band - 1, k, exact, -1):
                outside = k
        if high >= best or -low >= worst:
            rows.append((k, known))
            best, worst = max(best, low), max(worst, -high)
        if k >= response.first and _has_ended(
            response, k + 1, best, worst, outside < k and None not in reached, relative, band
        ):
            break
        if k >= MOST_SAMPLES:
            raise DesignError(
                f"`step_info(system)` looks at up to {MOST_SAMPLES} samples, within which this response does not "
                "settle; take a longer period."
            )
    top, bottom = (_top(rows, sign, response, k + 1) for sign in (1, -1))
    return SampledFigures(reached[0], reached[1], outside + 1 if relative else None, top, bottom)


def _has_ended(
    response: ResponseModes, k: int, best: Fraction, worst: Fraction, has_risen: bool, relative: bool, band: Fraction
) -> bool:
    """True if no sample from k on changes a figure."""
    away = response.envelope(k)
    if relative and not (has_risen and away < float(band) * (1 - 1e-6)):
        return False
    return away < QUIET or all(
        sign * response.final + (0 if sign * response.side(k) < 0 else Fraction(away)) <= bound
        for sign, bound in ((1, best), (-1, worst))
    )


def _top(rows: list[tuple[int, Bounds]], sign: int, response: ResponseModes, end: int) -> Top:
    limit = sign * response.final
    held = [(k, known if sign > 0 else (-known[1], -known[0])) for k, known in rows]
    best = max([limit, Fraction(0), *(low for _, (low, _) in held)])
    away = Fraction(0) if sign * response.side(end) < 0 or not response.modes else Fraction(response.envelope(end))
    high = max([best, limit + away, *(top for _, (_, top) in held)])
    kept = [(k, low) for k, (low, top) in held if top >= best and top > 0]
    sure = [k for k, low in kept if low >= high]
    first = min((k for k, _ in kept), default=None)
    open_end = limit + away >= best and limit >= 0 and not sure
    last = sure[0] if sure else None if open_end or not kept else max(k for k, _ in kept)
    return Top(best, high, None if first is None else Fraction(first), None if last is None else Fraction(last))


def _not_less(bounds: Bounds, level: Fraction, k: int, exact: ExactSamples, sign: int = 1) -> bool:
    """True if a sample, or its negative, within known bounds is not less than a level."""
    if bounds[0] >= level:
        return True
    return bounds[1] >= level and sign * exact.value(k) >= level


def samples(response: ResponseModes, exact: ExactSamples) -> Iterator[Bounds]:
    """Bounds of each sample in turn."""
    for k in range(response.first):
        value = exact.value(k)
        yield value, value
    k, unit = response.first, 1 << PLACES
    powers = [_power(mode.pole, k) for mode in response.modes]
    while True:
        total, doubt = 0, 0
        for i, mode in enumerate(response.modes):
            re, _, off = _term(mode, powers[i], k).to_fixed_point(PLACES)
            total, doubt = total + (re if mode.real else 2 * re), doubt + (off if mode.real else 2 * off)
            powers[i] = powers[i] * mode.pole
        if doubt > QUIET * unit:
            raise DesignError(
                "`step_info(system)`: modes of this system cancel each other to so many digits that its response "
                "cannot be enclosed; round its numbers, or take a system of lower order."
            )
        yield response.final + Fraction(total - doubt, unit), response.final + Fraction(total + doubt, unit)
        k += 1


def _term(mode: ResponseMode, power: ComplexBall, k: int) -> ComplexBall:
    """The sum of c_j C(k, j-1) p^(k-j+1), with `power` = p^k."""
    if len(mode.factors) == 1:
        return mode.factors[0] * power
    inverse, total = mode.pole.inverse(), ComplexBall(0, 0, 0, 0)
    for j, factor in enumerate(mode.factors):
        total = total + factor * power * ComplexBall(math.comb(k, j), 0, 0, 0)
        power = power * inverse
    return total


def _power(pole: ComplexBall, k: int) -> ComplexBall:
    result = ComplexBall(1, 0, 0, 0)
    for _ in range(k):
        result = result * pole
    return result

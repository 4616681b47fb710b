"""The step response of a stable ratio as a sum of modes, and what bounds each of them for all later times.

In continuous time y(t) = G(0) + sum of c_j t^(j-1) / (j-1)! exp(p t), in a computer y_k = G(1) + sum of c_j
C(k, j-1) p^(k-j+1): over all poles p, each with j from 1 to its multiplicity. Every number has a radius.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.frequency.complex_roots import root_disks
from workbench.design.frequency.integer_polynomials import Polynomial, square_free_factors
from workbench.design.frequency.stable_ratios import StableRatio
from workbench.design.step_response.complex_balls import ONE, ZERO, ComplexBall

SHARP = 300  # bits of a pole
SAFE = 1e-9  # more than the rounding of an exponent up to 1e5
FAR = -700.0  # an exponent whose exponential no longer counts


@dataclass(frozen=True)
class ResponseMode:
    """A real pole, or of a pair of poles the one above the axis, and its factors c_1, c_2, ... in the response.

    `decay` is a bound from below and above of -Re p in 1/s, or of -log |p|; `sizes` are the logarithms of |c_j| from
    above, those of both poles of a pair together.
    """

    pole: ComplexBall
    factors: tuple[ComplexBall, ...]
    real: bool
    decay: tuple[float, float]
    sizes: tuple[float, ...]
    discrete: bool

    def envelope(self, t: float, drop: int = 0) -> float:
        """A bound of the mode from a time in s, or a number of periods, on; with `drop` of t^(j-1-drop) / (j-1-drop)!.

        A term that still rises counts with its largest value.
        """
        total = 0.0
        for j, size in enumerate(self.sizes):
            if (power := j - drop) >= 0:
                total += math.exp(min(700.0, max(FAR, size + self.log_term(t, power))))
        return total * (1 + SAFE)

    def log_term(self, t: float, power: int) -> float:
        """The logarithm of t^power / power! exp(-decay t), or C(t, power) |p|^(t - power): the most from t on."""
        slow, shrink = self.decay[0], math.exp(-self.decay[0]) if self.discrete else 0.0
        if not self.discrete:
            t = max(t, power / slow)
            return (power * math.log(t) if power else 0.0) - math.lgamma(power + 1) - slow * t
        t = max(t, (power - 1 + shrink) / (1 - shrink) if power else 0.0, float(power))
        ways = math.lgamma(t + 1) - math.lgamma(power + 1) - math.lgamma(t - power + 1)
        return ways - slow * (t - power) + 1e-12 * (1 + abs(ways))


@dataclass(frozen=True)
class ResponseModes:
    """The modes of a step response about its final value, and how many first samples follow poles at z = 0, too."""

    final: Fraction
    modes: tuple[ResponseMode, ...]
    first: int

    def envelope(self, t: float) -> float:
        """A bound of the distance from the final value from a time on."""
        return sum(mode.envelope(t) for mode in self.modes)

    def rough(self, t: Array) -> Array:
        """The response at times (N,) in s in doubles, of which nothing is proved, in continuous time."""
        y = np.full(len(t), float(self.final))
        for mode in self.modes:
            p, weight = mode.pole.to_complex(), 1 if mode.real else 2
            grown = weight * np.exp(p * t)
            for j, factor in enumerate(mode.factors):
                y = y + (factor.to_complex() * grown * t**j / math.factorial(j)).real
        return np.asarray(y, dtype=float)

    def side(self, t: float) -> int:
        """The sign of y - final for all times from t on, if the slowest mode is real and outweighs all others; else 0.

        The share of each other mode in the slowest one falls from here on.
        """
        if not self.modes:
            return 0
        slowest = min(self.modes, key=lambda mode: mode.decay)
        lead = slowest.factors[-1]
        if not slowest.real or abs(lead.re) <= lead.radius or t <= 0 or (slowest.discrete and slowest.pole.re <= 0):
            return 0
        top = len(slowest.factors) - 1
        if slowest.discrete and t < top:
            return 0
        logarithm = ComplexBall(abs(lead.re) - 2 * lead.radius, 0, lead.exponent, 0).logarithm() - 1e-9
        rate = slowest.decay[1]
        if slowest.discrete:
            ways = math.lgamma(t + 1) - math.lgamma(top + 1) - math.lgamma(t - top + 1)
            own = logarithm + ways - rate * (t - top)
        else:
            own = logarithm + top * math.log(t) - math.lgamma(top + 1) - rate * t
        others = 0.0
        for mode in self.modes:
            for j in range(len(mode.sizes)):
                if mode is slowest and j == top:
                    continue
                if not _falls(mode, j, slowest, top, t):
                    return 0
                others += math.exp(min(700.0, mode.sizes[j] + mode.log_term(t, j) - own))
        if not others < 1 - 1e-6:
            return 0
        return 1 if lead.re > 0 else -1


def _falls(mode: ResponseMode, j: int, slowest: ResponseMode, top: int, t: float) -> bool:
    """True if the share of a term of a mode in the slowest one falls for all times from t on."""
    if mode is slowest:
        return j < top
    gap = mode.decay[0] - slowest.decay[1]
    if gap <= 0:
        return False
    if j <= top:
        return True
    if mode.discrete:
        return math.exp(-gap) * (t + 1 - top) <= t + 1 - j
    return t >= (j - top) / gap


def response_modes(ratio: StableRatio, scale: Fraction) -> ResponseModes:
    """The modes of the step response of a ratio, divided by `scale`.

    Raises
    ------
    DesignError
        If two poles are too near to each other.
    """
    discrete = ratio.period is not None
    denominator = ratio.denominator
    first = next(i for i, a in enumerate(denominator) if a)
    held = list(_poles(denominator[first:]))
    fixed = [(ONE, 1)] if discrete else [(ZERO, 1)]
    if first:
        fixed.append((ZERO, first))
    modes = []
    unit = ComplexBall.of(1 / (scale * denominator[-1]))
    for i, (pole, multiplicity) in enumerate(held):
        if pole.im < 0:
            continue
        others = [one for k, one in enumerate(held) if k != i] + fixed
        factors = tuple(reversed(_series(ratio.numerator, pole, others, multiplicity, unit)))
        modes.append(_mode(pole, factors, discrete))
    return ResponseModes(ratio.final / scale, tuple(modes), first)


def _mode(pole: ComplexBall, factors: tuple[ComplexBall, ...], discrete: bool) -> ResponseMode:
    real = pole.im == 0
    sizes = tuple(factor.logarithm() + (0.0 if real else math.log(2)) + 1e-12 for factor in factors)
    if discrete:
        middle = -pole.logarithm()
        decay = middle - 1e-11, middle + 1e-11
    else:
        size = ComplexBall(pole.re, 0, pole.exponent, 0).logarithm()
        middle = math.exp(size)
        decay = middle * (1 - 1e-11), middle * (1 + 1e-11)
    return ResponseMode(pole, factors, real, decay, sizes, discrete)


def _poles(denominator: Polynomial) -> list[tuple[ComplexBall, int]]:
    """The poles that are not zero, each with its multiplicity."""
    held = []
    for factor, multiplicity in square_free_factors(denominator):
        disks, places = root_disks(factor, SHARP)
        for (re, im), radius in disks:
            held.append((ComplexBall(re, im, -places, math.ceil(Fraction(radius) * 2**places) + 1), multiplicity))
    return held


def _series(
    numerator: Polynomial, pole: ComplexBall, others: list[tuple[ComplexBall, int]], count: int, unit: ComplexBall
) -> list[ComplexBall]:
    """The first coefficients at a pole of numerator / product of (s - other)^multiplicity, times `unit`."""
    result = [unit * term for term in _expand(numerator, pole, count)]
    for other, multiplicity in others:
        inverse = (pole - other).inverse()
        power = ONE
        for _ in range(multiplicity):
            power = power * inverse
        part, terms = power, []  # of (a + x)^-m = a^-m sum C(m + k - 1, k) (-x / a)^k
        for k in range(count):
            terms.append(part * ComplexBall(math.comb(multiplicity + k - 1, k), 0, 0, 0))
            part = -(part * inverse)
        result = _product(result, terms)
    return result


def _expand(p: Polynomial, at: ComplexBall, count: int) -> list[ComplexBall]:
    """The coefficients of p about a point, by repeated division."""
    rest = [ComplexBall.of(a) for a in reversed(p)]
    found = []
    for _ in range(count):
        total, sums = ZERO, []
        for a in rest:
            total = total * at + a
            sums.append(total)
        found.append(total)
        rest = sums[:-1]
    return found


def _product(p: list[ComplexBall], q: list[ComplexBall]) -> list[ComplexBall]:
    result = []
    for k in range(len(p)):
        total = ZERO
        for i in range(k + 1):
            total = total + p[i] * q[k - i]
        result.append(total)
    return result

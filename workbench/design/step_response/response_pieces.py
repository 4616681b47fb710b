"""A response in continuous time by pieces: a polynomial over each span of time, and a bound of what it leaves out.

A mode that turns or decays within the span has no polynomial there: it counts with its envelope. Where that is too
much to answer a question, the span is halved.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from fractions import Fraction

from workbench.design.frequency.integer_polynomials import Polynomial
from workbench.design.matrices import DesignError
from workbench.design.step_response.complex_balls import ComplexBall
from workbench.design.step_response.response_modes import ResponseModes

PLACES = 240  # binary places of a coefficient
UNIT = 1 << PLACES
TERMS = 40  # of a series of exp(q u), |q| <= 1: 1 / 40! is 1e-48
QUIET = 2.0**-70  # of the final value: what no longer counts
SILENT = 2.0**-100  # of the final value: a mode that counts with its envelope, however slow it is
MOST_PIECES = 10_000  # some ten seconds


@dataclass(frozen=True)
class ResponsePiece:
    """The response over `start` + 2^exponent u, 0 <= u <= 1, as a polynomial of u in units of 2^-PLACES.

    It is off by no more than `error`, and its slope by u by no more than `slope_error`, in the same units.
    """

    start: Fraction
    exponent: int
    polynomial: Polynomial
    error: int
    slope_error: int

    @property
    def is_resolved(self) -> bool:
        """True if the error no longer counts."""
        return self.error <= 2 * QUIET * UNIT

    @property
    def range(self) -> tuple[int, int]:
        """Bounds of the response from below and above, not the narrowest ones."""
        spread = sum(map(abs, self.polynomial[1:])) + self.error
        return self.polynomial[0] - spread, self.polynomial[0] + spread

    def time(self, u: Fraction) -> Fraction:
        """The time in s at a place of the piece."""
        return self.start + u * Fraction(2) ** self.exponent


@dataclass(frozen=True, eq=False)
class ResponsePieces:
    """The pieces of a response with one or more modes, made as they are asked for."""

    response: ResponseModes
    speeds: tuple[float, ...]  # |p| in 1/s from above, one for each mode
    cache: dict[tuple[Fraction, int], ResponsePiece] = field(default_factory=dict)
    tables: dict[tuple[int, int], list[tuple[int, int, int]]] = field(default_factory=dict)

    @staticmethod
    def of(response: ResponseModes) -> ResponsePieces:
        """The pieces of these modes."""
        return ResponsePieces(response, tuple(math.exp(mode.pole.logarithm()) for mode in response.modes))

    @property
    def longest(self) -> int:
        """The exponent of the longest piece, in which the slowest mode turns by no more than one radian."""
        return -math.ceil(math.log2(min(self.speeds) * (1 + 1e-9)))

    def spans(
        self, relevant: Callable[[ResponsePiece], bool], first: int = 0, step: int = 1
    ) -> Iterator[tuple[float, list[ResponsePiece]]]:
        """The later end, or with `step` = -1 the earlier one, of each long span in turn, and its relevant pieces."""
        k, long = first, Fraction(2) ** self.longest
        while k >= 0:
            pieces = list(self._halves(k * long, self.longest, relevant, step))
            yield float((k + (step > 0)) * long), pieces
            k += step

    def around(self, t: float, relevant: Callable[[ResponsePiece], bool]) -> ResponsePiece | None:
        """The resolved piece that holds a time in s, or None if it, or a longer one about it, is not relevant."""
        exponent = self.longest
        while True:
            length = Fraction(2) ** exponent
            piece = self.piece(int(Fraction(t) / length) * length, exponent)
            if not relevant(piece) or piece.is_resolved:
                return piece if relevant(piece) else None
            exponent -= 1

    def _halves(
        self, start: Fraction, exponent: int, relevant: Callable[[ResponsePiece], bool], step: int
    ) -> Iterator[ResponsePiece]:
        """The resolved pieces of a span that are relevant, in the order of time or against it."""
        piece = self.piece(start, exponent)
        if not relevant(piece):
            return
        if piece.is_resolved:
            yield piece
            return
        for half in (0, 1)[::step]:
            yield from self._halves(start + half * Fraction(2) ** (exponent - 1), exponent - 1, relevant, step)

    def piece(self, start: Fraction, exponent: int) -> ResponsePiece:
        """The piece from a time in s on."""
        key = (start, exponent)
        if key not in self.cache:
            if len(self.cache) >= MOST_PIECES:
                raise DesignError(
                    f"`step_info(system)` looks at up to {MOST_PIECES} pieces of a response, and this one turns more "
                    "often before it settles; leave out its fast or weak modes, by `wb.reduction` say."
                )
            self.cache[key] = self._piece(start, exponent)
        return self.cache[key]

    def _piece(self, start: Fraction, exponent: int) -> ResponsePiece:
        top = TERMS + max(len(mode.factors) for mode in self.response.modes)
        total = [0] * top
        total[0] = _fixed_fraction(self.response.final)
        error, slope_error = 2, 0
        length, t = 2.0**exponent, float(start)
        for i, mode in enumerate(self.response.modes):
            noise = mode.envelope(t)
            if self.speeds[i] * length > 1 or noise < SILENT:
                error += _up(noise)
                slope_error += _up((self.speeds[i] * noise + mode.envelope(t, 1)) * length)
                continue
            doubt, slope_doubt = self._add(i, start, exponent, total)
            error, slope_error = error + doubt, slope_error + slope_doubt
        if all(speed * length <= 1 for speed in self.speeds) and error > 2 * QUIET * UNIT:
            raise DesignError(
                "`step_info(system)`: modes of this system cancel each other to so many digits that its response "
                "cannot be enclosed; round its numbers, or take a system of lower order."
            )
        return ResponsePiece(start, exponent, total, error, slope_error)

    def _add(self, i: int, start: Fraction, exponent: int, total: list[int]) -> tuple[int, int]:
        """Add the series of a mode to a polynomial, and return its errors."""
        mode, table, top = self.response.modes[i], self._table(i, exponent), len(total)
        grown = (mode.pole * ComplexBall.of(start)).exponential()
        weights = _shifted_factors(mode.factors, start, exponent, grown)
        double, error, slope_error = 0 if mode.real else 1, 0, 0
        for k, weight in enumerate(weights):
            re, im, doubt = weight.to_fixed_point(PLACES)
            size = abs(re) + abs(im) + doubt
            for m in range(top - k):
                a, b, off = table[m]
                total[k + m] += (re * a - im * b) >> PLACES - double
                part = ((size * off + (abs(a) + abs(b) + off) * doubt) >> PLACES - double) + 3
                error += part
                slope_error += part * (k + m)
            error += (4 * size) // math.factorial(top - k) + 1
            slope_error += (8 * (k + 1) * size) // math.factorial(top - k - 1) + 1
        return error, slope_error

    def _table(self, i: int, exponent: int) -> list[tuple[int, int, int]]:
        """The numbers q^m / m! in units of 2^-PLACES, q = p 2^exponent."""
        if (i, exponent) not in self.tables:
            mode = self.response.modes[i]
            q, term, rows = mode.pole.scale_by_power(exponent), ComplexBall(1, 0, 0, 0), []
            for m in range(TERMS + max(len(one.factors) for one in self.response.modes)):
                rows.append(term.to_fixed_point(PLACES))
                term = (term * q).divide(m + 1)
            self.tables[i, exponent] = rows
        return self.tables[i, exponent]


def _shifted_factors(
    factors: tuple[ComplexBall, ...], start: Fraction, exponent: int, growth: ComplexBall
) -> list[ComplexBall]:
    """The factors of u^l in sum c_j (start + 2^exponent u)^(j-1) / (j-1)!, times exp(p start)."""
    at, found = ComplexBall.of(start), []
    for k in range(len(factors)):
        power, total = growth, ComplexBall(0, 0, 0, 0)
        for j in range(k, len(factors)):
            total = total + power * factors[j]
            power = (power * at).divide(j - k + 1)
        found.append(total.divide(math.factorial(k)).scale_by_power(k * exponent))
    return found


def _fixed_fraction(x: Fraction) -> int:
    return (x.numerator << PLACES) // x.denominator


def _up(x: float) -> int:
    """A number of units that is no smaller."""
    return math.ceil(Fraction(x) * UNIT) + 1

"""Complex numbers of many digits with a radius, within which the exact number lies."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

from workbench.design.matrices import DesignError

BITS = 320  # of a midpoint
HALVINGS = 24  # of an argument beyond its size, before the series of the exponential
TERMS = 20  # of that series: 2^-24 to the power of 20 is 2^-480


@dataclass(frozen=True, slots=True)
class ComplexBall:
    """All complex numbers within `radius` of re + j im, all three in units of 2^exponent."""

    re: int
    im: int
    exponent: int
    radius: int

    @staticmethod
    def of(x: Fraction | int) -> ComplexBall:
        """A rational number, rounded to the working precision."""
        x = Fraction(x)
        shift = BITS - x.numerator.bit_length() + x.denominator.bit_length()
        top = x.numerator << shift if shift > 0 else x.numerator
        bottom = x.denominator if shift > 0 else x.denominator << -shift
        return ComplexBall(top // bottom, 0, -shift, int(top % bottom != 0))

    def __add__(self, other: ComplexBall) -> ComplexBall:
        low, high = (self, other) if self.exponent <= other.exponent else (other, self)
        shift = high.exponent - low.exponent
        return _round_ball(
            low.re + (high.re << shift),
            low.im + (high.im << shift),
            low.exponent,
            low.radius + (high.radius << shift),
        )

    def __neg__(self) -> ComplexBall:
        return ComplexBall(-self.re, -self.im, self.exponent, self.radius)

    def __sub__(self, other: ComplexBall) -> ComplexBall:
        return self + -other

    def __mul__(self, other: ComplexBall) -> ComplexBall:
        size, far = abs(self.re) + abs(self.im), abs(other.re) + abs(other.im)
        return _round_ball(
            self.re * other.re - self.im * other.im,
            self.re * other.im + self.im * other.re,
            self.exponent + other.exponent,
            size * other.radius + self.radius * far + self.radius * other.radius,
        )

    def conjugate(self) -> ComplexBall:
        """The complex conjugate."""
        return ComplexBall(self.re, -self.im, self.exponent, self.radius)

    def scale_by_power(self, times: int) -> ComplexBall:
        """The ball times 2^times."""
        return ComplexBall(self.re, self.im, self.exponent + times, self.radius)

    def divide(self, count: int) -> ComplexBall:
        """The ball over a positive whole number."""
        return ComplexBall(self.re // count, self.im // count, self.exponent, self.radius // count + 3)

    def inverse(self) -> ComplexBall:
        """The inverse; refused where the ball holds zero."""
        square = self.re**2 + self.im**2
        least = math.isqrt(square)  # of the modulus, from below
        if least <= self.radius:
            raise DesignError("two poles are too near to each other to be told apart; round the numbers of the system.")
        shift = BITS + square.bit_length()
        scale = 1 << shift
        # |1/z - 1/w| <= radius / (|z| |w|)
        doubt = -(-self.radius * scale // (least * (least - self.radius))) + 2
        return _round_ball(self.re * scale // square, -self.im * scale // square, -shift - self.exponent, doubt)

    def exponential(self) -> ComplexBall:
        """The exponential, by a series of a small part of the argument and repeated squares."""
        size = max(abs(self.re), abs(self.im)).bit_length() + self.exponent
        halvings = max(0, size + HALVINGS)
        part = self.scale_by_power(-halvings)
        total = term = ONE
        for k in range(1, TERMS + 1):
            term = (term * part).divide(k)
            total = total + term
        # what is left out is less than the last term that is taken, as |part| < 2^-22
        total = ComplexBall(total.re, total.im, total.exponent, total.radius + _units(term, total.exponent))
        for _ in range(halvings):
            total = total * total
        return total

    def to_complex(self) -> complex:
        """The midpoint as a complex double; zero or infinite beyond the range of doubles."""
        spare = max(0, max(abs(self.re), abs(self.im)).bit_length() - 60)
        power = min(1100, max(-1200, self.exponent + spare))
        parts = [float(part >> spare) for part in (self.re, self.im)]
        re, im = (math.ldexp(part, power) if power < 960 else part * math.inf if part else 0.0 for part in parts)
        return complex(re, im)

    def logarithm(self) -> float:
        """The natural logarithm of the largest modulus in the ball, from above."""
        top = math.isqrt(self.re**2 + self.im**2) + 1 + self.radius
        spare = max(0, top.bit_length() - 60)
        return (math.log((top >> spare) + 1) + (spare + self.exponent) * math.log(2)) + 1e-12

    def to_fixed_point(self, places: int) -> tuple[int, int, int]:
        """The midpoint and the radius in units of 2^-places, the radius rounded up."""
        shift = self.exponent + places
        if shift >= 0:
            return self.re << shift, self.im << shift, self.radius << shift
        return self.re >> -shift, self.im >> -shift, (self.radius >> -shift) + 3


ONE = ComplexBall(1, 0, 0, 0)
ZERO = ComplexBall(0, 0, 0, 0)


def _units(ball: ComplexBall, exponent: int) -> int:
    """The largest modulus of a ball, in units of 2^exponent, from above."""
    top, shift = abs(ball.re) + abs(ball.im) + ball.radius, ball.exponent - exponent
    return top << shift if shift >= 0 else (top >> -shift) + 1


def _round_ball(re: int, im: int, exponent: int, radius: int) -> ComplexBall:
    spare = max(abs(re), abs(im), radius).bit_length() - BITS
    if spare <= 0:
        return ComplexBall(re, im, exponent, radius)
    return ComplexBall(re >> spare, im >> spare, exponent + spare, (radius >> spare) + 3)

"""Elementary functions that are made of the exponential, the logarithm and the root of a format, without a branch.

Each is written once, over the functions of double or of single precision.

References
----------
Sun Microsystems (1993), fdlibm: the formulas of the hyperbolic functions and their inverses.
Kahan (1987), Branch cuts for complex elementary functions: log(1 + x) by what 1 + x lacks.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

from workbench.engine.machines.elementary_functions import (
    INFINITY,
    LOG2_E,
    NAN,
    ROUND,
    exponential,
    logarithm,
    polynomial,
)
from workbench.engine.machines.elementary_functions import LN_2 as PARTS_OF_LN_2
from workbench.engine.machines.machine import MachineNumber, MachineWord, Value, fma, number, select

LN_2 = 0.6931471805599453
EXPM1 = (
    -2.01099218183624371326e-07,
    4.00821782732936239552e-06,
    -7.93650757867487942473e-05,
    1.58730158725481460165e-03,
    -3.33333333333331316428e-02,
    1.0,
)


def reduce_exponent(x: MachineNumber[Value]) -> tuple[MachineNumber[Value], MachineNumber[Value], MachineWord[Value]]:
    """Of x = n ln 2 + r in double precision: r, e^r - 1 - r, and a word whose last bits are n."""
    shifted = fma(x, LOG2_E, ROUND)
    minus = -(shifted - ROUND)
    high, low = fma(minus, PARTS_OF_LN_2[0], x), minus * PARTS_OF_LN_2[1]
    r = high + low
    excess = (r - high) - low  # of the rounded r
    half, square = r * 0.5, r * r * 0.5
    even = polynomial(square, EXPM1)
    odd = 3.0 - even * half
    e = square * ((even - odd) / (6.0 - r * odd))
    return r, square - (r * (e + excess) + excess), shifted.bits


class OfOne(Protocol):
    """A function of one number of any machine."""

    def __call__(self, x: MachineNumber[Value], /) -> MachineNumber[Value]: ...  # noqa: D102


class Reduction(Protocol):
    """A function from a number of any machine to its rest, what that makes of e, and a word with the exponent."""

    def __call__(  # noqa: D102
        self, x: MachineNumber[Value], /
    ) -> tuple[MachineNumber[Value], MachineNumber[Value], MachineWord[Value]]: ...


@dataclass(frozen=True)
class Format:
    """A format of numbers and its functions.

    Attributes
    ----------
    reduce
        Of x = n ln 2 + r: r, e^r - 1 - r, and a word whose last bits are the whole number n.
    most
        The largest x of which e^x is finite in the format's exponential.
    beyond
        A number above which sinh x is infinite.
    edge
        The number from which e^-x is nothing beside e^x.
    """

    exponential: OfOne
    logarithm: OfOne
    reduce: Reduction
    digits: int  # behind the point of the mantissa
    bias: int
    least: float
    most: float
    beyond: float
    edge: float

    def power(self, exponent: MachineWord[Value], less: int = 0) -> MachineNumber[Value]:
        """2^(n - less) of a word whose last bits are n."""
        return ((exponent + (self.bias - less)) << self.digits).number

    def exponential_less_one(self, x: MachineNumber[Value]) -> MachineNumber[Value]:
        """e^x - 1 = 2^n (e^r - 1) + (2^n - 1), where e^r - 1 is r and a smaller rest; infinite where e^x is."""
        r, rest, exponent = self.reduce(select(x < self.least, self.least, select(x > self.most, self.most, x)))
        power = self.power(exponent)
        cancels = power.compare("eq", 2.0) & (r < -0.25)
        result = select(cancels, ((r + 0.5) + rest) * 2.0, fma(r + rest, power, power - 1.0))
        result = select(abs(x) < 2.0 ** -(self.digits + 2), x, result)
        return select(x > self.most, INFINITY, result)

    def logarithm_of_one_more(self, x: MachineNumber[Value]) -> MachineNumber[Value]:
        """log(1 + x) = log u + (x - (u - 1)) / u with the rounded u = 1 + x; NaN below -1."""
        u = x + 1.0
        result = self.logarithm(u) + (x - (u - 1.0)) / u
        result = select(u.compare("eq", 0.0), -INFINITY, result)
        small_or_infinite = (abs(x) < 2.0 ** -(self.digits + 2)) | x.compare("eq", INFINITY)
        return select(small_or_infinite, x, result)

    def _half_exponential(self, size: MachineNumber[Value]) -> MachineNumber[Value]:
        """e^x / 2 of a size x; finite up to the largest number."""
        r, rest, exponent = self.reduce(select(size > self.beyond, self.beyond, size))
        return ((r + rest) + 1.0) * self.power(exponent, 3) * 4.0

    def hyperbolic_sine(self, x: MachineNumber[Value]) -> MachineNumber[Value]:
        """sinh x = (E + E / (E + 1)) / 2 with E = e^|x| - 1."""
        size = abs(x)
        less = self.exponential_less_one(size)
        near = (less + less / (less + 1.0)) * 0.5
        return select(size < self.edge, near, self._half_exponential(size)).do("copysign", x)

    def hyperbolic_cosine(self, x: MachineNumber[Value]) -> MachineNumber[Value]:
        """cosh x = e^|x| / 2 + 1 / (2 e^|x|)."""
        size = abs(x)
        of_size = self.exponential(size)
        near = of_size * 0.5 + 0.5 / of_size
        return select(size < self.edge, near, self._half_exponential(size))

    def inverse_hyperbolic_sine(self, x: MachineNumber[Value]) -> MachineNumber[Value]:
        """asinh x = log1p(|x| + x^2 / (1 + sqrt(1 + x^2))) with the sign of x."""
        size, square = abs(x), x * x
        near = self.logarithm_of_one_more(size + square / ((square + 1.0).do("sqrt") + 1.0))
        far = self.logarithm(size) + LN_2
        return select(size > self._large, far, near).do("copysign", x)

    def inverse_hyperbolic_cosine(self, x: MachineNumber[Value]) -> MachineNumber[Value]:
        """acosh x = log1p(t + sqrt(t (t + 2))) with t = x - 1; NaN below 1."""
        t = x - 1.0
        near = self.logarithm_of_one_more(t + (t * (t + 2.0)).do("sqrt"))
        result = select(x > self._large, self.logarithm(x) + LN_2, near)
        return select(x >= 1.0, result, NAN)

    def inverse_hyperbolic_tangent(self, x: MachineNumber[Value]) -> MachineNumber[Value]:
        """atanh x = log1p(2 |x| / (1 - |x|)) / 2 with the sign of x; infinite at 1, NaN beyond."""
        size = abs(x)
        return (self.logarithm_of_one_more((size + size) / (1.0 - size)) * 0.5).do("copysign", x)

    @property
    def _large(self) -> float:
        """A size beyond which 1 is nothing beside its square."""
        return float(2.0 ** (self.digits // 2 + 2))

    def hypotenuse(self, x: MachineNumber[Value], y: MachineNumber[Value]) -> MachineNumber[Value]:
        """sqrt(x^2 + y^2) of sides that are scaled where a square would be lost; infinite if one side is."""
        width, height = abs(x), abs(y)
        largest = select(width > height, width, height)
        far, down, up = 2.0 ** (self.bias // 2 - 8), 2.0 ** -(self.bias // 2 + 8), 2.0 ** (self.bias - 23)
        long, short = largest > far, largest < 1.0 / far
        scale, back = select(long, down, select(short, up, 1.0)), select(long, 1.0 / down, select(short, 1.0 / up, 1.0))
        a, b = x * scale, y * scale
        result = fma(a, a, b * b).do("sqrt") * back
        infinite = width.compare("eq", INFINITY) | height.compare("eq", INFINITY)
        return select(infinite, number(x.machine, INFINITY), result)

    @property
    def functions(self) -> Mapping[str, Callable[..., object]]:
        """All of them, by the names that they have in C."""
        return {
            "expm1": self.exponential_less_one,
            "log1p": self.logarithm_of_one_more,
            "sinh": self.hyperbolic_sine,
            "cosh": self.hyperbolic_cosine,
            "asinh": self.inverse_hyperbolic_sine,
            "acosh": self.inverse_hyperbolic_cosine,
            "atanh": self.inverse_hyperbolic_tangent,
            "hypot": self.hypotenuse,
        }


DOUBLE = Format(exponential, logarithm, reduce_exponent, 52, 1023, -708.0, 709.0, 711.0, 22.0)

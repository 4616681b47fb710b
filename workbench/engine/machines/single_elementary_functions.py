"""Elementary functions in single precision without a branch or a call, over the operations of a machine with words of
32 bits.

References
----------
Moshier (1992), Cephes Mathematical Library, release 2.2, single precision: the coefficients of sinf.c, expf.c, logf.c,
tanhf.c and atanf.c.
Cody and Waite (1980), Software Manual for the Elementary Functions: the reduction of an angle by parts of pi / 2.
Dekker (1971), A floating-point technique for extending the available precision, Numerische Mathematik 18: `remainder`.
"""

from __future__ import annotations

from workbench.engine.machines.elementary_functions import (
    INFINITY,
    NAN,
    Angle,
    polynomial,
)
from workbench.engine.machines.further_elementary_functions import Format
from workbench.engine.machines.machine import MachineNumber, MachineWord, Value, number, select

# pi / 2 in parts of 11 bits and a rest: k < 2^13 times such a part is exact, and so is what is left near its multiples.
HALF_PI = (
    1.5703125,
    0.0004837512969970703,
    7.549533620476723e-08,
    2.5632829192545614e-12,
    6.123234262925839e-17,
)
TWO_OVER_PI = 0.6366197723675814
ROUND = 12582912.0  # 1.5 * 2^23: adding it leaves the nearest whole number in the last bits
LARGEST_ANGLE = 8192.0  # rad: beyond it these parts are no longer enough, and the answer is NaN
SINE = (-1.9515295891e-4, 8.3321608736e-3, -1.6666654611e-1)
COSINE = (2.443315711809948e-5, -1.388731625493765e-3, 4.166664568298827e-2)


def reduce_angle(x: MachineNumber[Value]) -> Angle[Value]:
    """The quadrant of x, and sine and cosine of its rest within pi / 4 of a multiple of pi / 2."""
    shifted = x * TWO_OVER_PI + ROUND
    turns, r = shifted - ROUND, x
    for part in HALF_PI:
        r = r - turns * part
    r = select(abs(x) <= LARGEST_ANGLE, r, NAN)
    square = r * r
    sine = square * r * polynomial(square, SINE) + r
    cosine = square * square * polynomial(square, COSINE) + (square * -0.5 + 1.0)
    quadrant = shifted.bits
    return Angle(quadrant, (quadrant & 1).nonzero, sine, cosine)


def sine_or_cosine(angle: Angle[Value], quarter: int) -> MachineNumber[Value]:
    """The sine (quarter 0) or cosine (quarter 1) from a reduced angle: cos x is sin (x + pi / 2)."""
    sizes = (angle.cosine, angle.sine) if quarter == 0 else (angle.sine, angle.cosine)
    turned = angle.quadrant + 1 if quarter else angle.quadrant
    return (select(angle.odd, *sizes).bits ^ ((turned << 30) & 2**31)).number


EXP = (1.9875691500e-4, 1.3981999507e-3, 8.3334519073e-3, 4.1665795894e-2, 1.6666665459e-1, 5.0000001201e-1)
LOG2_E = 1.4426950408889634
LN_2 = (0.693359375, -2.12194440e-4)
LEAST_EXPONENT, MOST_EXPONENT = -87.0, 88.0


def reduce_exponent(x: MachineNumber[Value]) -> tuple[MachineNumber[Value], MachineNumber[Value], MachineWord[Value]]:
    """Of x = n ln 2 + r: r, e^r - 1 - r = r^2 P(r), and a word whose last bits are n."""
    shifted = x * LOG2_E + ROUND
    turns = shifted - ROUND
    r = (x - turns * LN_2[0]) - turns * LN_2[1]
    return r, r * r * polynomial(r, EXP), shifted.bits


def exponential(x: MachineNumber[Value]) -> MachineNumber[Value]:
    """exp x; 0 below -87, infinite above 88."""
    bounded = select(x < LEAST_EXPONENT, LEAST_EXPONENT, x)
    bounded = select(bounded > MOST_EXPONENT, MOST_EXPONENT, bounded)
    r, rest, exponent = reduce_exponent(bounded)
    result = ((rest + r) + 1.0) * ((exponent + 127) << 23).number
    return select(x < LEAST_EXPONENT, 0.0, select(x > MOST_EXPONENT, INFINITY, result))


TANH = (-5.70498872745e-3, 2.06390887954e-2, -5.37397155531e-2, 1.33314422036e-1, -3.33332819422e-1)


def hyperbolic_tangent(x: MachineNumber[Value]) -> MachineNumber[Value]:
    """tanh x: a polynomial near zero, from the exponential elsewhere."""
    square, size = x * x, abs(x)
    near = square * x * polynomial(square, TANH) + x
    far = 1.0 - 2.0 / (exponential(size + size) + 1.0)
    return select(size < 0.625, near, far.do("copysign", x))


ATAN = (8.05374449538e-2, -1.38776856032e-1, 1.99777106478e-1, -3.33329491539e-1)
FOLD = 0.4142135623730950  # tan(pi / 8)
PI = (3.1415927410125732, -8.742278000372485e-08)  # and what its float has too much


def arc_tangent(y: MachineNumber[Value], x: MachineNumber[Value]) -> MachineNumber[Value]:
    """atan2(y, x): the smaller side over the larger one, folded at pi / 8 once more; then octant by octant."""
    height, width, one = abs(y), abs(x), number(x.machine, 1.0)
    steep = height > width
    large, small = select(steep, height, width), select(steep, width, height)
    a = select(large.compare("eq", 0.0), 0.0, small / large)
    a = select(small.compare("eq", INFINITY), one, a)
    high = a > FOLD
    r = select(high, (a - one) / (a + one), a)
    square = r * r
    angle = square * r * polynomial(square, ATAN) + r

    def beyond(share: float, of: MachineNumber[Value]) -> MachineNumber[Value]:
        return number(x.machine, PI[0] * share) + (of + PI[1] * share)

    angle = select(high, beyond(0.25, angle), angle)
    angle = select(steep, beyond(0.5, -angle), angle)
    back = one.do("copysign", x) < 0.0  # minus zero is behind too
    angle = select(back, beyond(1.0, -angle), angle)
    lost = x.compare("ne", x) | y.compare("ne", y)
    return select(lost, NAN, angle.do("copysign", y))


MOST_TURNS = 2.0**23
SPLITTER = 2.0**12 + 1


def remainder(x: MachineNumber[Value], y: MachineNumber[Value]) -> MachineNumber[Value]:
    """x - trunc(x / y) y with the sign of x, exact; NaN where the quotient is 2^23 or more."""
    size, turns = abs(y), (x / y).do("trunc")
    rest = _rest(x, turns, y)
    signed = size.do("copysign", x)
    beyond = rest * number(x.machine, 1.0).do("copysign", x) < 0.0
    rest = select(beyond, rest + signed, rest)
    short = abs(rest) >= size
    rest = select(short, rest - signed, rest).do("copysign", x)
    rest = select(abs(turns) < MOST_TURNS, rest, NAN)
    return select(abs(x) < size, x, rest)


def _halves(x: MachineNumber[Value]) -> tuple[MachineNumber[Value], MachineNumber[Value]]:
    """Two numbers of 12 digits whose sum is x (Veltkamp)."""
    large = x * SPLITTER
    high = large - (large - x)
    return high, x - high


def _rest(x: MachineNumber[Value], turns: MachineNumber[Value], y: MachineNumber[Value]) -> MachineNumber[Value]:
    """x - turns y, exact by the error of the rounded product; large numbers are scaled, so that no half overflows."""
    large = abs(x) > 2.0**100
    scale, back = select(large, 2.0**-30, 1.0), select(large, 2.0**30, 1.0)
    x, y = x * scale, y * scale
    product = turns * y
    (a, b), (c, d) = _halves(turns), _halves(y)
    rest: MachineNumber[Value] = (x - product) - ((a * c - product) + a * d + b * c + b * d)
    return rest * back


LOG = (
    7.0376836292e-2,
    -1.1514610310e-1,
    1.1676998740e-1,
    -1.2420140846e-1,
    1.4249322787e-1,
    -1.6668057665e-1,
    2.0000714765e-1,
    -2.4999993993e-1,
    3.3333331174e-1,
)
ROOT_HALF = 0.7071067811865476
SMALLEST_NORMAL = 2.0**-126


def logarithm(x: MachineNumber[Value]) -> MachineNumber[Value]:
    """log x from mantissa and exponent; NaN below zero, minus infinity at zero."""
    tiny = x < SMALLEST_NORMAL  # its bits hold no mantissa of 24 digits: 2^25 x does
    bits = select(tiny, x * 2.0**25, x).bits
    m = ((bits & 0x007FFFFF) | 0x3F000000).number
    n = ((bits >> 23) + -126).as_signed
    n = select(tiny, n - 25.0, n)
    low = m < ROOT_HALF
    n = select(low, n - 1.0, n)
    m = select(low, m + m, m) - 1.0
    square = m * m
    tail = n * LN_2[1] + m * (square * polynomial(m, LOG))
    result = n * LN_2[0] + (m + (square * -0.5 + tail))
    result = select(x.compare("eq", INFINITY), x, result)
    result = select(x.compare("eq", 0.0), -INFINITY, result)
    return select(x >= 0.0, result, NAN)


SINGLE = Format(exponential, logarithm, reduce_exponent, 23, 127, LEAST_EXPONENT, MOST_EXPONENT, 90.0, 9.0)

"""Elementary functions without a branch or a call, over the operations of a machine.

Each is a polynomial or a rational function on a reduced argument. The coefficients are those of the
Cephes library (Moshier, 1989) and of fdlibm (Sun Microsystems, 1993), the reductions are theirs too.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Generic, NamedTuple, Protocol, Self, TypeVar

from workbench.engine.machines.machine import MachineNumber, MachineTruth, MachineWord, Value, fma, number, select

NAN, INFINITY = float("nan"), float("inf")


def smaller(a: MachineNumber[Value], b: MachineNumber[Value]) -> MachineNumber[Value]:
    """The smaller of two numbers; of a number and NaN the number, of two zeros the first."""
    return select(b.compare("ne", b), a, select(a <= b, a, b))


def larger(a: MachineNumber[Value], b: MachineNumber[Value]) -> MachineNumber[Value]:
    """The larger of two numbers; of a number and NaN the number, of two zeros the first."""
    return select(b.compare("ne", b), a, select(a >= b, a, b))


def sign(x: MachineNumber[Value]) -> MachineNumber[Value]:
    """-1, 1, or x itself where it is zero or NaN."""
    return select(x > 0.0, 1.0, select(x < 0.0, -1.0, x))


def polynomial(x: MachineNumber[Value], coefficients: Sequence[float]) -> MachineNumber[Value]:
    """The value of a polynomial by Horner's rule, highest power first."""
    result = fma(x, coefficients[0], coefficients[1])
    for coefficient in coefficients[2:]:
        result = fma(result, x, coefficient)
    return result


# pi / 2 and what its double lacks: fma makes exact use of all bits, so k times the first part leaves no error.
FUSED_HALF_PI = (1.5707963267948966, 6.123233995736766e-17)
# The same in parts of 13 bits and a rest: without fma, k < 2^40 times such a part is exact, and so is what is left.
SHORT_HALF_PI = (
    1.570556640625,
    0.0002396702766418457,
    1.5890691429376602e-08,
    2.5632829192545614e-12,
    6.123233995736766e-17,
)
TWO_OVER_PI = 6.36619772367581382433e-01
ROUND = 6755399441055744.0  # 1.5 * 2^52: adding it leaves the nearest whole number in the last bits
LARGEST_ANGLE = 1e12  # rad: beyond it what these parts lack of pi / 2 begins to count, and the answer is NaN
SINE = (
    1.58969099521155010221e-10,
    -2.50507602534068634195e-08,
    2.75573137070700676789e-06,
    -1.98412698298579493134e-04,
    8.33333333332248946124e-03,
    -1.66666666666666324348e-01,
)
COSINE = (
    -1.13596475577881948265e-11,
    2.08757232129817482790e-09,
    -2.75573143513906633035e-07,
    2.48015872894767294178e-05,
    -1.38888888888741095749e-03,
    4.16666666666666019037e-02,
)


class Angle(NamedTuple, Generic[Value]):
    """A reduced angle: its quadrant as a word, True if that is odd, and sine and cosine of the remainder."""

    quadrant: MachineWord[Value]
    odd: MachineTruth[Value]
    sine: MachineNumber[Value]
    cosine: MachineNumber[Value]


def reduce_angle(x: MachineNumber[Value]) -> Angle[Value]:
    """The quadrant of x, and sine and cosine of its rest within pi / 4 of a multiple of pi / 2."""
    shifted = fma(x, TWO_OVER_PI, ROUND)
    turns = shifted - ROUND
    minus, r = -turns, x
    for part in FUSED_HALF_PI if x.machine.fused_products else SHORT_HALF_PI:
        r = fma(minus, part, r)
    r = select(abs(x) <= LARGEST_ANGLE, r, NAN)
    square = r * r
    sine = fma(square * r, polynomial(square, SINE), r)
    head = fma(square, -0.5, 1.0)
    cosine = fma(square * square, polynomial(square, COSINE), head)
    quadrant = shifted.bits
    return Angle(quadrant, (quadrant & 1).nonzero, sine, cosine)


def sine_or_cosine(angle: Angle[Value], quarter: int) -> MachineNumber[Value]:
    """The sine (quarter 0) or cosine (quarter 1) from a reduced angle: cos x is sin (x + pi / 2)."""
    sizes = (angle.cosine, angle.sine) if quarter == 0 else (angle.sine, angle.cosine)
    turned = angle.quadrant + 1 if quarter else angle.quadrant
    return (select(angle.odd, *sizes).bits ^ ((turned << 62) & 2**63)).number


EXP_P = (1.26177193074810590878e-4, 3.02994407707441961300e-2, 9.99999999999999999910e-1)
EXP_Q = (3.00198505138664455042e-6, 2.52448340349684104192e-3, 2.27265548208155028766e-1, 2.0)
LOG2_E = 1.4426950408889634073599
LN_2 = (6.93145751953125e-1, 1.42860682030941723212e-6)


def exponential(x: MachineNumber[Value]) -> MachineNumber[Value]:
    """exp x: 2^n (1 + 2 r P(r^2) / (Q(r^2) - r P(r^2))) with r = x - n ln 2; 0 below -708, infinite above 709."""
    bounded = select(x < -708.0, -708.0, x)
    bounded = select(bounded > 709.0, 709.0, bounded)
    shifted = fma(bounded, LOG2_E, ROUND)
    minus = -(shifted - ROUND)
    r = fma(minus, LN_2[1], fma(minus, LN_2[0], bounded))
    square = r * r
    numerator = r * polynomial(square, EXP_P)
    ratio = numerator / (polynomial(square, EXP_Q) - numerator)
    size = fma(ratio, 2.0, 1.0)
    result = size * ((shifted.bits + 1023) << 52).number
    return select(x < -708.0, 0.0, select(x > 709.0, INFINITY, result))


TANH_P = (-9.64399179425052238628e-1, -9.92877231001918586564e1, -1.61468768441708447952e3)
TANH_Q = (1.0, 1.12811678491632931402e2, 2.23548839060100448583e3, 4.84406305325125486048e3)


def hyperbolic_tangent(x: MachineNumber[Value]) -> MachineNumber[Value]:
    """tanh x: rational near zero, from the exponential elsewhere."""
    square, size = x * x, abs(x)
    ratio = polynomial(square, TANH_P) / polynomial(square, TANH_Q)
    near = fma(x * square, ratio, x)
    far = 1.0 - 2.0 / (exponential(size + size) + 1.0)
    return select(size < 0.625, near, far.do("copysign", x))


ATAN_P = (
    -8.750608600031904122785e-1,
    -1.615753718733365076637e1,
    -7.500855792314704667340e1,
    -1.228866684490136173410e2,
    -6.485021904942025371773e1,
)
ATAN_Q = (
    1.0,
    2.485846490142306297962e1,
    1.650270098316988542046e2,
    4.328810604912902668951e2,
    4.853903996359136964868e2,
    1.945506571482613964425e2,
)
PI = (3.141592653589793, 1.2246467991473532e-16)  # and what its double lacks


def arc_tangent(y: MachineNumber[Value], x: MachineNumber[Value]) -> MachineNumber[Value]:
    """atan2(y, x): the smaller side over the larger one, folded at 0.66 once more; then octant by octant."""
    height, width, one = abs(y), abs(x), number(x.machine, 1.0)
    steep = height > width
    large, small = select(steep, height, width), select(steep, width, height)
    a = select(large.compare("eq", 0.0), 0.0, small / large)
    a = select(small.compare("eq", INFINITY), one, a)
    high = a > 0.66
    r = select(high, (a - one) / (a + one), a)
    square = r * r
    ratio = polynomial(square, ATAN_P) / polynomial(square, ATAN_Q)
    angle = fma(r * square, ratio, r)

    def beyond(share: float, of: MachineNumber[Value]) -> MachineNumber[Value]:
        return number(x.machine, PI[0] * share) + (of + PI[1] * share)

    angle = select(high, beyond(0.25, angle), angle)
    angle = select(steep, beyond(0.5, -angle), angle)
    back = one.do("copysign", x) < 0.0  # minus zero is behind too
    angle = select(back, beyond(1.0, -angle), angle)
    lost = x.compare("ne", x) | y.compare("ne", y)
    return select(lost, NAN, angle.do("copysign", y))


def remainder(x: MachineNumber[Value], y: MachineNumber[Value]) -> MachineNumber[Value]:
    """x - trunc(x / y) y with the sign of x; the quotient may round to the next whole number. NaN from 2^52 on."""
    size, turns = abs(y), (x / y).do("trunc")
    rest = _rest(x, turns, y)
    signed = size.do("copysign", x)
    beyond = rest * number(x.machine, 1.0).do("copysign", x) < 0.0
    rest = select(beyond, rest + signed, rest)
    short = abs(rest) >= size
    rest = select(short, rest - signed, rest).do("copysign", x)
    rest = select(abs(turns) < 2.0**52, rest, NAN)
    return select(abs(x) < size, x, rest)


SPLITTER = 2.0**27 + 1


class Scalable(Protocol):
    """A number, or an array of them, that has a product with a constant and a difference."""

    def __mul__(self, other: float, /) -> Self: ...
    def __sub__(self, other: Self, /) -> Self: ...


Parts = TypeVar("Parts", bound=Scalable)


def halves(x: Parts) -> tuple[Parts, Parts]:
    """Two numbers of 26 digits whose sum is x, of a machine or of NumPy, up to 2^996 (Veltkamp)."""
    large = x * SPLITTER
    high = large - (large - x)
    return high, x - high


def _rest(x: MachineNumber[Value], turns: MachineNumber[Value], y: MachineNumber[Value]) -> MachineNumber[Value]:
    """x - turns y, exact: fused, or by the error of the rounded product (Dekker, Sterbenz) within a double's range."""
    if x.machine.fused_products:
        return fma(-turns, y, x)
    large, tiny = abs(x) > 2.0**900, abs(x) < 2.0**-900
    scale = select(large, 2.0**-200, select(tiny, 2.0**200, 1.0))
    back = select(large, 2.0**200, select(tiny, 2.0**-200, 1.0))
    x, y = x * scale, y * scale
    product = turns * y
    (a, b), (c, d) = halves(turns), halves(y)
    rest: MachineNumber[Value] = (x - product) - ((a * c - product) + a * d + b * c + b * d)
    return rest * back


LOG_P = (
    1.01875663804580931796e-4,
    4.97494994976747001425e-1,
    4.70579119878881725854e0,
    1.44989225341610930846e1,
    1.79368678507819816313e1,
    7.70838733755885391666e0,
)
LOG_Q = (
    1.0,
    1.12873587189167450590e1,
    4.52279145837532221105e1,
    8.29875266912776603211e1,
    7.11544750618563894466e1,
    2.31251620126765340583e1,
)
ROOT_HALF = 7.07106781186547524401e-1
SMALLEST_NORMAL = 2.2250738585072014e-308


def logarithm(x: MachineNumber[Value]) -> MachineNumber[Value]:
    """log x from mantissa and exponent; NaN below zero, minus infinity at zero."""
    tiny = x < SMALLEST_NORMAL  # its bits hold no mantissa of 53 digits: 2^54 x does
    bits = select(tiny, x * 2.0**54, x).bits
    m = ((bits & 0x000FFFFFFFFFFFFF) | 0x3FE0000000000000).number
    n = ((bits >> 52) + -1022).as_signed
    n = select(tiny, n - 54.0, n)
    low = m < ROOT_HALF
    n = select(low, n - 1.0, n)
    m = select(low, m + m, m) - 1.0
    square = m * m
    ratio = polynomial(m, LOG_P) / polynomial(m, LOG_Q)
    tail = fma(n, -2.121944400546905827679e-4, m * (square * ratio))
    tail = fma(square, -0.5, tail)
    result = fma(n, 0.693359375, m + tail)
    result = select(x.compare("eq", INFINITY), x, result)
    result = select(x.compare("eq", 0.0), -INFINITY, result)
    return select(x >= 0.0, result, NAN)

"""Elementary functions as straight lines of LLVM IR over vectors of doubles, without a branch or a call.

Each is a polynomial or a rational function on a reduced argument. The coefficients are those of the
Cephes library (Moshier, 1989) and of fdlibm (Sun Microsystems, 1993), the reductions are theirs too.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import NamedTuple, Protocol


class Writer(Protocol):
    """What writes a line of IR and names its value."""

    def line(self, text: str) -> str: ...  # noqa: D102
    def vector(self, value: float) -> str: ...  # noqa: D102
    @property
    def type(self) -> str: ...  # noqa: D102
    @property
    def integers(self) -> str: ...  # noqa: D102
    def whole(self, value: int) -> str: ...  # noqa: D102


def fma(w: Writer, a: str, b: str, c: str) -> str:
    """a b + c with one rounding."""
    return w.line(f"call {w.type} @llvm.fma.{mangled(w)}({w.type} {a}, {w.type} {b}, {w.type} {c})")


def mangled(w: Writer) -> str:
    """The vector type as it stands in the name of an intrinsic: v8f64."""
    return "v" + w.type[1:-1].replace(" x double", "f64")


def binary(w: Writer, op: str, a: str, b: str) -> str:
    """fadd, fsub, fmul or fdiv."""
    return w.line(f"{op} {w.type} {a}, {b}")


def negative(w: Writer, a: str) -> str:
    """Minus a."""
    return w.line(f"fneg {w.type} {a}")


def unary(w: Writer, intrinsic: str, a: str) -> str:
    """An intrinsic of one operand: fabs, sqrt, floor, trunc."""
    return w.line(f"call {w.type} @llvm.{intrinsic}.{mangled(w)}({w.type} {a})")


def smaller(w: Writer, a: str, b: str) -> str:
    """The smaller of two numbers, as C has it: of a number and NaN the number."""
    return w.line(f"call {w.type} @llvm.minnum.{mangled(w)}({w.type} {a}, {w.type} {b})")


def larger(w: Writer, a: str, b: str) -> str:
    """The larger of two numbers, as C has it: of a number and NaN the number."""
    return w.line(f"call {w.type} @llvm.maxnum.{mangled(w)}({w.type} {a}, {w.type} {b})")


def copysign(w: Writer, a: str, b: str) -> str:
    """The size of a with the sign of b."""
    return w.line(f"call {w.type} @llvm.copysign.{mangled(w)}({w.type} {a}, {w.type} {b})")


def compare(w: Writer, predicate: str, a: str, b: str) -> str:
    """A comparison: oeq, olt, ole, une, ..."""
    return w.line(f"fcmp {predicate} {w.type} {a}, {b}")


def select(w: Writer, condition: str, a: str, b: str) -> str:
    """A where the condition holds, b elsewhere."""
    return w.line(f"select {flags(w)} {condition}, {w.type} {a}, {w.type} {b}")


def flags(w: Writer) -> str:
    """The type of a vector of truths."""
    return w.type.replace("double", "i1")


def polynomial(w: Writer, x: str, coefficients: Sequence[float]) -> str:
    """By Horner's rule, highest power first."""
    result = w.vector(coefficients[0])
    for coefficient in coefficients[1:]:
        result = fma(w, result, x, w.vector(coefficient))
    return result


# pi / 2 and what its double lacks: fma makes exact use of all bits, so k times the first part leaves no error.
HALF_PI = (1.5707963267948966, 6.123233995736766e-17)
TWO_OVER_PI = 6.36619772367581382433e-01
ROUND = 6755399441055744.0  # 1.5 * 2^52: adding it leaves the nearest whole number in the last bits
LARGEST_ANGLE = 1e12  # rad: beyond it what these two parts lack of pi / 2 begins to count, and the answer is NaN
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


class Angle(NamedTuple):
    """A reduced angle: its quadrant as an integer, whether that is odd, and sine and cosine of what is left."""

    quadrant: str
    odd: str
    sine: str
    cosine: str


def reduce_angle(w: Writer, x: str) -> Angle:
    """The quadrant of x, and sine and cosine of its rest within pi / 4 of a multiple of pi / 2."""
    shifted = fma(w, x, w.vector(TWO_OVER_PI), w.vector(ROUND))
    quadrant = w.line(f"bitcast {w.type} {shifted} to {w.integers}")
    turns = binary(w, "fsub", shifted, w.vector(ROUND))
    minus, r = negative(w, turns), x
    for part in HALF_PI:
        r = fma(w, minus, w.vector(part), r)
    r = select(w, compare(w, "ole", unary(w, "fabs", x), w.vector(LARGEST_ANGLE)), r, w.vector(float("nan")))
    square = binary(w, "fmul", r, r)
    sine = fma(w, binary(w, "fmul", square, r), polynomial(w, square, SINE), r)
    head = fma(w, square, w.vector(-0.5), w.vector(1.0))
    fourth = binary(w, "fmul", square, square)
    cosine = fma(w, fourth, polynomial(w, square, COSINE), head)
    odd = w.line(f"icmp ne {w.integers} {w.line(f'and {w.integers} {quadrant}, {w.whole(1)}')}, {w.whole(0)}")
    return Angle(quadrant, odd, sine, cosine)


def sine_or_cosine(w: Writer, angle: Angle, quarter: int) -> str:
    """The sine (quarter 0) or cosine (quarter 1) from a reduced angle: cos x is sin (x + pi / 2)."""
    sizes = (angle.cosine, angle.sine) if quarter == 0 else (angle.sine, angle.cosine)
    bits = w.line(f"bitcast {w.type} {select(w, angle.odd, *sizes)} to {w.integers}")
    turned = w.line(f"add {w.integers} {angle.quadrant}, {w.whole(1)}") if quarter else angle.quadrant
    half = w.line(f"shl {w.integers} {turned}, {w.whole(62)}")
    sign = w.line(f"and {w.integers} {half}, {w.whole(-(2**63))}")
    return w.line(f"bitcast {w.integers} {w.line(f'xor {w.integers} {bits}, {sign}')} to {w.type}")


EXP_P = (1.26177193074810590878e-4, 3.02994407707441961300e-2, 9.99999999999999999910e-1)
EXP_Q = (3.00198505138664455042e-6, 2.52448340349684104192e-3, 2.27265548208155028766e-1, 2.0)
LOG2_E = 1.4426950408889634073599
LN_2 = (6.93145751953125e-1, 1.42860682030941723212e-6)


def exponential(w: Writer, x: str) -> str:
    """exp x: 2^n (1 + 2 r P(r^2) / (Q(r^2) - r P(r^2))) with r = x - n ln 2; 0 below -708, infinite above 709."""
    low, high = w.vector(-708.0), w.vector(709.0)
    bounded = select(w, compare(w, "olt", x, low), low, x)
    bounded = select(w, compare(w, "ogt", bounded, high), high, bounded)
    shifted = fma(w, bounded, w.vector(LOG2_E), w.vector(ROUND))
    n = binary(w, "fsub", shifted, w.vector(ROUND))
    minus = negative(w, n)
    r = fma(w, minus, w.vector(LN_2[1]), fma(w, minus, w.vector(LN_2[0]), bounded))
    square = binary(w, "fmul", r, r)
    numerator = binary(w, "fmul", r, polynomial(w, square, EXP_P))
    denominator = binary(w, "fsub", polynomial(w, square, EXP_Q), numerator)
    ratio = binary(w, "fdiv", numerator, denominator)
    size = fma(w, w.vector(2.0), ratio, w.vector(1.0))
    bits = w.line(f"bitcast {w.type} {shifted} to {w.integers}")
    power = w.line(f"shl {w.integers} {w.line(f'add {w.integers} {bits}, {w.whole(1023)}')}, {w.whole(52)}")
    result = binary(w, "fmul", size, w.line(f"bitcast {w.integers} {power} to {w.type}"))
    infinite = select(w, compare(w, "ogt", x, w.vector(709.0)), w.vector(float("inf")), result)
    return select(w, compare(w, "olt", x, w.vector(-708.0)), w.vector(0.0), infinite)


TANH_P = (-9.64399179425052238628e-1, -9.92877231001918586564e1, -1.61468768441708447952e3)
TANH_Q = (1.0, 1.12811678491632931402e2, 2.23548839060100448583e3, 4.84406305325125486048e3)


def hyperbolic_tangent(w: Writer, x: str) -> str:
    """tanh x: rational near zero, from the exponential elsewhere."""
    square = binary(w, "fmul", x, x)
    ratio = binary(w, "fdiv", polynomial(w, square, TANH_P), polynomial(w, square, TANH_Q))
    near = fma(w, binary(w, "fmul", x, square), ratio, x)
    size = unary(w, "fabs", x)
    grown = exponential(w, binary(w, "fadd", size, size))
    far = binary(w, "fdiv", w.vector(2.0), binary(w, "fadd", grown, w.vector(1.0)))
    far = binary(w, "fsub", w.vector(1.0), far)
    signed = copysign(w, far, x)
    return select(w, compare(w, "olt", size, w.vector(0.625)), near, signed)


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


def arc_tangent(w: Writer, y: str, x: str) -> str:
    """atan2(y, x): the smaller side over the larger one, folded at 0.66 once more; then octant by octant."""
    height, width, zero, one = unary(w, "fabs", y), unary(w, "fabs", x), w.vector(0.0), w.vector(1.0)
    steep = compare(w, "ogt", height, width)
    large, small = select(w, steep, height, width), select(w, steep, width, height)
    a = binary(w, "fdiv", small, large)
    a = select(w, compare(w, "oeq", large, zero), zero, a)
    a = select(w, compare(w, "oeq", small, w.vector(float("inf"))), one, a)
    high = compare(w, "ogt", a, w.vector(0.66))
    r = select(w, high, binary(w, "fdiv", binary(w, "fsub", a, one), binary(w, "fadd", a, one)), a)
    square = binary(w, "fmul", r, r)
    ratio = binary(w, "fdiv", polynomial(w, square, ATAN_P), polynomial(w, square, ATAN_Q))
    angle = fma(w, binary(w, "fmul", r, square), ratio, r)

    def beyond(share: float, of: str) -> str:
        rest = binary(w, "fadd", of, w.vector(PI[1] * share))
        return binary(w, "fadd", w.vector(PI[0] * share), rest)

    angle = select(w, high, beyond(0.25, angle), angle)
    angle = select(w, steep, beyond(0.5, negative(w, angle)), angle)
    back = compare(w, "olt", copysign(w, one, x), zero)  # minus zero is behind too
    angle = select(w, back, beyond(1.0, negative(w, angle)), angle)
    lost = compare(w, "uno", x, y)
    return select(w, lost, w.vector(float("nan")), copysign(w, angle, y))


def remainder(w: Writer, x: str, y: str) -> str:
    """x - trunc(x / y) y with the sign of x; the quotient may round to the next whole number. NaN from 2^52 on."""
    size, turns = unary(w, "fabs", y), unary(w, "trunc", binary(w, "fdiv", x, y))
    rest = fma(w, negative(w, turns), y, x)
    signed, zero = copysign(w, size, x), w.vector(0.0)
    beyond = compare(w, "olt", binary(w, "fmul", rest, copysign(w, w.vector(1.0), x)), zero)
    rest = select(w, beyond, binary(w, "fadd", rest, signed), rest)
    short = compare(w, "oge", unary(w, "fabs", rest), size)
    rest = copysign(w, select(w, short, binary(w, "fsub", rest, signed), rest), x)
    known = compare(w, "olt", unary(w, "fabs", turns), w.vector(2.0**52))
    rest = select(w, known, rest, w.vector(float("nan")))
    return select(w, compare(w, "olt", unary(w, "fabs", x), size), x, rest)


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


def logarithm(w: Writer, x: str) -> str:
    """log x from mantissa and exponent; NaN below zero, minus infinity at zero."""
    tiny = compare(w, "olt", x, w.vector(SMALLEST_NORMAL))  # its bits hold no mantissa of 53 digits: 2^54 x does
    given, x = x, select(w, tiny, binary(w, "fmul", x, w.vector(2.0**54)), x)
    bits = w.line(f"bitcast {w.type} {x} to {w.integers}")
    mantissa = w.line(f"and {w.integers} {bits}, {w.whole(0x000FFFFFFFFFFFFF)}")
    half = w.line(f"or {w.integers} {mantissa}, {w.whole(0x3FE0000000000000)}")
    m = w.line(f"bitcast {w.integers} {half} to {w.type}")
    biased = w.line(f"lshr {w.integers} {bits}, {w.whole(52)}")
    n = w.line(f"sitofp {w.integers} {w.line(f'sub {w.integers} {biased}, {w.whole(1022)}')} to {w.type}")
    n = select(w, tiny, binary(w, "fsub", n, w.vector(54.0)), n)
    low = compare(w, "olt", m, w.vector(ROOT_HALF))
    n = select(w, low, binary(w, "fsub", n, w.vector(1.0)), n)
    m = binary(w, "fsub", select(w, low, binary(w, "fadd", m, m), m), w.vector(1.0))
    square = binary(w, "fmul", m, m)
    ratio = binary(w, "fdiv", polynomial(w, m, LOG_P), polynomial(w, m, LOG_Q))
    tail = binary(w, "fmul", m, binary(w, "fmul", square, ratio))
    tail = fma(w, n, w.vector(-2.121944400546905827679e-4), tail)
    tail = fma(w, square, w.vector(-0.5), tail)
    result = fma(w, n, w.vector(0.693359375), binary(w, "fadd", m, tail))
    result = select(w, compare(w, "oeq", given, w.vector(float("inf"))), given, result)
    result = select(w, compare(w, "oeq", given, w.vector(0.0)), w.vector(float("-inf")), result)
    return select(w, compare(w, "oge", given, w.vector(0.0)), result, w.vector(float("nan")))


def literal(value: float) -> str:
    """A double as LLVM reads it to the last bit."""
    return f"0x{struct.unpack('<Q', struct.pack('<d', value))[0]:016X}"

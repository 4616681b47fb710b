"""A product and a sum with one rounding, from operations that round each: against fractions and the processor."""

import ctypes
import math
from fractions import Fraction

import numpy as np
import pytest

from workbench.engine.machines.numpy_spelling import fma

RNG = np.random.default_rng(1)
SPECIAL = [0.0, 1.0, math.inf, 5e-324, 1.7976931348623157e308, 2.2250738585072014e-308, 2.0**-537]
SPECIAL = np.array([*SPECIAL, *(-x for x in SPECIAL), math.nan])


def of_size(low, high, count):
    """Numbers of either sign with random bits and exponents."""
    return RNG.choice([-1.0, 1.0], count) * np.ldexp(1 + RNG.random(count), RNG.integers(low, high, count))


def cases(count):
    """Operands by what is hard about them."""
    bits = (RNG.integers(0, 2**64, count, dtype=np.uint64).view(float) for _ in range(3))
    a, b, c = (of_size(-60, 60, count) for _ in range(3))
    last_bits = 1 + RNG.integers(-3, 4, count) * 2.0**-52
    whole = (RNG.integers(-(2**27), 2**27, count).astype(float) for _ in range(2))
    odd = np.ldexp(2.0 * RNG.integers(1, 2**26, count) + 1, -53)
    hair, sign = 2.0 ** -RNG.integers(28, 53, count), RNG.choice([-1.0, 1.0], count)
    few = count // 30
    return {
        "any bits": tuple(bits),
        "alike in size": (a, b, c),
        "all but cancelled": (a, b, -(a * b) * last_bits),
        "half way between two doubles": (odd, np.ones(count), np.ldexp(of_size(0, 1, count), 52)),
        "a hair beside half way": (sign * (1 + hair), 1 - hair, 2.0**53 + 2.0 * RNG.integers(0, 2**20, count)),
        "short": (*whole, np.ldexp(RNG.integers(-(2**20), 2**20, count) + 0.0, RNG.integers(-5, 60, count))),
        "below the range": (of_size(-1074, -400, few), of_size(-600, 60, few), of_size(-1074, -1000, few)),
        "beyond the range": (of_size(400, 1024, few), of_size(0, 624, few), of_size(900, 1024, few)),
        "special": tuple(part.ravel() for part in np.meshgrid(SPECIAL, SPECIAL, SPECIAL)),
    }


def rounded_once(a, b, c):
    """By fractions; a sum that is zero or not finite is that of doubles, whose product then is exact enough."""
    if not (math.isfinite(a) and math.isfinite(b) and math.isfinite(c)):
        return c if math.isfinite(a) and math.isfinite(b) else a * b + c
    exact = Fraction(a) * Fraction(b) + Fraction(c)
    if exact == 0:
        return a * b + c if a * b == 0 and a * b == -c else 0.0
    try:
        return float(exact)
    except OverflowError:
        return math.inf if exact > 0 else -math.inf


def assert_same(found, expected):
    number = ~(np.isnan(found) & np.isnan(expected))
    np.testing.assert_array_equal(found[number].view(np.uint64), expected[number].view(np.uint64))


@pytest.mark.parametrize("kind", cases(30))
def test_it_is_the_fraction_rounded_once(kind):
    operands = cases(6_000)[kind]
    expected = [rounded_once(*each) for each in zip(*(part.tolist() for part in operands), strict=True)]
    assert_same(fma(*operands), np.array(expected))


LOOP = """
declare double @llvm.fma.f64(double, double, double)
define void @test_fma(ptr %a, ptr %b, ptr %c, ptr %out, i64 %count) {
start:
  br label %next
next:
  %i = phi i64 [ 0, %start ], [ %i1, %next ]
  %a_at = getelementptr double, ptr %a, i64 %i
  %b_at = getelementptr double, ptr %b, i64 %i
  %c_at = getelementptr double, ptr %c, i64 %i
  %out_at = getelementptr double, ptr %out, i64 %i
  %x = load double, ptr %a_at
  %y = load double, ptr %b_at
  %z = load double, ptr %c_at
  %r = call double @llvm.fma.f64(double %x, double %y, double %z)
  store double %r, ptr %out_at
  %i1 = add i64 %i, 1
  %more = icmp slt i64 %i1, %count
  br i1 %more, label %next, label %end
end:
  ret void
}"""


@pytest.mark.parametrize("kind", cases(30))
def test_it_is_the_processors_own(kind):
    pytest.importorskip("llvmlite")
    from workbench.engine.kernel import llvm

    if not llvm.has_fma():
        pytest.skip("this processor has none")
    call = llvm.compile_module(LOOP).function("test_fma", *[ctypes.c_void_p] * 4, ctypes.c_int64)
    operands = [np.ascontiguousarray(part) for part in cases(60_000)[kind]]
    expected = np.empty(len(operands[0]))
    call(*(part.ctypes.data for part in operands), expected.ctypes.data, len(expected))
    assert_same(fma(*operands), expected)


def test_it_takes_numbers_and_rows_as_numpys_own_functions_do():
    a, b = np.array([0.1, 0.2, -0.0]), np.float64(3.0)
    found = fma(a, b, np.array(1e-3))
    assert found.tolist() == [rounded_once(x, 3.0, 1e-3) for x in a.tolist()]
    assert float(fma(np.float64(0.1), np.float64(10.0), np.float64(-1.0))) == rounded_once(0.1, 10.0, -1.0) != 0

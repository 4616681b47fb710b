"""The elementary functions in both arithmetics, against many digits and against what C says of special numbers."""

import math

import numpy as np
import pytest

from workbench.engine.machines import elementary_functions as f
from workbench.engine.machines.further_elementary_functions import DOUBLE
from workbench.engine.machines.machine import MachineNumber, number
from workbench.engine.machines.numpy_spelling import Arrays

mpmath = pytest.importorskip("mpmath")  # it comes with sympy

RNG = np.random.default_rng(2)
ARITHMETICS = pytest.mark.parametrize("fused", [True, False], ids=["fused", "portable"])
QUARTERS = np.pi / 4 * np.arange(1, 200)  # where the quadrant changes, and where sine or cosine is nearly zero
FAR = np.round(RNG.uniform(0, 6.3e11, 500)) * (np.pi / 2)
ANGLES = np.concatenate(
    [
        QUARTERS,
        np.nextafter(QUARTERS, 0),
        np.nextafter(-QUARTERS, 0),
        RNG.uniform(-1, 1, 1000) * 10.0 ** RNG.uniform(0, 12, 1000),
        FAR,
        np.nextafter(FAR, 0),
    ]
)
MORE = DOUBLE.functions


def tiny(decades):
    """Numbers of both signs below 1 with even logarithms; for fewer than none above 1."""
    return RNG.choice([-1.0, 1.0], 500) * 10.0 ** -RNG.uniform(*sorted((0, decades)), 500)


def side(x):
    """The other side at the right angle, as the reader of graphs writes it."""
    return ((1.0 - x) * (x + 1.0)).do("sqrt")


CASES = {
    "sin": (lambda x: f.sine_or_cosine(f.reduce_angle(x), 0), ANGLES),
    "cos": (lambda x: f.sine_or_cosine(f.reduce_angle(x), 1), ANGLES),
    "exp": (f.exponential, np.concatenate([RNG.uniform(-707, 709, 1000), RNG.uniform(-1, 1, 500)])),
    "tanh": (f.hyperbolic_tangent, np.concatenate([RNG.uniform(-25, 25, 1000), 10.0 ** RNG.uniform(-20, 0, 500)])),
    "log": (f.logarithm, np.concatenate([10.0 ** RNG.uniform(-320, 308, 1000), RNG.uniform(0.5, 2, 500)])),
    "atan2": (f.arc_tangent, RNG.uniform(-1, 1, 1500), RNG.uniform(-1, 1, 1500)),
    "expm1": (MORE["expm1"], np.concatenate([RNG.uniform(-45, 709, 1000), RNG.uniform(-2, 2, 1000), tiny(300)])),
    "log1p": (MORE["log1p"], np.concatenate([abs(tiny(-300)), RNG.uniform(-1, 3, 1000), tiny(16), tiny(300)])),
    "sinh": (MORE["sinh"], np.concatenate([RNG.uniform(-710.4, 710.4, 1000), RNG.uniform(-3, 3, 1000), tiny(300)])),
    "cosh": (MORE["cosh"], np.concatenate([RNG.uniform(-710.4, 710.4, 1000), RNG.uniform(-3, 3, 1000), tiny(300)])),
    "asinh": (MORE["asinh"], np.concatenate([tiny(-300), RNG.uniform(-5, 5, 1000), tiny(300)])),
    "acosh": (MORE["acosh"], np.concatenate([1 + abs(tiny(15)), RNG.uniform(1, 5, 1000), 1 + abs(tiny(-300))])),
    "atanh": (MORE["atanh"], np.concatenate([1 - abs(tiny(15)), RNG.uniform(-1, 1, 1000), tiny(300)])),
    "hypot": (MORE["hypot"], np.concatenate([tiny(-300), tiny(5)]), np.concatenate([tiny(-300), tiny(5)])),
    "atan": (lambda x: f.arc_tangent(x, number(x.machine, 1.0)), np.concatenate([tiny(-300), tiny(300)])),
    "asin": (lambda x: f.arc_tangent(x, side(x)), np.concatenate([1 - abs(tiny(15)), RNG.uniform(-1, 1, 1000)])),
    "acos": (lambda x: f.arc_tangent(side(x), x), np.concatenate([1 - abs(tiny(15)), RNG.uniform(-1, 1, 1000)])),
}


def computed(function, fused, *arrays):
    machine = Arrays(fused)
    with np.errstate(all="ignore"):
        return np.asarray(function(*(MachineNumber(machine, np.asarray(array, float)) for array in arrays)).value)


@ARITHMETICS
@pytest.mark.parametrize("name", CASES)
def test_a_function_is_right_within_two_units_in_the_last_place(name, fused):
    function, *arrays = CASES[name]
    with mpmath.workprec(300):
        exact = [getattr(mpmath, name)(*each) for each in zip(*(x.tolist() for x in arrays), strict=True)]
        found = computed(function, fused, *arrays).tolist()
        off = np.array([float(abs(value - true)) for value, true in zip(found, exact, strict=True)])
    # near a zero: pi / 2 has 105 bits, and up to 6e11 times its last part is rounded, a number of 4e-5
    assert (off <= 2 * np.spacing(np.abs(np.array(exact, float))) + 1e-20).all()


@ARITHMETICS
def test_an_angle_beyond_the_reduction_has_no_sine(fused):
    found = computed(CASES["sin"][0], fused, [1e12, -1e12, 1.0001e12, -1e300, math.inf, math.nan])
    np.testing.assert_array_equal(np.isnan(found), [False, False, True, True, True, True])


@ARITHMETICS
def test_a_remainder_is_exact_whatever_the_sizes(fused):
    x = np.concatenate([of for low, high in ((-1074, -1000), (-300, 300), (900, 1023)) for of in [sizes(low, high)]])
    y = x * RNG.choice([-1, 1], len(x)) * 2.0 ** -RNG.uniform(-2, 51, len(x))
    near = RNG.random(len(x)) < 0.3  # quotients that are whole, but for their rounding
    y[near] = (x[near] / RNG.integers(1, 2**30, near.sum())).astype(float)
    x, y = x[y != 0], y[y != 0]
    found, expected = computed(f.remainder, fused, x, y), np.array(list(map(math.fmod, x, y)))
    np.testing.assert_array_equal(found.view(np.uint64), expected.view(np.uint64))


def sizes(low, high):
    return RNG.choice([-1.0, 1.0], 3000) * np.ldexp(1 + RNG.random(3000), RNG.integers(low, high, 3000))


NAN = math.nan
PAIRS = [(1.0, 2.0), (2.0, 1.0), (NAN, 1.0), (1.0, NAN), (0.0, -0.0), (-0.0, 0.0), (math.inf, -math.inf)]


@ARITHMETICS
def test_of_a_number_and_none_the_number_is_smaller_and_larger_and_of_two_zeros_the_first(fused):
    a, b = np.array(PAIRS).T
    for function, expected in (
        (f.smaller, [1.0, 1.0, 1.0, 1.0, 0.0, -0.0, -math.inf]),
        (f.larger, [2.0, 2.0, 1.0, 1.0, 0.0, -0.0, math.inf]),
    ):
        found = computed(function, fused, a, b)
        np.testing.assert_array_equal(found.view(np.uint64), np.array(expected).view(np.uint64))
        assert np.isnan(computed(function, fused, [NAN], [NAN])).all()


@ARITHMETICS
def test_the_sign_of_a_zero_is_that_zero_and_of_none_there_is_none(fused):
    found = computed(f.sign, fused, [3.0, -5e-324, 0.0, -0.0, NAN])
    np.testing.assert_array_equal(found, [1.0, -1.0, 0.0, 0.0, NAN])
    np.testing.assert_array_equal(np.signbit(found[:4]), [False, True, False, True])

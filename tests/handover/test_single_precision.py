"""Elementary functions and laws in single precision against doubles, against IEEE's floats, and against their own C."""

import casadi as ca
import numpy as np
import pytest

from tests.support.recorded_laws import by_hand
from workbench.engine.machines.formula_table import IN_SINGLE
from workbench.engine.machines.machine import MachineNumber
from workbench.engine.machines.numpy_spelling import Singles
from workbench.engine.machines.single_elementary_functions import LARGEST_ANGLE
from workbench.handover.single.rounding_rules import RELATIVE_ERRORS
from workbench.handover.single.single_precision import single_precision

COUNT = 1_000_000
ODD = np.array([0.0, -0.0, 1.0, -1.0, 1e-45, -1e-45, np.inf, -np.inf, np.nan], np.float32)


def computed(name, *operands):
    """The floats of a function of floats."""
    numbers = [MachineNumber(Singles(), np.asarray(operand, np.float32)) for operand in operands]
    with np.errstate(all="ignore"):
        return IN_SINGLE.of(name, *numbers).value


def spread(low, high, seed=0):
    """Floats with even logarithms and with even values, of both signs."""
    draws = np.random.default_rng(seed)
    even = draws.uniform(-high, high, COUNT // 2)
    sizes = np.exp(draws.uniform(np.log(low), np.log(high), COUNT // 2)) * draws.choice([-1, 1], COUNT // 2)
    return np.concatenate([even, sizes]).astype(np.float32)


def errors(name, got, wanted):
    """The largest error in units of 2^-24 of the value, and in units in the last place of the float."""
    off = np.abs(got.astype(float) - wanted)
    last = np.spacing(np.abs(wanted).astype(np.float32)).astype(float)
    return (off / np.maximum(np.abs(wanted), 2.0**-126)).max() * 2**24, (off / last).max()


@pytest.mark.parametrize(
    ("name", "of_doubles", "points"),
    [
        ("sin", np.sin, spread(1e-30, LARGEST_ANGLE)),
        ("cos", np.cos, spread(1e-30, LARGEST_ANGLE)),
        ("exp", np.exp, spread(1e-30, 87.0)),
        ("tanh", np.tanh, spread(1e-30, 12.0)),
        ("log", np.log, np.abs(spread(1e-45, 3e38)) + np.float32(1e-45)),
        ("log", np.log, np.abs(spread(1e-3, 2.0)) + np.float32(1e-45)),
        ("expm1", np.expm1, spread(1e-30, 87.0)),
        ("log1p", np.log1p, np.abs(spread(1e-30, 3e38))),
        ("log1p", np.log1p, spread(1e-30, 0.99)),
        ("sinh", np.sinh, spread(1e-30, 89.0)),
        ("cosh", np.cosh, spread(1e-30, 89.0)),
        ("asinh", np.arcsinh, spread(1e-30, 3e38)),
        ("acosh", np.arccosh, np.float32(1.0) + np.abs(spread(1e-6, 1e30))),
        ("atanh", np.arctanh, spread(1e-30, 0.99999)),
    ],
)
def test_functions_of_a_float_are_within_three_units_in_the_last_place(name, of_doubles, points):
    relative, units = errors(name, computed(name, points), of_doubles(points.astype(float)))
    assert relative <= RELATIVE_ERRORS[name]
    assert units < 3.0


def test_the_angle_of_two_floats_is_within_three_units_in_the_last_place():
    for y, x in ((spread(1e-3, 1.0), spread(1e-3, 1.0, seed=1)), (spread(1e-15, 1e15), spread(1e-15, 1e15, seed=1))):
        x = np.random.default_rng(2).permutation(x)
        relative, units = errors("atan2", computed("atan2", y, x), np.arctan2(y.astype(float), x.astype(float)))
        assert relative <= RELATIVE_ERRORS["atan2"]
        assert units < 3.0


def test_sine_and_cosine_keep_their_digits_at_every_multiple_of_a_quarter_turn():
    quarters = (np.arange(1, 5215) * (np.pi / 2)).astype(np.float32)
    for name, of_doubles in (("sin", np.sin), ("cos", np.cos)):
        assert errors(name, computed(name, quarters), of_doubles(quarters.astype(float)))[0] <= RELATIVE_ERRORS[name]


def test_an_angle_beyond_the_largest_has_no_sine():
    beyond = np.nextafter(np.float32(LARGEST_ANGLE), np.float32(np.inf))
    assert np.isnan(computed("sin", [beyond, -beyond, np.inf, np.nan])).all()
    assert np.isfinite(computed("cos", [LARGEST_ANGLE, -LARGEST_ANGLE])).all()


IEEE = {"asinh": np.arcsinh, "acosh": np.arccosh, "atanh": np.arctanh}


@pytest.mark.parametrize(
    "name", ["exp", "tanh", "log", "expm1", "log1p", "sinh", "cosh", "asinh", "acosh", "atanh", "hypot", "copysign"]
)
def test_functions_of_what_is_no_common_number_are_those_of_ieee(name):
    pairs = name in ("hypot", "copysign")
    given = [side.ravel() for side in np.meshgrid(ODD, ODD)] if pairs else [ODD]
    with np.errstate(all="ignore"):
        wanted = IEEE.get(name, getattr(np, name, None))(*given)
    got = computed(name, *given)
    np.testing.assert_allclose(got, wanted, rtol=3e-7, atol=0)
    numbers = ~np.isnan(wanted)
    assert name == "tanh" or (np.signbit(got) == np.signbit(wanted))[numbers].all()  # tanh -0 is 0 here


def test_the_length_of_two_floats_is_within_three_units_in_the_last_place():
    for low, high in ((1e-3, 1.0), (1e-44, 1e38)):
        y, x = spread(low, high), np.random.default_rng(2).permutation(spread(low, high, seed=1))
        relative, units = errors("hypot", computed("hypot", y, x), np.hypot(y.astype(float), x.astype(float)))
        assert relative <= RELATIVE_ERRORS["hypot"]
        assert units < 3.0


def test_the_angle_of_what_is_no_common_number_is_that_of_ieee():
    y, x = (side.ravel() for side in np.meshgrid(ODD, ODD))
    got, wanted = computed("atan2", y, x), np.arctan2(y, x)
    np.testing.assert_allclose(got, wanted, rtol=3e-7, atol=1e-44)
    numbers = ~np.isnan(wanted)
    assert (np.signbit(got) == np.signbit(wanted))[numbers].all()


def test_the_remainder_is_exact():
    patterns = np.random.default_rng(0).integers(0, 2**32, (2, COUNT), dtype=np.uint32)
    x, any_float = patterns.view(np.float32)
    x = np.where(np.isfinite(x), x, np.float32(1.0))
    for y in (any_float, x / np.random.default_rng(1).integers(1, 10_000, COUNT).astype(np.float32)):
        with np.errstate(all="ignore"):
            known = np.isfinite(y) & (np.abs(x / y) < 2**22)
        np.testing.assert_array_equal(computed("fmod", x, y)[known], np.fmod(x[known], y[known]))
    assert np.isnan(computed("fmod", [1.0, 2.0**24], [0.0, 1.0])).all()


def test_numbers_and_parameters_are_combined_in_doubles_and_rounded_once():
    law = by_hand(lambda y, k, p: p[0] * p[1] * y[0] + y[1], readings=2, p=(0.1, 0.3))
    y = np.random.default_rng(0).normal(size=(1000, 2))
    y32 = y.astype(np.float32)
    wanted = np.float32(0.1 * 0.3) * y32[:, 0] + y32[:, 1]
    np.testing.assert_array_equal(single_precision(law, 0, np.zeros((1000, 0)), y).u[:, 0], wanted)
    other = np.float32(0.7 * 0.9) * y32[:, 0] + y32[:, 1]
    np.testing.assert_array_equal(single_precision(law, 0, np.zeros((1000, 0)), y, p=[0.7, 0.9]).u[:, 0], other)


def test_what_depends_on_the_instant_alone_is_made_in_doubles_and_rounded_once():
    law = by_hand(lambda y, k, p: ca.exp(-1e-4 * k) * y)
    k, y = np.arange(100_000), np.random.default_rng(0).normal(size=(100_000, 1))
    got = single_precision(law, k, np.zeros((len(k), 0)), y).u[:, 0]
    wanted = np.exp(-1e-4 * k).astype(np.float32) * y[:, 0].astype(np.float32)
    assert (got == wanted).mean() > 0.999  # NumPy's own exponential has another last bit, here and there
    np.testing.assert_allclose(got, wanted, rtol=2e-7)


def test_rows_of_another_shape_are_refused_by_name():
    law = by_hand(lambda y, k, p: y[0] + y[1], readings=2)
    with pytest.raises(ValueError, match=r"single_precision\(y=...\).*\(3, 2\).*y\[0\], y\[1\]"):
        single_precision(law, 0, np.zeros((3, 0)), np.zeros((3, 1)))
    with pytest.raises(ValueError, match=r"single_precision\(k=...\)"):
        single_precision(law, 0.5, np.zeros((3, 0)), np.zeros((3, 2)))
    with pytest.raises(ValueError, match="parameters"):
        single_precision(law, 0, np.zeros((3, 0)), np.zeros((3, 2)), p=[1.0])

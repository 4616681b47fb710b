"""The algebra of units: its laws, texts that are refused, and the base units of the SI by another library."""

from fractions import Fraction
from functools import reduce

import casadi as ca
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import workbench as wb
from workbench.core.port import misfits
from workbench.core.units import (
    ONE,
    UNKNOWN_UNIT,
    Unit,
    UnitError,
    checked_unit,
    fill_unit,
    gain,
    in_base_units,
    per_second,
    read,
)
from workbench.engine.metrics.contract import Integral

WORDS = st.sampled_from(["m", "rad", "s", "V", "N", "°C", "%", "veh", "counts", "m2", "rad^(1-rho)"])
POWERS = st.fractions(min_value=-4, max_value=4, max_denominator=5)
UNITS = st.lists(st.tuples(WORDS, POWERS), max_size=5).map(
    lambda factors: [Unit(((word, Fraction(1)),)) ** power for word, power in factors]
)
PRODUCTS = UNITS.map(lambda units: reduce(Unit.__mul__, units, ONE))


@settings(max_examples=20)
@given(PRODUCTS)
def test_a_unit_that_is_printed_is_read_as_itself(unit):
    assert read(str(unit)) == unit
    assert checked_unit("f(unit=...)", str(unit)) == str(unit)


@settings(max_examples=20)
@given(PRODUCTS, PRODUCTS, PRODUCTS)
def test_units_are_a_commutative_group(a, b, c):
    assert a * b == b * a
    assert hash(a * b) == hash(b * a)
    assert (a * b) * c == a * (b * c)
    assert a * ONE == a
    assert a / a == ONE
    assert (a / b) * b == a


@settings(max_examples=20)
@given(PRODUCTS, PRODUCTS, POWERS, POWERS)
def test_powers_of_units_add_and_multiply(a, b, p, q):
    assert a**p * a**q == a ** (p + q)
    assert (a**p) ** q == a ** (p * q)
    assert (a * b) ** p == a**p * b**p


@settings(max_examples=20)
@given(PRODUCTS)
def test_an_unknown_unit_fits_any_and_makes_all_unknown(unit):
    assert UNKNOWN_UNIT.fits(unit)
    assert unit.fits(UNKNOWN_UNIT)
    assert unit * UNKNOWN_UNIT == UNKNOWN_UNIT / unit == UNKNOWN_UNIT**2 == UNKNOWN_UNIT
    assert str(UNKNOWN_UNIT) == "?"


@settings(max_examples=20)
@given(PRODUCTS, PRODUCTS)
def test_a_gain_times_what_it_takes_is_what_it_makes(out, of):
    assert read(gain(str(out), str(of))) * of == out
    assert gain(str(out), str(of), -1) == per_second(gain(str(out), str(of)))


@settings(max_examples=20)
@given(PRODUCTS)
def test_the_base_units_of_a_product_are_the_product_of_base_units(unit):
    (factor, base), other = in_base_units(read("mm N/min")), in_base_units(unit)
    product = in_base_units(read("mm N/min") * unit)
    assert product == (None if other is None else (factor * other[0], base * other[1]))


SAME = [
    "N*m",
    "m N",
    "N\N{MIDDLE DOT}m",
    "(N m)",
    "N m^2/m",
    "N**1 m",
    "N/m^-1",
    "(N^2 m^2)^(1/2)",
    "sqrt(N m) sqrt(N m)",
]


@pytest.mark.parametrize("text", SAME)
def test_a_newton_metre_is_the_same_however_it_is_written(text):
    assert read(text) == read("N m")
    assert not misfits(wb.layout(tau=text), wb.layout(tau="N m"))


PRINTED = {
    "N*m": "N m",
    "m, N*m": "m, N m",
    "J/kg/K": "J/(kg K)",
    "m/s": "m/s",
    "1": "1",
    "": "",
    "?": "?",
    "veh/h": "veh/h",
    "counts": "counts",
    "rad^(1-rho)/s^2": "rad^(1-rho)/s^2",
    "(rad/s^3)^(1/2)": "(rad/s^3)^(1/2)",
    "m/s or rad/s": "m/s or rad/s",
    "V/sqrt(Hz)": "V/sqrt(Hz)",
}


@pytest.mark.parametrize("text", PRINTED)
def test_a_unit_is_printed_as_it_was_written_but_for_stars_and_strokes(text):
    assert wb.layout(x=text)["x"].unit == PRINTED[text]


REFUSED = {
    "m//s": "a factor is missing before or after '/'",
    "/s": "a factor is missing before or after '/'",
    "m/": "a factor is missing before or after '/'",
    "N * * m": "a factor is missing before or after '*'",
    "m^": "'^' must stand between one factor and one power",
    "m^2^3": "'^' must stand between one factor and one power",
    "m^-": "'-' is no power",
    "m^(1/0)": "'(1/0)' is no power",
    "(m^99)^99": "a power in it is beyond 99",
    "N m/(rad s": "its brackets do not match",
    "N m)/(s": "its brackets do not match",
    "m ()": "a pair of brackets is empty",
    "(m)(s)": "'(m)(s)' lacks a space between two factors",
    "N m/rad s": "it can be read in two ways: put 'rad s' in brackets, or before '/'",
    "m" * 121: "it has 121 characters, more than 120",
    "rad, m//s": "a factor is missing before or after '/'",
}


@pytest.mark.parametrize("text", REFUSED)
def test_a_text_that_is_no_unit_is_refused_with_the_reason(text):
    with pytest.raises(ValueError) as error:
        wb.layout(v=text)
    assert str(error.value).startswith(f"`layout(v=...)` must be a unit, as 'N m/(rad s)' is, but {REFUSED[text]}; got")


def test_each_door_names_the_block_and_the_field_whose_unit_is_refused():
    with pytest.raises(ValueError, match=r"`Spring\.k = parameter\(unit=\.\.\.\)` must be a unit"):

        @wb.block
        class Spring:
            k: float = wb.parameter(default=1.0, unit="N//m")

    with pytest.raises(ValueError, match=r"`Step\(unit=\.\.\.\)` must be a unit, .* got 'm//s'"):
        wb.Step("v", "m//s", 1.0)
    with pytest.raises(ValueError, match=r"`Entry\(v, unit=\.\.\.\)` must be a unit"):
        wb.Ode.of("plant", *_one_state(), {"x": 0}, {"v": 0}, {"v": "m//s"})
    metric = Integral("size", "m//s", "size", lambda t, e: e, lambda integral, T: integral, signal="x")
    plant = wb.Ode.of("plant", *_one_state(), {"x": 0}, {"x": 0})
    with pytest.raises(ValueError, match=r"`Integral\(size, unit=\.\.\.\)` must be a unit"):
        wb.measure(plant, [metric], until=1.0, h=0.1)


def _one_state():
    x, none = wb.layout(x="m"), wb.layout()
    return x, none, (ca.SX.sym("t"), x.symbols(), none.symbols())


def test_ports_of_one_unit_in_two_spellings_make_a_loop():
    law = wb.PID(wb.layout(omega="rad*s^-1"), wb.layout(v="V"), Kp=1.0)
    loop = wb.ClosedLoop(wb.DCMotor(), controller=law, reference=wb.Step("omega", "1*rad/s", 1.0))
    assert loop.ode().outputs["omega"].unit == "rad/s"
    assert misfits(wb.layout(tau="N m"), wb.layout(tau="J")) == ["'tau' in [N m], where {gives} it in [J]"]


FILLED = [
    ("{x}/s", "rad/s", "rad/s^2"),
    ("{x}/s", "m/(kg s)", "m/(kg s^2)"),
    ("{x}/s", "", "1/s"),
    ("{x}/s", "?", "?/s"),
    ("1/({x})^2", "N m", "1/(N m)^2"),
    ("1/{x}^2", "N m", "1/(N^2 m^2)"),
    ("N m/{x}", "m s", "N/s"),
    ("{x}^(1-rho)/s^2", "rad", "rad^(1-rho)/s^2"),
    ("{x}", "m/s or rad/s", "m/s or rad/s"),
]


@pytest.mark.parametrize(("template", "unit", "printed"), FILLED)
def test_the_unit_of_a_signal_takes_its_place_as_a_whole(template, unit, printed):
    assert fill_unit(template, {"x": unit}) == printed


DERIVATIVES = [
    ("rad", 1, "rad/s"),
    ("rad", 2, "rad/s^2"),
    ("m/s", 1, "m/s^2"),
    ("m/s^2", 2, "m/s^4"),
    ("m, rad", 1, "m/s, rad/s"),
    ("", 1, "1/s"),
    ("1/s", 1, "1/s^2"),
    ("?", 2, "?"),
    ("V s", 1, "V"),
    ("°C", 1, "°C/s"),
]


@pytest.mark.parametrize(("unit", "order", "printed"), DERIVATIVES)
def test_a_derivative_is_per_second(unit, order, printed):
    assert per_second(unit, order) == printed


GAINS = [
    ("V", "rad", 0, "V/rad"),
    ("V", "rad/s", 0, "V s/rad"),
    ("V", "rad/s", -1, "V/rad"),
    ("N m", "rad", -1, "N m/(rad s)"),
    ("V", "m^3/h", 0, "V h/m^3"),
    ("V", "N m", 1, "V s/(N m)"),
    ("V", "", 0, "V"),
    ("V", "", -1, "V/s"),
    ("", "m", 0, "1/m"),
    ("", "", 1, "s"),
    ("V", "?", 0, "?"),
    ("N m, N", "rad, m", 0, "N m/rad, N/m"),
]


@pytest.mark.parametrize(("out", "of", "seconds", "printed"), GAINS)
def test_a_gain_is_what_it_makes_over_what_it_takes(out, of, seconds, printed):
    assert gain(out, of, seconds) == printed


SI = {
    "kg": "kilogram",
    "m": "meter",
    "s": "second",
    "A": "ampere",
    "K": "kelvin",
    "mol": "mole",
    "cd": "candela",
    "N": "newton",
    "J": "joule",
    "W": "watt",
    "Pa": "pascal",
    "V": "volt",
    "ohm": "ohm",
    "C": "coulomb",
    "F": "farad",
    "H": "henry",
    "T": "tesla",
    "Hz": "hertz",
    "g": "gram",
    "l": "liter",
    "cm": "centimeter",
    "mm": "millimeter",
    "ms": "millisecond",
    "min": "minute",
    "h": "hour",
}


@pytest.mark.parametrize("word", SI)
def test_base_units_are_those_of_another_library(word):
    units = pytest.importorskip("sympy.physics.units")
    base = {name: getattr(units, SI[name]) for name in ("kg", "m", "s", "A", "K", "mol", "cd")}
    factor, unit = in_base_units(read(word))
    product = factor.numerator * base["kg"] ** 0 / factor.denominator
    for name, power in unit.powers:
        product *= base[name] ** int(power)
    theirs = units.convert_to(getattr(units, SI[word]), list(base.values()))
    assert (theirs / product).simplify() == 1


def test_units_of_products_are_powers_of_base_units():
    assert in_base_units(read("N m/(rad s)")) == (1, read("kg m^2/(s^3 rad)"))
    assert in_base_units(read("N m/(rad s)"), angles=False) == in_base_units(read("W"))
    assert in_base_units(read("l/min")) == (Fraction(1, 60000), read("m^3/s"))
    assert in_base_units(read("J/(g K)")) == (1000, read("m^2/(s^2 K)"))
    assert in_base_units(read("V/sqrt(Hz)")) == (1, read("kg m^2/(s^(5/2) A)"))
    assert [in_base_units(read(text)) for text in ("rad^(1-rho)/s^2", "?", "mm^(1/2)", "furlong")] == [None] * 4


@given(st.text(max_size=40))
def test_any_text_is_a_unit_or_is_refused(text):
    try:
        unit = read(text)
    except UnitError:
        return
    assert read(str(unit)) == unit

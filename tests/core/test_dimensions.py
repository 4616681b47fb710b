"""Units of derivatives and gains."""

import pytest

from workbench.core.port import gain, per_second


@pytest.mark.parametrize(
    ("unit", "order", "expected"),
    [
        ("rad", 1, "rad/s"),
        ("rad", 2, "rad/s^2"),
        ("m/s", 1, "m/s^2"),
        ("m/s^2", 2, "m/s^4"),
        ("m, rad", 1, "m/s, rad/s"),
        ("", 1, "1/s"),
        ("1/s", 1, "1/s^2"),
        ("?", 2, "?"),
        ("V s", 1, "V s/s"),
    ],
)
def test_a_derivative_is_per_second(unit, order, expected):
    assert per_second(unit, order) == expected


@pytest.mark.parametrize(
    ("out", "of", "seconds", "expected"),
    [
        ("V", "rad", 0, "V/rad"),
        ("V", "rad/s", 0, "V s/rad"),
        ("V", "rad/s", -1, "V/rad"),
        ("N m", "rad", -1, "N m/(rad s)"),
        ("V", "m^3/h", 0, "V/(m^3/h)"),
        ("V", "N m", 1, "V s/(N m)"),
        ("V", "", 0, "V"),
        ("V", "", -1, "V/s"),
        ("", "m", 0, "1/m"),
        ("", "", 1, "s"),
        ("V", "?", 0, "?"),
        ("N m, N", "rad, m", 0, "N m/rad, N/m"),
    ],
)
def test_a_gain_is_what_it_makes_over_what_it_takes(out, of, seconds, expected):
    assert gain(out, of, seconds) == expected

"""What an expression can be while its symbols stay within their boxes."""

from fractions import Fraction

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.core.notation.program import walk
from workbench.proofs import interval
from workbench.proofs.interval import RULES, Interval, NoBound, evaluate

x, y = ca.SX.sym("x"), ca.SX.sym("y")

EXPRESSIONS = [
    ca.sin(x) * y + ca.cos(3 * x) / (2 + y**2),
    ca.tanh(x * y) - ca.exp(-(x**2)) + ca.sqrt(x**2),
    x**3 * y - x**-2,
    ca.if_else(x > y, x**2, ca.sin(y)),
    ca.fmod(ca.floor(3 * x), 2) * y + ca.ceil(y),
    ca.atan2(y, x) + ca.tan(x),
    ca.fmax(x, y) * ca.fabs(x - y) - ca.fmin(x, 2 * y),
    ca.fabs(x) ** 1.5 + ca.log(2 + ca.cos(x)),
    ca.sign(x) * y + ca.atan(x) + ca.sinh(y) - ca.cosh(x),
    ca.asin(ca.sin(x) / 2) + ca.acos(ca.cos(y) / 2),
    ca.logic_and(x > 0, y <= 1) + 2 * ca.logic_or(x == y, ca.logic_not(y != 1)),
    1 / (x - y) + (x + x) - 2 * y,
]
middles, widths = st.floats(-6, 6), st.floats(-9, 1).map(lambda power: 10**power)


@pytest.fixture(params=["balls", "doubles"])
def arithmetic(request, monkeypatch):
    if request.param == "balls" and not interval.ARB:
        pytest.skip("the extra `rigorous` is not installed")
    monkeypatch.setattr(interval, "ARB", request.param == "balls")


def enclosed(expression, low, high):
    boxes = {name: Interval(np.array([a]), np.array([b])) for name, a, b in zip("xy", low, high, strict=True)}
    part = evaluate(walk(expression), boxes)[0]
    return part.low[0], part.high[0]


@pytest.mark.parametrize("expression", EXPRESSIONS, ids=str)
@given(st.tuples(middles, middles), st.tuples(widths, widths), st.integers(0, 2**32 - 1))
def test_every_sampled_value_lies_in_its_interval(expression, middle, width, seed):
    middle, width = np.array(middle), np.array(width)
    low, high = enclosed(expression, middle - width, middle + width)
    assert low <= high
    points = np.random.default_rng(seed).uniform(-1, 1, (2, 200)) * width[:, None] + middle[:, None]
    corners = [[a, b] for a in (-1, 1) for b in (-1, 1)] * width + middle
    points = np.hstack([points, corners.T])
    values = np.array(ca.Function("f", [x, y], [expression])(points[:1], points[1:])).ravel()
    values = values[np.isfinite(values)]
    # CasADi's own value of a point is off by some roundings of what it is a sum of
    slack = 1e-13 * (1 + np.abs(values).max(initial=0.0))
    assert (values >= low - slack).all()
    assert (values <= high + slack).all()


@pytest.mark.parametrize(
    ("expression", "low", "high", "exact"),
    [
        (ca.sin(x), 0.0, 2.0, (0.0, 1.0)),
        (ca.cos(x), -1.0, 2.0, (np.cos(2.0), 1.0)),
        (ca.sin(x), -100.0, 100.0, (-1.0, 1.0)),
        (x**2, -1.0, 2.0, (0.0, 4.0)),
        (x * x, -1.0, 2.0, (0.0, 4.0)),
        (ca.tanh(x), -1.0, 2.0, (np.tanh(-1.0), np.tanh(2.0))),
        (ca.fabs(x), -3.0, 2.0, (0.0, 3.0)),
        (ca.sqrt(x), 0.0, 4.0, (0.0, 2.0)),
        (ca.cosh(x), -1.0, 2.0, (1.0, np.cosh(2.0))),
    ],
    ids=str,
)
@pytest.mark.usefixtures("arithmetic")
def test_the_interval_of_one_function_is_its_range(expression, low, high, exact):
    np.testing.assert_allclose(enclosed(expression, (low, 0), (high, 0)), exact, rtol=1e-14, atol=1e-15)


@pytest.mark.parametrize("name", sorted(interval.RANGES))
@pytest.mark.usefixtures("arithmetic")
def test_a_function_at_a_double_is_enclosed_within_a_few_last_places(name):
    points = np.random.default_rng(0).uniform(0.1, 0.9, 500)
    low, high = interval.at_points(name, points)
    values = interval.NUMPY[name](points)
    assert (low <= values).all()
    assert (values <= high).all()
    assert (high - low <= 64 * np.spacing(np.abs(values))).all()  # the arcs of Arb are some dozens wide at 53 bits


@pytest.mark.skipif(not interval.ARB, reason="the extra `rigorous` is not installed")
@pytest.mark.parametrize("name", sorted(interval.RANGES))
def test_the_library_is_right_within_the_doubt_that_stands_in_for_balls(name, monkeypatch):
    points = np.random.default_rng(1).uniform(0.001, 0.999, 5000)
    points = points if name in ("asin", "acos") else points * 20
    proved = interval.at_points(name, points)
    monkeypatch.setattr(interval, "ARB", False)
    assumed = interval.at_points(name, points)
    assert (assumed[0] <= proved[1]).all()
    assert (assumed[1] >= proved[0]).all()


@pytest.mark.parametrize("expression", [1 / x, ca.sqrt(x), ca.log(x), ca.tan(2 * x), x**-2, x**0.5], ids=str)
def test_a_pole_or_a_place_without_value_gives_the_whole_line(expression):
    assert enclosed(expression, (-1.0, 0), (1.0, 0)) == (-np.inf, np.inf)


def test_an_operation_without_an_interval_is_named():
    with pytest.raises(NoBound, match="ERF"):
        enclosed(ca.erf(x), (0, 0), (1, 1))


def test_rounding_goes_outward():
    low, high = enclosed(x + y, (0.1, 0.2), (0.1, 0.2))
    assert Fraction(low) < Fraction(0.1) + Fraction(0.2) < Fraction(high)
    assert high - low < 2e-16
    assert len(RULES) > 30

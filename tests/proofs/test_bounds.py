"""Certified extremes of expressions over boxes."""

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.proofs import interval
from workbench.proofs.bounds import bound_text, disturbance_bounds, enclose, extreme_eigenvalue, largest_norm
from workbench.proofs.branch_and_bound import definite
from workbench.proofs.interval import NoBound, guarantee

x = ca.SX.sym("x", 2)

# An expression, a box, and its exact range.
CLOSED = [
    (x[0] * x[1], -1.0, 2.0, (-2.0, 4.0)),
    (x[0] * ca.exp(-(x[0] ** 2)), -3.0, 3.0, (-np.exp(-0.5) / np.sqrt(2), np.exp(-0.5) / np.sqrt(2))),
    (1 / (2 + ca.cos(x[0])) + ca.sqrt(1 + x[1] ** 2), -3.5, 1.0, (4 / 3, 1 + np.sqrt(13.25))),
    (ca.sin(x[0]) + ca.sin(x[1]) + ca.sin(x[0] + x[1]), -np.pi, np.pi, (-1.5 * np.sqrt(3), 1.5 * np.sqrt(3))),
    (ca.tanh(x[0]) - ca.fabs(x[1] - 1), -2.0, 3.0, (np.tanh(-2.0) - 3, np.tanh(3.0))),
    (100 * (x[1] - x[0] ** 2) ** 2 + (1 - x[0]) ** 2, -2.0, 2.0, (0.0, 3609.0)),  # Rosenbrock
    (ca.SX(2.5) + 0 * x[0], -1.0, 1.0, (2.5, 2.5)),
]


@pytest.mark.parametrize(("expression", "low", "high", "exact"), CLOSED, ids=lambda case: str(case)[:40])
def test_an_enclosure_holds_the_exact_range_and_little_more(expression, low, high, exact):
    found = enclose(expression, x, low, high)
    assert found.complete
    assert found.low <= exact[0] <= exact[1] <= found.high
    scale = max(np.abs(exact))
    # the tolerance of 1e-8, and the squared width of the last cell that a search can tell from its best
    np.testing.assert_allclose([found.low, found.high], exact, rtol=0, atol=1.1e-8 * scale)
    value = ca.Function("f", [x], [expression])
    assert float(value(found.least.x)) == pytest.approx(found.least.value, abs=1e-13 * scale)
    assert float(value(found.greatest.x)) == pytest.approx(found.greatest.value, abs=1e-13 * scale)


numbers = st.floats(-2, 2).map(lambda number: round(number, 3))
coefficients = st.lists(numbers, min_size=6, max_size=6)


@settings(max_examples=6)
@given(coefficients, st.tuples(numbers, numbers), st.floats(0.01, 3))
def test_no_sampled_value_lies_beyond_an_enclosure(c, corner, width):
    f = c[0] * ca.sin(x[0] + c[1]) * ca.cos(c[2] * x[1]) + c[3] * ca.tanh(x[0] * x[1]) + c[4] * ca.exp(c[5] * x[1])
    low = np.array(corner)
    found = enclose(f, x, low, low + width, tolerance=1e-3, boxes=20_000)
    points = low[:, None] + width * np.random.default_rng(0).uniform(0, 1, (2, 2000))
    values = np.array(ca.Function("f", [x], [f])(points))
    slack = 1e-13 * np.abs(values).max()  # roundings of a point's value
    assert found.low is None or found.low <= values.min() + slack
    assert found.high is None or values.max() - slack <= found.high


@pytest.mark.parametrize("arb", [True, False])
def test_the_proof_does_not_depend_on_whose_sines_it_takes(arb, monkeypatch):
    if arb and not interval.ARB:
        pytest.skip("the extra `rigorous` is not installed")
    monkeypatch.setattr(interval, "ARB", arb)
    expression, low, high, exact = CLOSED[3]
    found = enclose(expression, x, low, high)
    assert found.low <= exact[0] <= exact[1] <= found.high
    assert guarantee() == ("ball arithmetic" if arb else "elementary functions taken as right within 4 last places")


def test_a_dip_that_no_sample_hits_is_found_by_the_boxes():
    # 1e-4 wide beside a grid of 3e-4: the search sees nothing of it, and the proof must not go past it
    dip = ca.cos(x[0]) - 3 * ca.exp(-(((x[0] - 0.51234) / 1e-5) ** 2))
    found = enclose(dip, x, -3.0, 3.0)
    assert found.low <= np.cos(0.51234) - 3
    assert found.low == pytest.approx(np.cos(0.51234) - 3, abs=1e-6)


def test_a_jump_is_bounded_by_its_values():
    found = enclose(ca.floor(x[0]) * ca.cos(x[1]), x, np.array([0.5, -1.0]), np.array([2.5, 1.0]))
    assert found.high >= 2
    assert found.high == pytest.approx(2, rel=1e-7)


@pytest.mark.parametrize(
    ("expression", "says"),
    [
        (1 / ca.sin(x[0] - 0.1234), r"no bound near \[0.123"),
        (ca.sqrt(x[0]), "none at"),
        (1 / x[0], "none at|no bound near"),
        (ca.log(x[0] + 1.0), "none at"),
        (ca.erf(x[0]), "ERF"),
    ],
    ids=str,
)
def test_a_pole_or_a_place_without_value_is_refused_by_name(expression, says):
    with pytest.raises(NoBound, match=says):
        enclose(expression, x, -1.0, 1.0)


def test_a_used_up_budget_is_said_and_what_was_proved_is_kept():
    wavy = ca.sin(9 * x[0]) * ca.sin(9 * x[1] + x[0] * x[1]) + ca.tanh(x[0] - x[1])
    found = enclose(wavy, x, -3.0, 3.0, boxes=100)
    assert not found.complete
    assert found.least.why == "the budget of 100 boxes was used up"
    coarse = enclose(wavy, x, -3.0, 3.0, boxes=2000, tolerance=0.1)
    assert coarse.complete
    assert coarse.low <= found.least.value


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: enclose(x, x, 0, 1), "takes one expression"),
        (lambda: enclose(x[0], x, 1, 0), r"`enclose\(low=..., high=...\)` needs finite low < high"),
        (lambda: enclose(x[0], x, 0, np.nan), "finite low < high"),
        (
            lambda: enclose(x[0], x, 0, 1, tolerance=0.0),
            r"`enclose\(tolerance=...\)` must be a positive, finite number",
        ),
        (
            lambda: enclose(x[0], x, 0, 1, tolerance=np.nan),
            r"`enclose\(tolerance=...\)` must be a positive, finite number",
        ),
        (lambda: largest_norm(ca.diag(x), x, 0, 1), r"must be a vector; got shape \(2, 2\)"),
        (lambda: extreme_eigenvalue(ca.diag(x), x, 0, 1, 0), "is 1 for the least or -1 for the greatest; got 0"),
        (lambda: extreme_eigenvalue(x, x, 0, 1, 1), r"must be square to have eigenvalues; got shape \(2, 1\)"),
        (lambda: enclose(x[0], x, np.zeros(3), 1), "numbers or vectors of 2"),
        (lambda: enclose(x[0] + ca.SX.sym("m"), x, 0, 1), "'m' is missing"),
    ],
)
def test_what_cannot_be_enclosed_is_refused(call, says):
    with pytest.raises(ValueError, match=says):
        call()


@given(st.floats(-1e6, 1e6, allow_subnormal=False))
def test_a_bound_that_is_printed_is_still_a_bound(bound):
    assert float(bound_text(bound, 1)) <= bound <= float(bound_text(bound, -1))
    assert float(bound_text(bound, -1)) - float(bound_text(bound, 1)) <= 1.000001e-8 * abs(
        bound
    )  # the difference is rounded


@pytest.mark.heavy
def test_the_extreme_eigenvalues_of_a_rotated_matrix_are_those_of_its_diagonal():
    c, s = ca.cos(x[0]), ca.sin(x[0])
    turn = ca.blockcat([[c, -s], [s, c]])
    matrix = turn @ ca.diag(ca.vertcat(1 + ca.cos(x[1]) ** 2, 5 - ca.sin(x[1]))) @ turn.T
    # both are reached on whole lines, along which every box must be small: three digits are enough here
    least, greatest = (extreme_eigenvalue(matrix, x, -np.pi, np.pi, sign, tolerance=1e-3) for sign in (1, -1))
    assert 1 - 1.001e-3 <= least.bound < 1
    assert 6 < greatest.bound <= 6 * 1.001001
    assert least.value == pytest.approx(1, abs=1e-14)
    assert greatest.value == pytest.approx(6, abs=1e-14)


@settings(max_examples=50)
@given(st.integers(1, 6), st.floats(-1e-13, 1e-13), st.integers(0, 2**32 - 1))
def test_a_matrix_that_is_not_definite_is_never_called_so(n, least, seed):
    rng = np.random.default_rng(seed)
    Q = np.linalg.qr(rng.normal(size=(n, n)))[0]
    values = np.concatenate([[least], rng.uniform(0.1, 10, n - 1)])
    B = (Q * values) @ Q.T
    B = (B + B.T) / 2
    exact = float(np.linalg.eigvalsh(B)[0])
    if definite(B[None])[0]:
        assert exact > -2e-15 * n  # what eigvalsh itself can be wrong by
    assert definite((B + np.eye(n) * 1e-10)[None])[0]


t = ca.SX.sym("t")
SINES = ca.vertcat(3 * ca.sin(2 * t), 4 * ca.sin(2 * t))  # 5 sin 2t along (3, 4) / 5


def test_the_bounds_of_a_sine_disturbance_are_proved_in_closed_form():
    size, slope = disturbance_bounds(SINES, t, 20.0)
    assert 5.0 <= size.bound <= 5.0000001
    assert 10.0 <= slope.bound <= 10.0000002


def test_the_bound_of_a_sum_of_sines_is_what_a_dense_grid_sees():
    size, _ = disturbance_bounds(ca.sin(t) + ca.sin(ca.sqrt(2) * t) / 2, t, 50.0)
    dense = np.linspace(0, 50, 1_000_001)
    seen = np.abs(np.sin(dense) + np.sin(np.sqrt(2) * dense) / 2).max()
    assert seen <= size.bound == pytest.approx(seen, rel=1e-7)


def test_a_saturated_disturbance_is_bounded_by_its_own_interval():
    # its slope is up to 1000, and its tops are flat to 4e-9: no tangent would do
    size, slope = disturbance_bounds(ca.tanh(10 * ca.sin(100 * t)), t, 100.0)
    assert size.bound == pytest.approx(1.0, rel=2e-8)
    assert slope.bound == pytest.approx(1000.0, rel=2e-8)


@pytest.mark.parametrize(("D", "says"), [(ca.sign(ca.sin(t)), "SIGN"), (1 / (t - 3.3), "3.3"), (SINES * x[0], "'x_0'")])
def test_a_disturbance_without_a_slope_or_a_bound_is_refused_by_name(D, says):
    with pytest.raises(ValueError, match=says):
        disturbance_bounds(D, t, 20.0)

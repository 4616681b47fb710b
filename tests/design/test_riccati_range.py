"""Equations with numbers from the least float to the largest: an answer is right, and all else is refused in words."""

from __future__ import annotations

import flint
import numpy as np
import pytest

from tests.support import riccati_oracles as oracle
from workbench.design.matrices import DesignError
from workbench.design.riccati import care, dare, discrete_lyapunov, lyapunov

BITS = 4000  # so that no difference of two floats is lost, whatever their sizes


def test_an_answer_whose_square_vanishes_is_right_to_its_last_digit():
    found = lyapunov([[-2.47e95]], [[6e-81]])
    np.testing.assert_allclose(found.X, 6e-81 / 2.47e95 / 2, rtol=2 * np.finfo(float).eps)
    assert found.certificate.error < 1e-15
    assert 1 < found.certificate.condition < 100


@pytest.mark.parametrize("solve", [lyapunov, discrete_lyapunov])
def test_an_answer_beyond_the_range_of_floats_is_refused(solve):
    E = np.diag([1e-99, 1e-120])
    with pytest.raises(DesignError, match="the largest entry of X lies beyond the range of floating-point numbers"):
        solve(-0.5 * E, 1e99 * np.eye(2), E)


def some(rng, *shape):
    exponent = [
        lambda: rng.uniform(-320, 308, shape),
        lambda: rng.uniform(-100, 100) + rng.normal(size=shape),
        lambda: rng.choice([-323.0, -308, -155, -99, 0, 99, 155, 307], shape),
        lambda: rng.normal(size=shape),
    ][rng.integers(4)]()
    return rng.choice([-1, 1], shape) * 10.0**exponent * (rng.random(shape) < 0.8)


@pytest.mark.parametrize("solve", [lyapunov, discrete_lyapunov])
def test_linear_equations_of_any_magnitude_are_right_or_refused(solve):
    answers = 0
    for seed in range(50):
        rng = np.random.default_rng(seed)
        n = int(rng.integers(1, 4))
        A, Q = some(rng, n, n), np.tril(some(rng, n, n))
        Q = Q + np.tril(Q, -1).T
        try:
            found = solve(A, Q)
        except ValueError as error:
            assert str(error).startswith(f"`{solve.__name__}(A, Q)`: ")  # noqa: PT017  the words are ours
            continue
        X = exactly(A, Q, solve is discrete_lyapunov)
        assert abs(found.X - X).max() <= (10 * found.certificate.error + 1e-15) * abs(X).max()  # a rough estimate
        answers += 1
    assert answers > 10


@pytest.mark.parametrize("solve", [care, dare])
def test_riccati_equations_of_any_magnitude_are_answered_or_refused_in_words(solve):
    answers = 0
    for seed in range(100):
        rng = np.random.default_rng(seed)
        n, m = (int(size) for size in rng.integers(1, 4, 2))
        Q, R = np.diag(np.abs(some(rng, n))), np.diag(np.abs(some(rng, m)))
        try:
            found = solve(some(rng, n, n), some(rng, n, m), Q, R)
        except ValueError as error:
            assert str(error).startswith(f"`{solve.__name__}(A, B, Q, R)`: ")  # noqa: PT017
            continue
        assert np.isfinite(found.X).all()
        assert np.isfinite(found.K).all()
        assert 0 <= found.certificate.error <= 1e-4
        answers += 1
    assert answers > 4


def exactly(A, Q, discrete):
    """The solution of A X + X A' + Q = 0, or A X A' - X + Q = 0, as n^2 equations."""
    flint.ctx.prec = BITS
    n, a = len(A), oracle.exact(A)
    places = [(i, j) for i in range(n) for j in range(n)]
    rows = [
        [a[i, k] * a[j, m] - (i == k) * (j == m) if discrete else a[i, k] * (j == m) + (i == k) * a[j, m]
         for k, m in places]
        for i, j in places
    ]  # fmt: skip
    known = flint.arb_mat(n * n, 1, [-flint.arb(float(Q[place])) for place in places])
    return oracle.floats(flint.arb_mat(rows).solve(known)).reshape(n, n)

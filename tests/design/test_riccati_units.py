"""The units of states and inputs change no digit of an answer and refuse none: powers of two round nothing."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support import riccati_oracles as oracle
from tests.support.cases import heavy_but
from workbench.design.riccati import care, dare

EPS = np.finfo(float).eps
POWERS = pytest.mark.parametrize("power", [10, 20, 30])


def units(rng, power, size):
    return np.exp2(rng.integers(-power, power + 1, size))


@POWERS
def test_a_state_that_nothing_drives_is_solved_in_all_units(power):
    """Example 2.1 of Benner, Laub and Mehrmann by its closed form: balancing leaves its second state alone."""
    for eps in (1.0, 1e-2, 1e-4):
        A, B, Q, R = np.diag([1.0, -2.0]), np.array([[eps], [0.0]]), np.ones((2, 2)), np.eye(1)
        root = np.sqrt(1 + eps**2)
        across = 1 / (2 + root)
        X = np.array([[(1 + root) / eps**2, across], [across, (1 - (eps * across) ** 2) / 4]])
        for seed in range(8):
            rng = np.random.default_rng(seed)
            x, u = units(rng, power, 2), units(rng, power, 1)
            found = care(A / x[:, None] * x, B / x[:, None] * u, Q * x[:, None] * x, R * u[:, None] * u)
            np.testing.assert_allclose(found.X / x[:, None] / x, X, rtol=8 * EPS)  # the form rounds some six times
            assert oracle.away(found.X, X * x[:, None] * x) <= 2 * found.certificate.error + 8 * EPS


def sparse(seed):
    """A chain of states with a few other entries; most costs see a part of it."""
    rng = np.random.default_rng(seed)
    n, m = int(rng.integers(2, 7)), int(rng.integers(1, 4))

    def some(*shape):
        return rng.normal(size=shape) * (rng.random(shape) < 0.5) * 10 ** rng.normal(size=shape)

    A = some(n, n) * (1 if seed % 2 else 0.2) + np.eye(n, k=1)
    C, B = some(n, n), some(n, m)
    B[-1, 0] = 1.0
    return A, B, C.T @ C, np.diag(10 ** rng.normal(size=m))


@pytest.mark.parametrize("solve", heavy_but([care, dare], care))
def test_new_units_change_no_digit(solve):
    solved = 0
    for seed in range(12):
        A, B, Q, R = sparse(seed)
        try:
            first = solve(A, B, Q, R)
        except ValueError:
            continue  # some of them have no answer in any units
        rng = np.random.default_rng(100 + seed)
        x, u = units(rng, 30, len(A)), units(rng, 30, len(R))
        second = solve(A / x[:, None] * x, B / x[:, None] * u, Q * x[:, None] * x, R * u[:, None] * u)
        np.testing.assert_array_equal(second.X, first.X * x[:, None] * x)
        np.testing.assert_array_equal(second.K, first.K / u[:, None] * x)
        np.testing.assert_array_equal(second.poles, first.poles)
        assert second.certificate.residual == first.certificate.residual
        assert second.certificate.decay_rate == first.certificate.decay_rate
        solved += 1
    assert solved >= 8
